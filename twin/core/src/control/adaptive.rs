//! The paper's residual-compensated adaptive law for x y z, and the set-point of the inner controller.
//!
//! In: measurement, reference, adapted residual. Out: [`Setpoint`]. State: adaptive gain `sigma_hat`, compensation of `r_hat`.

use nalgebra::{Vector2, Vector3};

use super::compensation::Compensation;
use super::{Controller, Gains, Input};
use crate::elementary::exp;
use crate::notation::{Coords, attitude, position, tracking_error};
use crate::tick::{ControlState, Setpoint};

/// The adaptive controller.
#[derive(Clone, Debug, Default)]
pub struct Adaptive {
    robust_gain: Option<f64>,
    initial_in_force: f64,
    compensation: Compensation,
}

impl Adaptive {
    /// `eq:adaptive_law`, explicit Euler with the exact leak, capped.
    fn update_robust_gain(&mut self, sliding_norm: f64, gains: &Gains, dt_s: f64) -> f64 {
        if gains.robust_gain_initial.to_bits() != self.initial_in_force.to_bits() {
            self.initial_in_force = gains.robust_gain_initial;
            self.robust_gain = None;
        }
        let sigma_hat = self.robust_gain.unwrap_or(gains.robust_gain_initial);
        let leak = exp(-gains.leak * dt_s);
        let next = sigma_hat * leak + sliding_norm * (1.0 - leak) / gains.leak;
        let next =
            if next.is_finite() { next.clamp(0.0, gains.robust_gain_cap) } else { sigma_hat };
        self.robust_gain = Some(next);
        next
    }
}

impl Controller for Adaptive {
    fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState) {
        let reference = input.reference;
        let (e, e_dot) = errors(input);
        let s = e_dot + gains.slope.component_mul(&e); // eq:sliding_var
        let sliding_norm = s.norm();
        let sigma_hat = self.update_robust_gain(sliding_norm, gains, input.dt_s);
        let r_hat = self.compensation.step(
            input.r_hat,
            input.residual,
            input.nominal_gravity,
            reference,
            gains,
            input.dt_s,
        );
        // eq:control_input for x y z; the inner controller computes the other coordinates at 500 Hz.
        let tau = gains
            .nominal_inertia
            .component_mul(&(reference.chi_des_ddot - gains.slope.component_mul(&e_dot)))
            - gains.damping.component_mul(&s)
            + r_hat
            - s * (sigma_hat / sliding_norm.max(gains.boundary_layer).max(f64::MIN_POSITIVE));
        let weight_n = input.nominal_gravity[2].max(f64::MIN_POSITIVE);
        let force = position(&tau);
        let force = if gains.clips { gains.safe_set.clip_force(force, weight_n) } else { force };
        let setpoint = setpoint(force, input, r_hat, gains, (sliding_norm, sigma_hat));
        (setpoint, ControlState { error: e.into(), sliding: s.into(), robust_gain: sigma_hat })
    }
}

/// Tracking error and its rate; roll and pitch are compared with the command filter.
pub(super) fn errors(input: &Input<'_>) -> (Coords, Coords) {
    let (eta_des, eta_des_dot) = input.desired_attitude;
    let mut chi_des = *input.reference.chi_des;
    let mut chi_des_dot = *input.reference.chi_des_dot;
    for i in 0..3 {
        chi_des[3 + i] = eta_des[i];
        chi_des_dot[3 + i] = eta_des_dot[i];
    }
    let m = input.measurement;
    (tracking_error(&m.chi, &chi_des), *m.chi_dot - chi_des_dot)
}

/// The set-point with the desired `force` and the references of the inner controller.
pub(super) fn setpoint(
    force_in_world_n: Vector3<f64>,
    input: &Input<'_>,
    r_hat: Coords,
    gains: &Gains,
    (sliding_norm, robust_gain): (f64, f64),
) -> Setpoint {
    let reference = input.reference;
    let joints = |c: &Coords| Vector2::new(c[6], c[7]);
    let yaw = |c: &Coords| attitude(c).z;
    Setpoint {
        force_in_world_n,
        yaw_des: [
            yaw(&reference.chi_des),
            yaw(&reference.chi_des_dot),
            yaw(&reference.chi_des_ddot),
        ],
        joint_des: joints(&reference.chi_des),
        joint_des_dot: joints(&reference.chi_des_dot),
        joint_des_ddot: joints(&reference.chi_des_ddot),
        r_hat,
        sliding_norm,
        robust_gain,
        rows: gains.rows(),
        gripper: reference.gripper,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Preset;

    #[test]
    fn robust_gain_settles_at_norm_over_leak_and_respects_its_cap() {
        let gains = Gains::preset(Preset::Paper);
        let mut law = Adaptive::default();
        for _ in 0..2000 {
            law.update_robust_gain(1.0, &gains, 0.01);
        }
        // eq:adaptive_law at rest: sigma_hat = |s| / nu
        assert!((law.robust_gain.unwrap() - 1.0 / gains.leak).abs() < 1e-9);
        for _ in 0..2000 {
            law.update_robust_gain(1e6, &gains, 0.01);
        }
        assert_eq!(law.robust_gain, Some(gains.robust_gain_cap));
    }
}
