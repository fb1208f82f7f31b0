//! State estimator: it integrates the IMU at 1 kHz and corrects the result by delayed motion capture. It also estimates the biases
//! of accelerometer and gyroscope.
//!
//! In: IMU, motion capture, encoders. Out: coordinates, rates, accelerations. State: position, velocity, attitude, biases and a
//! short history of estimates, with which delayed samples are compared.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector2, Vector3};

use super::sensors::{Imu, Mocap};
use twin_core::filter::Butterworth;
use twin_core::notation::{
    Coords, GRAVITY_M_S2, euler_from_rotation, euler_rate_from_body_rate, wrap_angle,
};

/// Triple pole of the position observer, rad/s: the estimate of the accelerometer bias settles in about a second.
const POSITION_POLE_RAD_S: f64 = 4.0;

/// Double pole of the attitude observer, rad/s.
const ATTITUDE_POLE_RAD_S: f64 = 4.0;

/// Estimates that are kept for delayed samples, one a step: 50 ms.
const HISTORY: usize = 50;

/// Estimated state.
#[derive(Clone, Debug)]
pub(super) struct Estimator {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    /// Accelerometer bias in the body frame, m/s².
    accelerometer_bias: Vector3<f64>,
    rotation: Rotation3<f64>,
    gyro_bias: Vector3<f64>,
    gyro_filter: Butterworth<3>,
    /// Angular rate in the body frame through the gyro's low-pass, rad/s.
    omega: Vector3<f64>,
    eta: Vector3<f64>,
    eta_dot: Vector3<f64>,
    eta_ddot: Vector3<f64>,
    acceleration: Vector3<f64>,
    joint: Vector2<f64>,
    joint_dot: Vector2<f64>,
    joint_ddot: Vector2<f64>,
    joint_period_s: f64,
    mocap_period_s: f64,
    history: VecDeque<(Vector3<f64>, Rotation3<f64>)>,
    dt_s: f64,
}

impl Estimator {
    /// Starts at rest at the given pose and joint angles.
    pub(super) fn new(
        position: Vector3<f64>,
        rotation: Matrix3<f64>,
        joint: Vector2<f64>,
        settings: &super::SensorSettings,
        dt_s: f64,
    ) -> Self {
        let rotation = Rotation3::from_matrix_unchecked(rotation);
        Self {
            position,
            velocity: Vector3::zeros(),
            accelerometer_bias: Vector3::zeros(),
            rotation,
            gyro_bias: Vector3::zeros(),
            gyro_filter: Butterworth::new(settings.gyro_corner_hz, dt_s),
            omega: Vector3::zeros(),
            eta: euler_from_rotation(rotation.matrix()),
            eta_dot: Vector3::zeros(),
            eta_ddot: Vector3::zeros(),
            acceleration: Vector3::zeros(),
            joint,
            joint_dot: Vector2::zeros(),
            joint_ddot: Vector2::zeros(),
            joint_period_s: 1.0 / settings.joint_velocity_hz,
            mocap_period_s: 1.0 / settings.mocap_hz,
            history: VecDeque::with_capacity(HISTORY + 1),
            dt_s,
        }
    }

    /// Integrates one IMU sample over a step of 1 ms.
    pub(super) fn predict(&mut self, imu: &Imu) {
        let dt = self.dt_s;
        let omega = imu.gyro - self.gyro_bias;
        self.rotation *= Rotation3::new(omega * dt);
        self.omega = self.gyro_filter.step(&omega);
        let specific = imu.accelerometer - self.accelerometer_bias;
        self.acceleration = self.rotation * specific - Vector3::new(0.0, 0.0, GRAVITY_M_S2);
        self.velocity += self.acceleration * dt;
        self.position += self.velocity * dt;
        let eta = euler_from_rotation(self.rotation.matrix());
        let psi = self.eta.z + wrap_angle(eta.z - self.eta.z);
        self.eta = Vector3::new(eta.x, eta.y, psi);
        let eta_dot = euler_rate_from_body_rate(&self.eta) * self.omega;
        self.eta_ddot = (eta_dot - self.eta_dot) / dt;
        self.eta_dot = eta_dot;
        if self.history.len() == HISTORY {
            self.history.pop_front();
        }
        self.history.push_back((self.position, self.rotation));
    }

    /// Compares a delayed sample with the estimate of the same time, and corrects the present estimate by the difference.
    pub(super) fn correct(&mut self, mocap: &Mocap) {
        let index = self.history.len().saturating_sub(1 + mocap.age_steps);
        let Some((position, rotation)) = self.history.get(index).copied() else { return };
        let dt = self.mocap_period_s;
        let innovation = mocap.position - position;
        let w = POSITION_POLE_RAD_S;
        self.position += innovation * (3.0 * w * dt);
        self.velocity += innovation * (3.0 * w * w * dt);
        self.accelerometer_bias -= self.rotation.transpose() * innovation * (w * w * w * dt);
        let tilt =
            (rotation.transpose() * Rotation3::from_matrix_unchecked(mocap.rotation)).scaled_axis();
        let w = ATTITUDE_POLE_RAD_S;
        let turn = Rotation3::new(tilt * (2.0 * w * dt));
        self.rotation *= turn;
        self.rotation = orthonormal(&self.rotation);
        self.gyro_bias -= tilt * (w * w * dt);
    }

    /// Takes the joint angles (rad) and rates (rad/s). A `fresh` rate is also differentiated, by the backward difference.
    pub(super) fn encoders(&mut self, joint: Vector2<f64>, joint_dot: Vector2<f64>, fresh: bool) {
        self.joint = joint;
        if fresh {
            self.joint_ddot = (joint_dot - self.joint_dot) / self.joint_period_s;
            self.joint_dot = joint_dot;
        }
    }

    pub(super) fn chi(&self) -> Coords {
        stack(&self.position, &self.eta, &self.joint)
    }

    pub(super) fn chi_dot(&self) -> Coords {
        stack(&self.velocity, &self.eta_dot, &self.joint_dot)
    }

    /// Accelerations of the coordinates, unfiltered, m/s² and rad/s².
    pub(super) fn chi_ddot(&self) -> Coords {
        stack(&self.acceleration, &self.eta_ddot, &self.joint_ddot)
    }

    pub(super) fn eta(&self) -> Vector3<f64> {
        self.eta
    }

    pub(super) fn rotation(&self) -> Matrix3<f64> {
        *self.rotation.matrix()
    }
}

/// Most iterations of [`orthonormal`]; one or two are usual.
const ORTHONORMAL_ITERATIONS: usize = 100;

/// The rotation matrix nearest to a matrix that rounding has made slightly non-orthogonal. `Rotation3::renormalize` does the same
/// without a limit of iterations: near its tolerance of machine epsilon it may cycle forever, and on NaN it always does.
fn orthonormal(rotation: &Rotation3<f64>) -> Rotation3<f64> {
    let mut guess = UnitQuaternion::from(*rotation);
    guess.renormalize();
    Rotation3::from_matrix_eps(
        rotation.matrix(),
        f64::EPSILON,
        ORTHONORMAL_ITERATIONS,
        guess.into(),
    )
}

/// Coordinates χ from position (m), Euler angles (rad) and joint angles (rad); the same for rates and accelerations.
pub(super) fn stack(
    position: &Vector3<f64>,
    attitude: &Vector3<f64>,
    joint: &Vector2<f64>,
) -> Coords {
    Coords::from([
        position.x, position.y, position.z, attitude.x, attitude.y, attitude.z, joint.x, joint.y,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn making_a_rotation_orthonormal_ends_whatever_it_is_given() {
        let nearly = Rotation3::from_euler_angles(0.3, -0.2, 0.1).into_inner() * (1.0 + 1e-9);
        let made = orthonormal(&Rotation3::from_matrix_unchecked(nearly));
        let error = (made.matrix() * made.matrix().transpose() - Matrix3::identity()).norm();
        // The entries are near one, so orthonormality is off by a few roundings of f64.
        assert!(error < 1e-14, "{error:.1e}");
        for unusable in [f64::NAN, f64::INFINITY, 0.0] {
            orthonormal(&Rotation3::from_matrix_unchecked(Matrix3::repeat(unusable)));
        }
    }
}
