//! The inner controller: attitude and joints at 500 Hz, then rotor allocation. It depends on its inputs and its command filter only.

use nalgebra::{Vector2, Vector3};

use super::allocation::Allocation;
use super::attitude::{CommandFilter, tilt_from_force};
use crate::notation::{body_rate_from_euler_rate, world_from_body, wrap_angle};
use crate::source::{InnerLoop, InnerState};
use crate::tick::{ActuatorCommand, InnerLaw, Setpoint};

/// Attitude gain of the PX4-like loop, 1/s.
const RATE_LOOP_P: f64 = 5.0;

/// Crossover of the PX4-like rate loop, rad/s.
const RATE_LOOP_RAD_S: f64 = 15.0;

/// The inner controller with its command filter.
#[derive(Clone, Debug)]
pub struct InnerController {
    filter: CommandFilter,
    allocation: Allocation,
    attitude_inertia: Vector3<f64>,
    joint_torque_limit_n_m: Vector2<f64>,
    tilt_limit_rad: f64,
    dt_s: f64,
}

impl InnerController {
    /// An inner controller for a vehicle: effective inertia about roll, pitch, yaw in kg m², torque limit of each joint in N m, largest
    /// desired roll and pitch in rad, period in s.
    pub fn new(
        allocation: Allocation,
        attitude_inertia: Vector3<f64>,
        joint_torque_limit_n_m: Vector2<f64>,
        tilt_limit_rad: f64,
        dt_s: f64,
    ) -> Self {
        Self {
            filter: CommandFilter::default(),
            allocation,
            attitude_inertia,
            joint_torque_limit_n_m,
            tilt_limit_rad,
            dt_s,
        }
    }

    /// Desired attitude and its rate, rad and rad/s.
    pub fn desired_attitude(&self) -> (Vector3<f64>, Vector3<f64>) {
        (self.filter.eta, self.filter.eta_dot)
    }

    /// `eq:control_input` for phi theta psi.
    fn attitude_rows(
        &self,
        setpoint: &Setpoint,
        e: &Vector3<f64>,
        e_dot: &Vector3<f64>,
    ) -> Vector3<f64> {
        let rows = &setpoint.rows;
        let robust = robust_factor(setpoint);
        Vector3::from_fn(|axis, _| {
            let i = 3 + axis;
            let s = e_dot[axis] + rows.slope[i] * e[axis];
            rows.nominal_inertia[i] * (self.filter.eta_ddot[axis] - rows.slope[i] * e_dot[axis])
                - rows.damping[i] * s
                + setpoint.r_hat[i]
                - robust * s
        })
    }

    /// Rate set-point from the attitude error, then a proportional rate controller with the residual as feed-forward.
    fn rate_loop(
        &self,
        setpoint: &Setpoint,
        e: &Vector3<f64>,
        e_dot: &Vector3<f64>,
    ) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| {
            let rate_error = -RATE_LOOP_P * e[axis] - e_dot[axis];
            self.attitude_inertia[axis]
                * (RATE_LOOP_RAD_S * rate_error + self.filter.eta_ddot[axis])
                + setpoint.r_hat[3 + axis]
        })
    }

    /// `eq:control_input` for q1 q2.
    fn joint_rows(&self, setpoint: &Setpoint, state: &InnerState) -> Vector2<f64> {
        let rows = &setpoint.rows;
        let robust = robust_factor(setpoint);
        Vector2::from_fn(|joint, _| {
            let i = 6 + joint;
            let e = state.joint[joint] - setpoint.joint_des[joint];
            let e_dot = state.joint_dot[joint] - setpoint.joint_des_dot[joint];
            let s = e_dot + rows.slope[i] * e;
            let torque = rows.nominal_inertia[i]
                * (setpoint.joint_des_ddot[joint] - rows.slope[i] * e_dot)
                - rows.damping[i] * s
                + setpoint.r_hat[i]
                - robust * s;
            let limit = self.joint_torque_limit_n_m[joint];
            torque.clamp(-limit, limit)
        })
    }
}

/// `sigma_hat / max(|s|, boundary layer)`: multiplied by `s` it is the robust term.
fn robust_factor(setpoint: &Setpoint) -> f64 {
    setpoint.robust_gain
        / setpoint.sliding_norm.max(setpoint.rows.boundary_layer).max(f64::MIN_POSITIVE)
}

impl InnerLoop for InnerController {
    fn command(&mut self, setpoint: &Setpoint, state: &InnerState) -> ActuatorCommand {
        let force = &setpoint.force_in_world_n;
        let tilt = tilt_from_force(force, setpoint.yaw_des[0], self.tilt_limit_rad);
        self.filter.step(tilt, setpoint.yaw_des, self.dt_s);
        let mut e = state.eta - self.filter.eta;
        e.z = wrap_angle(e.z);
        let e_dot = state.eta_dot - self.filter.eta_dot;
        let tau_eta = match setpoint.rows.law {
            InnerLaw::Rows => self.attitude_rows(setpoint, &e, &e_dot),
            InnerLaw::RateLoop => self.rate_loop(setpoint, &e, &e_dot),
        };
        // tau_eta = E^T moment
        let moment = body_rate_from_euler_rate(&state.eta)
            .transpose()
            .lu()
            .solve(&tau_eta)
            .unwrap_or_else(Vector3::zeros);
        let thrust = setpoint.force_in_world_n.dot(&(world_from_body(&state.eta) * Vector3::z()));
        let (rotor_thrust_n, saturated) = self.allocation.allocate(thrust.max(0.0), &moment);
        ActuatorCommand {
            rotor_thrust_n,
            joint_torque_n_m: self.joint_rows(setpoint, state),
            saturated,
        }
    }
}
