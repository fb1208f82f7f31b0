//! Plain PID: it collects the training data and is the baseline of every tracking table. It uses no residual estimate.
//!
//! State: integrals of position, attitude and joint errors.

use super::adaptive::{errors, setpoint};
use super::{Controller, Gains, Input};
use crate::notation::{Coords, GRAVITY_M_S2, position};
use crate::tick::{ControlState, InnerLaw, Setpoint};

/// Position gains per axis, 1/s², 1/s, 1/s³ (times mass). Source: control study, section 5.
const P: [f64; 3] = [9.0, 9.0, 12.0];
const D: [f64; 3] = [7.0, 7.0, 8.0];
const I: [f64; 3] = [1.5, 1.5, 3.0];

/// Joint gains: N m/rad and N m s/rad per joint (`Lambda`, `Phi`), and the integral in N m/(rad s).
const JOINT_DAMPING: f64 = 0.8;
const JOINT_SLOPE: f64 = 6.0;
const JOINT_I: f64 = 6.0;

/// Integral of the attitude error, N m/(rad s).
const ATTITUDE_I: f64 = 2.0;

/// Limit of each integral term, N or N m.
const INTEGRAL_LIMIT: [f64; 8] = [4.0, 4.0, 9.0, 0.5, 1.5, 0.2, 2.0, 2.0];

/// The PID controller.
#[derive(Clone, Debug, Default)]
pub struct Pid {
    integral: Coords,
}

impl Controller for Pid {
    fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState) {
        let (e, e_dot) = errors(input);
        let rate =
            Coords::from([I[0], I[1], I[2], ATTITUDE_I, ATTITUDE_I, ATTITUDE_I, JOINT_I, JOINT_I]);
        let mass_kg = input.nominal_gravity[2] / GRAVITY_M_S2;
        for row in 0..8 {
            let scale = if row < 3 { mass_kg } else { 1.0 };
            let next = self.integral[row] - rate[row] * scale * e[row] * input.dt_s;
            self.integral[row] = next.clamp(-INTEGRAL_LIMIT[row], INTEGRAL_LIMIT[row]);
        }
        let mut force = position(&self.integral) + position(input.nominal_gravity);
        for axis in 0..3 {
            let acceleration =
                input.reference.chi_des_ddot[axis] - P[axis] * e[axis] - D[axis] * e_dot[axis];
            force[axis] += mass_kg * acceleration;
        }
        // Attitude and joints: the integral takes the place of the residual in the adaptive law.
        let mut trim = self.integral;
        for row in 6..8 {
            trim[row] += input.nominal_gravity[row];
        }
        let mut rows = *gains;
        rows.inner_law = InnerLaw::RateLoop;
        for row in 6..8 {
            rows.damping[row] = JOINT_DAMPING;
            rows.slope[row] = JOINT_SLOPE;
        }
        let force = gains.safe_set.clip_force(force, input.nominal_gravity[2]);
        let setpoint = setpoint(force, input, trim, &rows, (1.0, 0.0));
        (
            setpoint,
            ControlState { error: e.into(), sliding: Coords::zeros().into(), robust_gain: 0.0 },
        )
    }
}
