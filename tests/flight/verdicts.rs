//! What a hover or a path must do to be completed.

use twin_core::tick::{EventKind, Tick};
use twin_scenario::Verdict;

use super::flown::{flown, scenario};

/// The bare quadrotor in a hover of 4 s.
const HOVER: [&str; 2] = ["task.kind=hover", "task.duration_s=4.0"];

/// The quadrotor weighs 2 kg, so four rotors of 3 N cannot lift it.
const WEAK: &str = "vehicle.rotor.max_thrust_n=3.0";

fn told(ticks: &[Tick], kind: EventKind) -> Vec<f64> {
    let told = ticks.iter().filter(|tick| tick.events.iter().any(|event| event.kind == kind));
    told.map(|tick| tick.measurement.t_s).collect()
}

#[test]
fn a_hover_on_the_floor_is_not_completed() {
    // It falls by a hand's breadth; that is not the question here.
    let low = ["task.start_position_m=[0.0, 0.0, 0.2]", WEAK, "verdict.crash_n=1000.0"];
    let (report, ticks) = flown(&scenario("quadrotor", &[&HOVER[..], &low].concat()));
    assert_eq!(report.verdict, Verdict::Grounded, "{}", report.reason);
    for part in ["rests on a surface", "position RMSE", "allowed 0.5 m", "rotors saturated for"] {
        assert!(report.reason.contains(part), "{}", report.reason);
    }
    // It is saturated from the first tick on, so the first second of it is full after 1 s.
    let told = told(&ticks, EventKind::Saturation);
    assert!(told.len() == 1 && (told[0] - 1.0).abs() < 0.02, "{told:?}");
}

#[test]
fn a_hover_far_from_its_place_is_not_completed() {
    // Without a table in reach it falls by about 3 m in the 4 s and does not meet the floor.
    let high = ["task.start_position_m=[0.0, 0.0, 5.5]", "vehicle.rotor.max_thrust_n=4.85"];
    let (report, _) = flown(&scenario("quadrotor", &[&HOVER[..], &high].concat()));
    assert_eq!(report.verdict, Verdict::OffCourse, "{}", report.reason);
    assert!(report.reason.contains("strayed"), "{}", report.reason);
}

#[test]
fn the_bound_of_the_error_is_a_setting_and_stands_in_the_reason() {
    let (report, ticks) = flown(&scenario("quadrotor", &HOVER));
    assert_eq!(report.verdict, Verdict::Completed, "{}", report.reason);
    assert!(report.reason.contains("position RMSE") && report.reason.contains("allowed 0.5 m"));
    assert!(!report.reason.contains("saturated") && told(&ticks, EventKind::Saturation).is_empty());
    // The metric is computed elsewhere, from the same definition.
    let rmse_m = report.metrics["position_rmse_m"];
    assert!(report.reason.contains(&format!("{rmse_m:.3} m")), "{rmse_m} m: {}", report.reason);
    let less = format!("verdict.error_m={}", rmse_m * 0.9);
    let (report, _) = flown(&scenario("quadrotor", &[&HOVER[..], &[&less]].concat()));
    assert_eq!(report.verdict, Verdict::OffCourse, "{}", report.reason);
}
