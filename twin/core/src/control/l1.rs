//! L1 adaptive control with the piecewise-constant law: the paper's baseline without a model of the residual.
//!
//! Source: Wu, Cheng, Zhao, Gahlawat, Ackerman, Lakshmanan, Yang, Yu and Hovakimyan, "`L1Quad`: L1 adaptive augmentation of geometric
//! control for agile quadrotors with performance guarantees", IEEE T-CST 33(2), 2025. The uncertainty `sigma` that the source compensates
//! is `r - g(chi)` here, and the baseline law is `eq:control_input` without the robust term.
//!
//! State predictor `M_bar v_hat' = tau - g - sigma_hat + M_bar A_s (v_hat - v)`, adaptation `sigma_hat = M_bar Phi^-1 exp(A_s T)
//! (v_hat - v)` with `Phi = A_s^-1 (exp(A_s T) - 1)`, compensation `sigma_hat` behind a first-order low-pass. Even at rest
//! the part `1 - exp(A_s T)` is never compensated: 10 % at `A_s` = -10 1/s and 100 Hz.
//!
//! State: the predictor's error, the low-pass, the baseline law.

use super::{Adaptive, Controller, Gains, Input};
use crate::elementary::exp;
use crate::notation::{Coords, N};
use crate::tick::{Adaptation, ControlState, Setpoint};

/// Settings of an L1 controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct L1Settings {
    /// `-A_s`, 1/s: rate at which the predictor forgets, in every coordinate.
    pub pole_per_s: f64,
    /// Corner of the low-pass for x y z, then for the other coordinates, rad/s.
    pub cutoff_rad_s: [f64; 2],
}

/// The controller.
#[derive(Clone, Debug)]
pub struct L1 {
    settings: L1Settings,
    beneath: Adaptive,
    /// Measured rate at the last tick, and the error of the predicted rate.
    start: Option<(Coords, Coords)>,
    sigma: Coords,
    compensated: Coords,
}

impl L1 {
    /// A controller that has not estimated anything yet.
    pub fn new(settings: L1Settings) -> Self {
        let zero = Coords::zeros();
        Self { settings, beneath: Adaptive::default(), start: None, sigma: zero, compensated: zero }
    }

    /// `C(s) sigma_hat` for this tick, N and N m.
    fn estimate(&mut self, input: &Input<'_>, gains: &Gains) -> Coords {
        let (measured, dt_s) = (input.measurement, input.dt_s);
        let pole = -self.settings.pole_per_s;
        let forgotten = exp(pole * dt_s);
        let phi = (forgotten - 1.0) / pole;
        // The state predictor over the period that just ended, under the force applied in it; exact for a constant acceleration.
        let force = *measured.tau_applied - input.nominal_gravity - self.sigma;
        let error = self.start.map_or_else(Coords::zeros, |(before, off)| {
            let expected = force.component_div(&gains.nominal_inertia) * phi;
            off * forgotten + expected - (*measured.chi_dot - before) * (phi / dt_s)
        });
        self.start = Some((*measured.chi_dot, error));
        self.sigma = gains.nominal_inertia.component_mul(&error) * (forgotten / phi);
        for row in 0..N {
            let corner = self.settings.cutoff_rad_s[usize::from(row >= 3)];
            let share = 1.0 - exp(-corner * dt_s);
            self.compensated[row] += share * (self.sigma[row] - self.compensated[row]);
        }
        self.compensated
    }
}

impl Controller for L1 {
    fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState) {
        if input.reference.adaptation == Adaptation::Held {
            // In contact the predictor's error is not an error of the model.
            self.start = None;
        } else {
            self.estimate(input, gains);
        }
        if let Some(known) = &input.reference.release {
            for row in 0..3 {
                self.compensated[row] = known[row] - input.nominal_gravity[row];
            }
        }
        let r_hat = input.nominal_gravity + self.compensated;
        // The low-pass of L1 is the only one, and the baseline law has no robust term.
        let gains = Gains { robust_gain_cap: 0.0, residual_filter_on: false, ..*gains };
        self.beneath.control(&Input { r_hat: &r_hat, ..*input }, &gains)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Preset;
    use crate::tick::{GripperCommand, GripperReading, Measurement, Reference};
    use nalgebra::Vector3;

    /// `sigma_hat` after `seconds` of a constant unmodelled force of 2 N in every coordinate at rest.
    fn settled(settings: L1Settings, seconds: f64) -> Coords {
        let (zero, force) = (Coords::zeros(), Coords::repeat(2.0));
        let reference = Reference {
            chi_des: zero.into(),
            chi_des_dot: zero.into(),
            chi_des_ddot: zero,
            gripper: GripperCommand::Open,
            adaptation: Adaptation::Free,
            follows_measurement: false,
            transporting: false,
            cruising: false,
            release: None,
        };
        // At rest the applied force equals the residual: r = tau.
        let measurement = Measurement {
            t_s: 0.0,
            chi: zero.into(),
            chi_dot: zero.into(),
            chi_ddot: zero.into(),
            tau_applied: force.into(),
            gripper: GripperReading::default(),
            payload: None,
            saturated: false,
            airborne: true,
        };
        let input = Input {
            measurement: &measurement,
            reference: &reference,
            r_hat: &zero,
            residual: &force,
            nominal_gravity: &zero,
            desired_attitude: (Vector3::zeros(), Vector3::zeros()),
            dt_s: 0.01,
        };
        let mut law = L1::new(settings);
        (0..(seconds / 0.01) as usize)
            .map(|_| law.estimate(&input, &Gains::preset(Preset::Paper)))
            .last()
            .unwrap()
    }

    #[test]
    fn at_rest_all_but_the_known_part_of_a_force_is_found() {
        for pole_per_s in [1.0, 10.0, 50.0] {
            let found = settled(L1Settings { pole_per_s, cutoff_rad_s: [8.0, 8.0] }, 20.0);
            // Piecewise-constant law at rest: sigma_hat = exp(A_s T) sigma.
            let wanted = 2.0 * exp(-pole_per_s * 0.01_f64);
            assert!((found - Coords::repeat(wanted)).norm() < 1e-6, "{pole_per_s}: {found}");
        }
    }

    #[test]
    fn translation_and_rotation_have_corners_of_their_own() {
        let found = settled(L1Settings { pole_per_s: 1.0, cutoff_rad_s: [0.5, 8.0] }, 0.5);
        // A first-order low-pass half a second after a step: 22 % and 98 %.
        assert!(found[0] < 0.25 * 2.0 && found[4] > 0.9 * 2.0, "{found}");
    }
}
