//! Phases of made-up flights whose truth is known.

use nalgebra::Vector1;

use super::*;
use twin_core::elementary::sin;

/// Thrust of hovering in the made-up flights.
const HOVER: f64 = 0.5;

struct Made {
    times_s: Vec<f64>,
    thrust: Series<1>,
    position: Ticks<3>,
    eta: Ticks<3>,
}

/// A flight of 40 s: `at` gives thrust, height and roll at a time; a sway of 0.2 m belongs to every height above the ground.
fn made(at: impl Fn(f64) -> (f64, f64, f64)) -> Made {
    let times_s: Vec<f64> = (0..4000).map(|tick| f64::from(tick) * TICK_S).collect();
    let thrust = Series::new(times_s.iter().map(|t| (*t, Vector1::new(at(*t).0))));
    let sway = |t: f64, z: f64| if z > 0.0 { 0.2 * sin(2.0 * t) } else { 0.0 };
    let place = |t: &f64| Some(Vector3::new(sway(*t, at(*t).1), 0.0, at(*t).1));
    let position = times_s.iter().map(place).collect();
    let eta = times_s.iter().map(|t| Some(Vector3::new(at(*t).2, 0.0, 0.0))).collect();
    Made { times_s, thrust, position, eta }
}

fn judge(made: &Made, landed: Option<&Flags>) -> Vec<(Phase, f64, f64)> {
    let Made { times_s, thrust, position, eta } = made;
    let thrust = Some(thrust);
    let evidence = Evidence { times_s, thrust, position, eta, landed, armed: None };
    let by = evidence.yardsticks(LEAST_THRUST);
    let found = spans(times_s, &evidence.judge(&by));
    found.iter().map(|span| (span.phase, span.from_s, span.to_s)).collect()
}

/// Heights of a flight from 10 s to 30 s that climbs and sinks at 1 m/s to 1 m.
fn height(t_s: f64) -> f64 {
    (t_s - 10.0).min(30.0 - t_s).clamp(0.0, 1.0)
}

fn air_s(found: &[(Phase, f64, f64)]) -> f64 {
    found.iter().filter(|(phase, ..)| *phase == Phase::Air).map(|(_, from, to)| to - from).sum()
}

#[test]
fn a_flight_has_ground_take_off_air_landing_and_ground() {
    let flight = made(|t| (if (10.0..30.0).contains(&t) { HOVER } else { 0.0 }, height(t), 0.0));
    let found = judge(&flight, None);
    let phases: Vec<Phase> = found.iter().map(|(phase, ..)| *phase).collect();
    let order = [Phase::Ground, Phase::TakeOff, Phase::Air, Phase::Landing, Phase::Ground];
    assert_eq!(phases, order, "{found:?}");
    // Take-off and landing last as long as the climb of 0.3 m at 1 m/s.
    assert!((air_s(&found) - 19.4).abs() < 0.1, "{found:?}");
}

#[test]
fn props_that_turn_on_the_ground_are_no_flight() {
    let thrust = |t: f64| match t {
        t if (2.0..10.0).contains(&t) => 0.6 * HOVER,
        t if (10.0..30.0).contains(&t) => HOVER,
        _ => 0.0,
    };
    let found = judge(&made(|t| (thrust(t), height(t), 0.0)), None);
    assert!((air_s(&found) - 19.4).abs() < 0.2, "{found:?}");
}

#[test]
fn the_land_detector_keeps_a_shaking_vehicle_on_the_ground() {
    // It shakes on a boat; the height of the take-off place moves, so only the detector knows.
    let shaken = |t: f64| if t < 10.0 { 0.05 + 0.05 * sin(6.0 * t) } else { 0.05 + height(t) };
    let thrust = |t: f64| if t < 30.0 { HOVER } else { 0.0 };
    let flight = made(|t| (thrust(t), shaken(t), 0.0));
    let flags =
        Flags::new((0..40).map(|t| (f64::from(t), f64::from(u8::from(!(10..30).contains(&t))))));
    let (told, untold) = (judge(&flight, Some(&flags)), judge(&flight, None));
    assert!(air_s(&told) < 20.5 && air_s(&told) > 18.0, "{told:?}");
    assert!(air_s(&untold) > 25.0, "{untold:?}");
}

#[test]
fn a_vehicle_that_is_carried_does_not_fly() {
    let found = judge(&made(|t| (0.0, height(t), 0.0)), None);
    assert!(found.iter().all(|(phase, ..)| *phase != Phase::Air), "{found:?}");
    assert!(found.iter().any(|(phase, ..)| *phase == Phase::Carried), "{found:?}");
}

#[test]
fn a_flight_that_tips_over_ends_in_a_crash() {
    let roll = |t: f64| if t > 29.3 { 1.5 } else { 0.0 };
    let flight =
        made(|t| (if (10.0..30.0).contains(&t) { HOVER } else { 0.0 }, height(t), roll(t)));
    let found = judge(&flight, None);
    let crash = found.iter().find(|(phase, ..)| *phase == Phase::Crash).expect("a crash");
    assert!((crash.1 - 29.3).abs() < 0.05, "{found:?}");
}

#[test]
fn a_vehicle_that_tumbles_after_it_tipped_over_does_not_fly_again() {
    let roll = |t: f64| if (27.0..28.0).contains(&t) { 1.5 } else { 0.0 };
    let flight =
        made(|t| (if (10.0..30.0).contains(&t) { HOVER } else { 0.0 }, height(t), roll(t)));
    let found = judge(&flight, None);
    let after = found.iter().filter(|(phase, from, _)| *phase == Phase::Air && *from > 27.0);
    assert_eq!(after.count(), 0, "{found:?}");
}

#[test]
fn a_dip_is_no_landing_and_a_spike_is_no_flight() {
    let thrust = |t: f64| match (t * 100.0).round() as i32 {
        100..110 | 1000..2000 | 2020..3000 => HOVER,
        _ => 0.0,
    };
    let found = judge(&made(|t| (thrust(t), height(t), 0.0)), None);
    assert_eq!(found.iter().filter(|(phase, ..)| *phase == Phase::Air).count(), 1, "{found:?}");
    assert!(found[0].2 > 9.9, "{found:?}");
}
