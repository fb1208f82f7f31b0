//! The scenarios as tests catch a controller with a wrong sign.

use std::path::Path;

use twin_core::control::{Controller, Gains, Input};
use twin_core::flight::Flight;
use twin_core::tick::{ControlState, Setpoint};
use twin_scenario::{Assessor, Scenario};

use super::Folder;

/// A controller whose sliding variable pushes the vehicle in the wrong direction.
#[derive(Clone)]
struct Inverted(Box<dyn Controller>);

impl Controller for Inverted {
    fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState) {
        let mut gains = *gains;
        (0..3).for_each(|row| gains.damping[row] = -gains.damping[row]);
        self.0.control(input, &gains)
    }
}

#[test]
fn a_controller_with_its_sign_flipped_is_caught_with_metric_bound_value_and_second() {
    let folder = Folder::new("flipped");
    let file = folder.hover(
        "flipped",
        "[[checks]]\nsignal = \"position_error_m\"\nmax = 0.3\n[expect]\nverdict = \"completed\"\n",
    );
    let mut scenario = Scenario::load(Path::new(&file), &[]).expect("it loads");
    scenario.settings.task.duration_s = 15.0;
    let mut parts = scenario.parts().expect("it builds");
    parts.controller = Box::new(Inverted(parts.controller));
    let mut flight = Flight::new(parts);
    let mut assessor = Assessor::new(&scenario);
    let mut crossed_s = None;
    let end = loop {
        let tick = flight.tick();
        let truth = tick.truth.as_ref().expect("it is simulated");
        let error = (truth.chi - *tick.reference.chi_des).fixed_rows::<3>(0).norm();
        if error > 0.3 && crossed_s.is_none() {
            crossed_s = Some(tick.measurement.t_s);
        }
        if let Some(end) = assessor.add(&tick) {
            break end;
        }
    };
    let report = assessor.finish(end, flight.state_hash());
    assert!(!report.passed);
    let broken = report.broken.iter().find(|b| b.name == "position_error_m").expect("it is caught");
    assert_eq!(Some(broken.at_s), crossed_s, "{broken}");
    assert!(broken.value.is_some_and(|value| value > 0.3) && broken.allowed == "at most 0.3");
    assert!(report.broken.iter().any(|broken| broken.name == "verdict"), "{:?}", report.verdict);
    // The bound is broken before the crash, so a message names it first.
    assert!(report.broken.is_sorted_by_key(|broken| broken.at_s), "{:?}", report.broken);
    assert_eq!(report.broken[0].name, "position_error_m");
}
