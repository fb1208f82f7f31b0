//! Changes of the world have the effect that physics predicts.

use twin_core::elementary::{powf, squared};
use twin_core::tick::{EventKind, Tick};

use super::flown::{flown, mean, scenario};

/// Weight of a gram of payload, N.
const GRAM_N: f64 = 9.81e-3;

/// Error of the mean lift that two seconds of sensor noise leave, N.
const FORCE_TOLERANCE_N: f64 = 0.1;

/// Thrust of all rotors, N.
fn lift_n(tick: &Tick) -> f64 {
    tick.truth.as_ref().map_or(0.0, |truth| truth.rotor_thrust_n.iter().sum())
}

/// Thrust that the rotors would give at their speed far from the ground, N.
fn spun_n(tick: &Tick) -> f64 {
    let budget = tick.truth.as_ref().and_then(|truth| truth.budget);
    budget.map_or(0.0, |budget| (budget.thrust + budget.inflow).norm())
}

/// Overrides of a hover in calm air that lasts `duration_s`, with one change at 4 s.
fn with_change(duration_s: f64, change: &str) -> Vec<String> {
    let calm = ["aero.turbulence_n=0.0", "aero.turbulence_n_m=0.0"].map(str::to_owned);
    let change =
        [format!("task.duration_s={duration_s}"), format!("disturbances=[{{at_s=4.0, {change}}}]")];
    calm.into_iter().chain(change).collect()
}

fn hover(overrides: &[String]) -> Vec<Tick> {
    let overrides: Vec<&str> = overrides.iter().map(String::as_str).collect();
    let (_, ticks) = flown(&scenario("hover", &overrides));
    let told = |tick: &&Tick| tick.events.iter().any(|event| event.kind == EventKind::Disturbance);
    let when: Vec<f64> = ticks.iter().filter(told).map(|tick| tick.measurement.t_s).collect();
    assert!(
        when.len() == 1 && (when[0] - 4.01).abs() < 1e-9,
        "the operator is told once, when it happens: {when:?}"
    );
    ticks
}

#[test]
fn a_heavier_payload_takes_its_weight_more_of_lift() {
    let mut overrides = with_change(9.0, "kind='payload_mass', kg=0.5");
    overrides.extend(["payload.mass_kg=0.2".to_owned(), "task.start=grasped".to_owned()]);
    let ticks = hover(&overrides);
    let more_n = mean(&ticks, 7.0, 9.0, lift_n) - mean(&ticks, 2.0, 4.0, lift_n);
    assert!((more_n - 300.0 * GRAM_N).abs() < FORCE_TOLERANCE_N, "{more_n:.2} N for 300 g");
}

#[test]
fn wind_is_leant_against_with_the_drag_it_makes() {
    let ticks = hover(&with_change(10.0, "kind='wind', velocity_m_s=[4.0, 0.0, 0.0]"));
    let theta = |tick: &Tick| tick.truth.as_ref().map_or(0.0, |truth| truth.chi[4]);
    let lean = mean(&ticks, 8.0, 10.0, theta) - mean(&ticks, 2.0, 4.0, theta);
    // Rotor drag 0.25 N s/m at 30 N and body drag 0.06 N s²/m² at 4 m/s: 1.94 N against 29.4 N of weight, nose into the wind.
    let wanted = -(0.25 * 4.0 * (29.4 / 30.0) + 0.06 * 16.0) / 29.4;
    assert!(
        (lean - wanted).abs() < 0.15 * wanted.abs(),
        "leans by {lean:.4} rad, drag asks for {wanted:.4} rad"
    );
}

#[test]
fn the_ground_carries_a_part_of_the_weight() {
    let mut overrides = with_change(9.0, "kind='effect', name='ground_effect', on=false");
    overrides.push("task.start_position_m=[0.0, 0.0, 0.5]".to_owned());
    let ticks = hover(&overrides);
    let share = mean(&ticks, 2.0, 4.0, spun_n) / mean(&ticks, 7.0, 9.0, spun_n);
    // Sanchez-Cuevas (2017), equation 11, at z = 0.5 m with R = 0.178 m, d = 0.46 m and K_b = 2.
    let (r, z, square) = (0.178_f64, 0.5_f64, squared(0.46_f64));
    let term = |square: f64| z / powf(square + 4.0 * z * z, 1.5);
    let images = squared(r / (4.0 * z)) + r * r * (term(square) + 0.5 * term(2.0 * square));
    let wanted = 1.0 - images - 4.0 * r * r * term(2.0 * square);
    assert!((share - wanted).abs() < 0.005, "{share:.4} of the thrust, theory says {wanted:.4}");
}

#[test]
fn a_radius_of_zero_has_no_ground_effect_even_below_the_ground() {
    let below = ["aero.ground_effect_radius_m=0.0", "task.start_position_m=[0.0, 0.0, -100.0]"];
    let (_, ticks) = flown(&scenario("hover", &[below[0], below[1], "task.duration_s=1.0"]));
    let height = |tick: &Tick| tick.truth.as_ref().map_or(f64::NAN, |truth| truth.chi[2]);
    // Far below the floor nothing touches the vehicle, and its thrust carries it as in any hover.
    assert!(ticks.iter().all(|tick| (height(tick) + 100.0).abs() < 0.5), "{:?}", ticks.last());
}

#[test]
fn a_push_moves_the_vehicle_its_way_and_it_comes_back() {
    let ticks = hover(&with_change(12.0, "kind='push', force_n=[0.0, 6.0, 0.0], duration_s=0.5"));
    let y = |tick: &Tick| tick.truth.as_ref().map_or(0.0, |truth| truth.chi[1]);
    let peak = ticks.iter().map(y).fold(0.0, f64::max);
    // A force of 6 N for 0.5 s on 3 kg without reaction would give 0.25 m at the end of the push.
    assert!((0.02..0.5).contains(&peak), "{peak:.3} m");
    let back = mean(&ticks, 11.0, 12.0, y);
    assert!(back.abs() < 0.03, "{back:.3} m");
}
