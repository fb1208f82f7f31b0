//! Thrust and torque of a rotor in moving air: blade elements with a uniform induced velocity that follows its momentum balance with a
//! first-order lag (dynamic inflow).
//!
//! In: speed of each rotor, velocity of its hub through the air. Out: thrust, torque, tilt of the disc. State: induced velocities.
//!
//! Sources: Leishman, "Principles of Helicopter Aerodynamics" (2006), chapters 2, 3 and 10; Pitt and Peters (1981) for the apparent mass;
//! Johnson, "Helicopter Theory" (1980) for the profile torque.

use nalgebra::Vector3;

use super::settings::RotorSettings;
use twin_core::elementary::squared;
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// Air density at 15 °C and sea level, kg/m³.
pub(super) const AIR_KG_M3: f64 = 1.225;

/// Growth of blade lift with the squared advance ratio.
const LIFT_ADVANCE: f64 = 1.5;

/// Growth of profile torque with the squared advance ratio.
const PROFILE_ADVANCE: f64 = 4.65;

/// Largest advance ratio: beyond it the flow meets a whole blade from behind, and blade elements say nothing.
const LARGEST_ADVANCE: f64 = 1.0;

/// Largest thrust per thrust in hover at the same speed: the blades of a hovering rotor have a lift coefficient of about 0.6, and stall at 1.5.
const STALL: f64 = 2.5;

/// Largest tilt of a disc, rad: about where stiff blades would break.
const LARGEST_TILT_RAD: f64 = 0.35;

/// Smallest squared velocity of the momentum balance, per squared induced velocity in hover. It keeps the balance defined in the vortex
/// ring state, where a momentum balance does not hold.
const LEAST_FLOW: f64 = 0.05;

/// Slowest rotor for which the model is used, rad/s; below it, thrust and torque are those of still air.
const LEAST_RAD_S: f64 = 1.0;

/// Smallest thrust that induces a velocity, N.
const LEAST_N: f64 = 1e-6;

/// Coefficients that follow from the settings of a rotor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blades {
    /// Disc area, m².
    area_m2: f64,
    radius_m: f64,
    /// Thrust that a velocity through the disc takes, per rotor speed: `rho a S R / 4`, N s²/(rad m).
    lift_n_s2: f64,
    /// Lift coefficient times dynamic pressure: `rho a S R^2`, N s²/rad².
    pitch_n_s2: f64,
    torque_ratio_m: f64,
}

/// Thrust, torque and tilt of a rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RotorLoad {
    /// Thrust along the rotor's axis, N.
    pub(super) thrust_n: f64,
    /// Torque that drives the rotor, N m.
    pub(super) torque_n_m: f64,
    /// Tilt of the disc away from the cross flow, per velocity of the flow, rad s/m.
    pub(super) flap_rad_s_m: f64,
}

impl Blades {
    pub(super) fn new(s: &RotorSettings) -> Self {
        let lift = AIR_KG_M3 * s.lift_slope_per_rad * s.blade_area_m2;
        Self {
            area_m2: std::f64::consts::PI * squared(s.radius_m),
            radius_m: s.radius_m,
            lift_n_s2: 0.25 * lift * s.radius_m,
            pitch_n_s2: lift * squared(s.radius_m),
            torque_ratio_m: s.torque_ratio_m,
        }
    }

    /// Velocity that a rotor in hover induces, m/s: `sqrt(T / 2 rho A)`.
    pub(super) fn hover_m_s(&self, thrust_n: f64) -> f64 {
        (thrust_n.max(0.0) / (2.0 * AIR_KG_M3 * self.area_m2)).sqrt()
    }

    /// Load of a rotor at rest in still air with the thrust coefficient `k`, N s²/rad².
    pub(super) fn still(&self, k: f64, speed_rad_s: f64) -> RotorLoad {
        let thrust_n = k * squared(speed_rad_s);
        RotorLoad { thrust_n, torque_n_m: self.torque_ratio_m * thrust_n, flap_rad_s_m: 0.0 }
    }

    /// Load of a rotor whose hub moves through the air with `velocity` in the body frame, m/s, while it induces `induced_m_s`. In hover it
    /// equals [`Self::still`].
    fn moving(&self, k: f64, speed: f64, velocity: &Vector3<f64>, induced_m_s: f64) -> RotorLoad {
        let tip_m_s = speed * self.radius_m;
        let advance =
            (velocity.xy().norm_squared() / squared(tip_m_s)).min(squared(LARGEST_ADVANCE));
        let through_m_s = velocity.z + induced_m_s;
        // Induced velocity per speed in hover, m/rad; the pitch of the blades follows from the thrust there.
        let hover = (k / (2.0 * AIR_KG_M3 * self.area_m2)).sqrt();
        let pitch = k + self.lift_n_s2 * hover;
        let thrust_n = pitch * squared(speed) * (1.0 + LIFT_ADVANCE * advance)
            - self.lift_n_s2 * speed * through_m_s;
        let stalled = STALL * k * squared(speed) * (1.0 + LIFT_ADVANCE * advance);
        let thrust_n = thrust_n.clamp(-stalled, stalled);
        let profile = (k * (self.torque_ratio_m - hover)).max(0.0);
        let torque_n_m = thrust_n * through_m_s / speed
            + profile * squared(speed) * (1.0 + PROFILE_ADVANCE * advance);
        // a_1 = 2 mu (4/3 theta - lambda) with theta from the pitch term T = rho a S R^2 Omega^2 theta / 6.
        let theta = 6.0 * pitch / self.pitch_n_s2;
        let flap_rad_s_m = 2.0 / tip_m_s * (4.0 / 3.0 * theta - through_m_s / tip_m_s);
        let most = LARGEST_TILT_RAD / velocity.xy().norm().max(f64::MIN_POSITIVE);
        RotorLoad { thrust_n, torque_n_m, flap_rad_s_m: flap_rad_s_m.clamp(0.0, most) }
    }
}

/// Induced velocities of all rotors.
#[derive(Clone, Debug)]
pub(super) struct Inflow {
    blades: Blades,
    /// Velocity that each rotor induces at its disc, m/s, positive downwards.
    pub(super) induced_m_s: PerRotor,
    dt_s: f64,
}

impl Inflow {
    /// Rotors that hover with `thrust_n`.
    pub(super) fn new(settings: &RotorSettings, thrust_n: f64, dt_s: f64) -> Self {
        let blades = Blades::new(settings);
        Self { blades, induced_m_s: [blades.hover_m_s(thrust_n); MAX_ROTORS], dt_s }
    }

    /// Load of rotor `i` with thrust coefficient `k` (N s²/rad²) at `speed_rad_s`, whose hub moves through the air with `velocity` in the
    /// body frame, m/s. Advances its induced velocity by a step. Off: the load of still air.
    pub(super) fn step(
        &mut self,
        i: usize,
        k: f64,
        speed_rad_s: f64,
        velocity: &Vector3<f64>,
        on: bool,
    ) -> RotorLoad {
        let Self { blades, induced_m_s, dt_s } = self;
        let moving = speed_rad_s > LEAST_RAD_S;
        let mut load = if moving {
            blades.moving(k, speed_rad_s, velocity, induced_m_s[i])
        } else {
            blades.still(k, speed_rad_s)
        };
        if !on {
            load = RotorLoad { flap_rad_s_m: load.flap_rad_s_m, ..blades.still(k, speed_rad_s) };
        }
        let thrust_n = load.thrust_n.max(LEAST_N);
        let flow = mass_flow_velocity(velocity, induced_m_s[i], blades.hover_m_s(thrust_n));
        // M dv/dt = T - 2 rho A v V with the apparent mass M = 8/3 rho R^3; v is taken at the end of the step, which is always stable.
        let mass = 8.0 / 3.0 * AIR_KG_M3 * blades.radius_m * squared(blades.radius_m);
        let share = *dt_s / mass;
        induced_m_s[i] = (induced_m_s[i] + share * thrust_n)
            / (1.0 + share * 2.0 * AIR_KG_M3 * blades.area_m2 * flow);
        load
    }
}

/// Velocity of the air that the momentum balance `T = 2 rho A v V` accelerates, m/s. In climb and forward flight it is Glauert's
/// `sqrt(V_xy^2 + (V_z + v)^2)`; a term for the descent makes the balance meet the measured induced velocity there.
fn mass_flow_velocity(velocity: &Vector3<f64>, induced_m_s: f64, hover_m_s: f64) -> f64 {
    let glauert = velocity.xy().norm_squared() + squared(velocity.z + induced_m_s);
    let descent = descent_term(velocity.z / hover_m_s) * squared(hover_m_s);
    (glauert + descent).max(LEAST_FLOW * squared(hover_m_s)).sqrt()
}

/// Difference of the squared velocities of the balance between measurement and momentum theory, per squared induced velocity in hover, at
/// the climb ratio `x`; zero outside of -2 < x < 0.
fn descent_term(x: f64) -> f64 {
    if x <= -2.0 || x >= 0.0 {
        return 0.0;
    }
    let induced = measured_descent(x);
    1.0 / squared(induced) - squared(x + induced)
}

/// Induced velocity of a descending rotor per induced velocity in hover: fit to measurements in -2 <= x <= 0 (Leishman 2006, equation 2.101).
pub(super) fn measured_descent(x: f64) -> f64 {
    1.0 + x * (-1.125 + x * (-1.372 + x * (-1.718 + x * -0.655)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::ROTOR;

    const STEP_S: f64 = 1e-3;
    const K: f64 = 4.3e-5;

    /// Thrust and induced velocity after two seconds with this velocity of the hub; the slowest time constant is 0.02 s.
    fn settled(speed: f64, velocity: Vector3<f64>) -> (RotorLoad, f64) {
        let mut inflow = Inflow::new(&ROTOR, 8.0, STEP_S);
        let load = (0..2000).map(|_| inflow.step(0, K, speed, &velocity, true)).last();
        (load.expect("2000 steps"), inflow.induced_m_s[0])
    }

    #[test]
    fn in_hover_thrust_torque_and_induced_velocity_are_those_of_still_air() {
        for speed in [200.0, 431.0, 590.0] {
            let (load, induced) = settled(speed, Vector3::zeros());
            let still = Blades::new(&ROTOR).still(K, speed);
            assert!((load.thrust_n / still.thrust_n - 1.0).abs() < 1e-9, "{load:?}");
            assert!((load.torque_n_m / still.torque_n_m - 1.0).abs() < 1e-9, "{load:?}");
            let area = std::f64::consts::PI * 0.178 * 0.178;
            assert!((induced - (still.thrust_n / (2.0 * 1.225 * area)).sqrt()).abs() < 1e-9);
        }
    }

    #[test]
    fn in_climb_the_rotor_meets_momentum_theory_and_loses_thrust() {
        let climb = 3.0;
        let (load, induced) = settled(431.0, Vector3::new(0.0, 0.0, climb));
        let hover = Blades::new(&ROTOR).hover_m_s(load.thrust_n);
        // v = -V/2 + sqrt((V/2)^2 + v_h^2), Leishman (2006), equation 2.87.
        let theory = -0.5 * climb + (0.25 * climb * climb + hover * hover).sqrt();
        assert!((induced - theory).abs() < 1e-9, "{induced} {theory}");
        assert!(load.thrust_n < 8.0 - 1.0, "{load:?}");
    }

    #[test]
    fn in_descent_the_rotor_meets_the_measured_induced_velocity() {
        for descent in [-0.5, -2.0, -4.0] {
            let (load, induced) = settled(431.0, Vector3::new(0.0, 0.0, descent));
            let hover = Blades::new(&ROTOR).hover_m_s(load.thrust_n);
            let measured = hover * measured_descent(descent / hover);
            assert!((induced - measured).abs() < 1e-6 * hover, "{descent}: {induced} {measured}");
        }
    }

    #[test]
    fn forward_flight_lowers_the_induced_velocity_by_glauerts_formula_and_raises_the_thrust() {
        let (load, induced) = settled(431.0, Vector3::new(8.0, 0.0, 0.0));
        let hover = Blades::new(&ROTOR).hover_m_s(load.thrust_n);
        let theory = hover * hover / (64.0 + induced * induced).sqrt();
        assert!((induced - theory).abs() < 1e-9, "{induced} {theory}");
        assert!(load.thrust_n > 8.5, "{load:?}");
    }

    #[test]
    fn a_step_of_the_speed_overshoots_because_the_inflow_follows_late() {
        let mut inflow = Inflow::new(&ROTOR, K * 400.0 * 400.0, STEP_S);
        let first = inflow.step(0, K, 440.0, &Vector3::zeros(), true).thrust_n;
        let later: Vec<f64> =
            (0..60).map(|_| inflow.step(0, K, 440.0, &Vector3::zeros(), true).thrust_n).collect();
        let settled = K * 440.0 * 440.0;
        assert!(first > settled + 0.3, "{first} {settled}");
        // The lag of the linearised balance is 8/3 rho R^3 / (4 rho A v + lift) = 4.4 ms, Pitt and Peters (1981).
        let rest = (later[8] - settled) / (first - settled);
        assert!((0.05..0.25).contains(&rest), "{rest}");
        assert!((later[59] - settled).abs() < 0.01);
    }

    #[test]
    fn blades_stall() {
        let (up, down) = (Vector3::new(0.0, 0.0, 40.0), Vector3::new(0.0, 0.0, -40.0));
        let mut inflow = Inflow::new(&ROTOR, 8.0, STEP_S);
        let hover_n = K * 431.0 * 431.0;
        assert!((inflow.step(0, K, 431.0, &up, true).thrust_n + 2.5 * hover_n).abs() < 1e-9);
        assert!((inflow.step(0, K, 431.0, &down, true).thrust_n - 2.5 * hover_n).abs() < 1e-9);
        assert!(
            inflow.step(0, 0.0, 431.0, &up, true).thrust_n.abs() < 1e-12,
            "a rotor without thrust"
        );
    }

    #[test]
    fn a_rotor_that_stands_still_or_falls_fast_stays_finite() {
        let mut inflow = Inflow::new(&ROTOR, 8.0, STEP_S);
        for z in [-1.0, -30.0, 30.0, 1e3] {
            for speed in [0.0, 0.5, 2.0, 600.0] {
                for _ in 0..500 {
                    let load = inflow.step(0, K, speed, &Vector3::new(0.0, 5.0, z), true);
                    assert!(load.thrust_n.is_finite() && load.torque_n_m.is_finite());
                    assert!(inflow.induced_m_s[0].is_finite());
                }
            }
        }
    }
}
