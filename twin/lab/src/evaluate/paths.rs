//! The path of a mission seen from above: reference and flown path.

use super::pictures::{Curve, Picture};
use super::series::EvaluateError;
use twin_scenario::{Scenario, fly};

/// Number of ticks between two points of the path.
const EVERY: usize = 5;

/// Flies `scenario` and draws its path from above, from lift-off of the payload to its release; m in the world frame.
///
/// # Errors
/// [`EvaluateError`] if the flight cannot be built.
pub fn path(scenario: &Scenario, name: &str) -> Result<Picture, EvaluateError> {
    let (mut asked, mut flown, mut ticks) = (Vec::new(), Vec::new(), 0_usize);
    let report = fly(scenario, &mut |tick| {
        ticks += 1;
        if ticks % EVERY == 0 && tick.reference.transporting {
            let at = tick.truth.as_ref().map_or(&*tick.measurement.chi, |truth| &truth.chi);
            asked.push((tick.reference.chi_des[0], tick.reference.chi_des[1]));
            flown.push((at[0], at[1]));
        }
    })?;
    Ok(Picture {
        title: format!("{}, {}", report.scenario, report.verdict),
        x: "x, m".to_owned(),
        y: "y, m".to_owned(),
        curves: vec![
            Curve { name: "asked for".to_owned(), points: asked, measured: true },
            Curve { name: name.to_owned(), points: flown, measured: false },
        ],
        marks: Vec::new(),
        map: true,
    })
}
