//! The plant against published curves: every effect of the air and of the vehicle's parts, alone.
//!
//! In: the settings of a scenario. Out: pictures with the plant's curve beside the published one, and points that compare both in
//! numbers. The published values are computed here from the formulas of their sources; the plant's values come from the code that flies.

mod rotor;
mod air;
mod parts;

use serde::Serialize;

use super::pictures::{Curve, Picture};
use super::series::EvaluateError;
use twin_core::notation::GRAVITY_M_S2;
use twin_scenario::Scenario;

/// One comparison of the plant with a source.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// Quantity and where it is compared.
    pub at: String,
    /// Value of the plant.
    pub twin: f64,
    /// Value of the source.
    pub published: f64,
    /// Largest difference that is allowed.
    pub allowed: f64,
    /// Unit of all three.
    pub unit: &'static str,
}

impl Point {
    fn new(
        at: impl Into<String>,
        [twin, published]: [f64; 2],
        allowed: f64,
        unit: &'static str,
    ) -> Self {
        Self { at: at.into(), twin, published, allowed, unit }
    }

    /// Whether plant and source agree.
    pub fn agrees(&self) -> bool {
        (self.twin - self.published).abs() <= self.allowed
    }
}

/// One effect with its source, its pictures and its points.
#[derive(Clone, Debug)]
pub struct Section {
    /// Name of the effect.
    pub title: &'static str,
    /// Where the published values come from, and what the pictures show.
    pub source: &'static str,
    /// Pictures.
    pub pictures: Vec<Picture>,
    /// Points.
    pub points: Vec<Point>,
}

/// All effects of the plant that flies `scenario`. A single rotor is examined at the speed at which it gives `thrust_n` in still air, N; `None`
/// is its part of the vehicle's weight.
///
/// # Errors
/// [`EvaluateError`] if a flight of the scenario cannot be built.
pub fn sections(scenario: &Scenario, thrust_n: Option<f64>) -> Result<Vec<Section>, EvaluateError> {
    let settings = scenario.settings.plant();
    let weight_n = scenario.robot()?.total_mass_kg() * GRAVITY_M_S2;
    let thrust_n = thrust_n.unwrap_or(weight_n / settings.vehicle.rotors.len() as f64);
    Ok(vec![
        rotor::axial(&settings.vehicle.rotor, thrust_n),
        rotor::edgewise(&settings.vehicle.rotor, thrust_n),
        rotor::lag(&settings.vehicle.rotor, thrust_n),
        air::ground(&settings),
        air::wake(&settings),
        air::drag(scenario)?,
        air::turbulence(&settings.wind),
        parts::battery(&settings.vehicle.battery),
        parts::servo(&settings.vehicle.servo),
        parts::arm(scenario)?,
    ])
}

/// A curve of the plant.
fn twin(name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
    Curve { name: name.to_owned(), points: points.into_iter().collect(), measured: false }
}

/// A published curve, drawn in black.
fn published(name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
    Curve { measured: true, ..twin(name, points) }
}

/// `steps` + 1 values from `from` to `to`.
fn range(from: f64, to: f64, steps: u32) -> impl Iterator<Item = f64> + Clone {
    (0..=steps).map(move |i| from + (to - from) * f64::from(i) / f64::from(steps))
}

/// The zero of the falling or rising `f` between `low` and `high`.
fn zero(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let rises = f(high) > f(low);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == rises { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

fn picture(title: &str, x: &str, y: &str, curves: Vec<Curve>) -> Picture {
    Picture {
        title: title.to_owned(),
        x: x.to_owned(),
        y: y.to_owned(),
        curves,
        ..Picture::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_agrees_with_its_source_and_names_it() {
        let file =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/hover.toml");
        let scenario = Scenario::load(&file, &[]).expect("it loads");
        let sections = sections(&scenario, None).expect("it flies");
        assert_eq!(sections.len(), 10);
        for section in &sections {
            assert!(section.source.len() > 20 && !section.points.is_empty(), "{}", section.title);
            for point in &section.points {
                assert!(point.agrees(), "{}: {point:?}", section.title);
            }
            for picture in &section.pictures {
                assert!(picture.svg().contains("<svg"), "{}", picture.title);
            }
        }
    }

    #[test]
    fn a_point_that_is_off_does_not_agree() {
        assert!(Point::new("x", [1.0, 1.05], 0.06, "m").agrees());
        assert!(!Point::new("x", [1.0, 1.07], 0.06, "m").agrees());
        assert!(!Point::new("x", [f64::NAN, 1.0], 0.06, "m").agrees());
    }

    #[test]
    fn the_zero_of_a_line_is_found_whether_it_rises_or_falls() {
        assert!((zero(|x| x - 0.3, 0.0, 1.0) - 0.3).abs() < 1e-12);
        assert!((zero(|x| 0.3 - x, 0.0, 1.0) - 0.3).abs() < 1e-12);
    }
}
