//! Steady curves of single effects, for plots and for comparisons with published curves.
//!
//! Every function drives the code that flies, until it has settled; none has a formula of its own.

use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::STEP_S;
use super::battery::{Battery, cell_v};
use super::ground::Ground;
use super::inflow::{Blades, Inflow, measured_descent};
use super::servo::Servos;
use super::settings::{
    AeroSettings, BatterySettings, RotorPlace, RotorSettings, ServoSettings, WindSettings,
};
use super::wake::Wake;
use super::wind::Wind;
use twin_core::notation::MAX_ROTORS;

/// Steps in which every effect of the air settles: 3 s.
const SETTLING: usize = 3000;

/// A rotor that moves through the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorPoint {
    /// Thrust, N.
    pub thrust_n: f64,
    /// Torque that drives the rotor, N m.
    pub torque_n_m: f64,
    /// Induced velocity, m/s.
    pub induced_m_s: f64,
    /// Velocity that a hovering rotor with this thrust induces, m/s.
    pub hover_m_s: f64,
    /// Moment of the tilted disc on the hub, N m.
    pub hub_moment_n_m: f64,
}

/// A rotor at `speed_rad_s` whose hub moves with `velocity` through still air, in its own frame with z along the thrust, m/s, when the
/// inflow has settled.
pub fn rotor(settings: &RotorSettings, speed_rad_s: f64, velocity: [f64; 3]) -> RotorPoint {
    let k = settings.thrust_coefficient_n_s2;
    let mut inflow = Inflow::new(settings, k * speed_rad_s * speed_rad_s, STEP_S);
    let velocity = Vector3::from(velocity);
    let mut load = inflow.step(0, k, speed_rad_s, &velocity, true);
    for _ in 0..SETTLING {
        load = inflow.step(0, k, speed_rad_s, &velocity, true);
    }
    RotorPoint {
        thrust_n: load.thrust_n,
        torque_n_m: load.torque_n_m,
        induced_m_s: inflow.induced_m_s[0],
        hover_m_s: Blades::new(settings).hover_m_s(load.thrust_n),
        hub_moment_n_m: settings.flap_stiffness_n_m_rad * load.flap_rad_s_m * velocity.xy().norm(),
    }
}

/// Thrust of a rotor after its speed jumps from one value to another, N, one value a step of 1 ms.
pub fn thrust_after_jump(settings: &RotorSettings, [from, to]: [f64; 2], steps: usize) -> Vec<f64> {
    let k = settings.thrust_coefficient_n_s2;
    let mut inflow = Inflow::new(settings, k * from * from, STEP_S);
    (0..steps).map(|_| inflow.step(0, k, to, &Vector3::zeros(), true).thrust_n).collect()
}

/// Measured induced velocity per induced velocity in hover at the climb ratio `x` in -2..=0 (Leishman 2006, equation 2.101).
pub fn published_descent(x: f64) -> f64 {
    measured_descent(x)
}

/// Thrust of a rotor in ground effect per thrust far above the ground, with all rotors `height_m` above it, when the flow has settled.
pub fn ground_ratio(places: &[RotorPlace], aero: &AeroSettings, height_m: f64) -> f64 {
    let aero = AeroSettings { ground_effect: true, recirculation: false, ..*aero };
    let mut ground = Ground::new(places, 1, STEP_S);
    (0..SETTLING).for_each(|_| ground.step(&[height_m; MAX_ROTORS], &aero));
    1.0 + ground.gain(0)
}

/// Downward velocity in the wakes of all rotors, m/s, at `point` in the frame of a vehicle that has moved with `velocity` for long, and whose
/// rotors induce `induced_m_s`.
pub fn wake(
    places: &[RotorPlace],
    radius_m: f64,
    induced_m_s: f64,
    velocity: [f64; 3],
    points: &[[f64; 3]],
) -> Vec<f64> {
    let induced = [induced_m_s; MAX_ROTORS];
    let mut wake = Wake::new(places, radius_m, &induced, STEP_S);
    let steps = SETTLING;
    for step in 0..steps {
        let before_s = (steps - 1 - step) as f64 * STEP_S;
        let position = Vector3::from(velocity) * -before_s;
        wake.step(&position, &Matrix3::identity(), &induced, STEP_S);
    }
    points.iter().map(|point| -wake.at(&Vector3::from(*point), &Vector3::zeros()).z).collect()
}

/// Open-circuit voltage of a cell, V, at a charge per capacity.
pub fn open_cell_v(charge: f64) -> f64 {
    cell_v(charge)
}

/// Rotor speed per commanded speed while a battery is emptied with `power_w` of mechanical power, one value a second.
pub fn discharge(settings: &BatterySettings, power_w: f64, seconds: usize) -> Vec<f64> {
    let settings = BatterySettings { on: true, ..*settings };
    let per_second = (1.0 / STEP_S).round() as usize;
    let mut battery = Battery::new(&settings, power_w, STEP_S);
    (0..seconds)
        .map(|_| {
            (0..per_second).for_each(|_| battery.step(power_w));
            battery.speed_share()
        })
        .collect()
}

/// Friction of a servo per Coulomb friction at a rate, rad/s.
pub fn servo_friction(settings: &ServoSettings, rate_rad_s: f64) -> f64 {
    let one = nalgebra::Vector2::new(1.0, 1.0);
    let servos = Servos::with_friction(&ServoSettings { on: true, ..*settings }, one, STEP_S);
    servos.friction(&nalgebra::Vector2::repeat(rate_rad_s)).x
}

/// Largest torque of a servo at a rate in the sense of the torque, N m.
pub fn servo_torque(settings: &ServoSettings, rate_rad_s: f64) -> f64 {
    let settings = ServoSettings { on: true, ..*settings };
    let mut servos = Servos::with_friction(&settings, nalgebra::Vector2::zeros(), STEP_S);
    let command = nalgebra::Vector2::repeat(10.0 * settings.stall_n_m);
    servos.torque(command, &nalgebra::Vector2::repeat(rate_rad_s)).x
}

/// Turbulence at `altitude_m` above the ground without its mean, along the axes of the world, m/s: `samples` values, `step_s` apart, past a
/// vehicle that does not move.
pub fn turbulence(
    settings: &WindSettings,
    altitude_m: f64,
    samples: usize,
    step_s: f64,
) -> Vec<[f64; 3]> {
    let mut rng = Pcg64::seed_from_u64(1);
    let mut wind = Wind::new(settings);
    let mean = Vector3::from(settings.velocity_m_s);
    (0..samples)
        .map(|i| {
            let now = wind.step(i as f64 * step_s, 0.0, altitude_m, step_s, &mut rng);
            (now.even - mean).into()
        })
        .collect()
}
