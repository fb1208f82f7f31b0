//! Desired roll and pitch from the desired force (Mellinger and Kumar 2011), and the command filter that gives their rates.

use crate::elementary::{asin, atan2, sin_cos};
use nalgebra::Vector3;

/// Natural frequency of the command filter, rad/s. Without it the desired rates are zero and the loop oscillates by metres.
const COMMAND_FILTER_RAD_S: f64 = 15.0;

/// Damping ratio of the command filter.
const COMMAND_FILTER_ZETA: f64 = 0.9;

/// Delay with which the command filter follows a slow command, `2 zeta / w`, s.
pub const COMMAND_FILTER_DELAY_S: f64 = 2.0 * COMMAND_FILTER_ZETA / COMMAND_FILTER_RAD_S;

/// Roll and pitch, each up to `limit_rad`, that point the body z axis along `force_in_world` at heading `yaw`, rad.
pub fn tilt_from_force(force_in_world: &Vector3<f64>, yaw: f64, limit_rad: f64) -> (f64, f64) {
    let norm = force_in_world.norm();
    if !(norm > 1e-9 && norm.is_finite()) {
        return (0.0, 0.0);
    }
    let z = force_in_world / norm;
    let (sin_yaw, cos_yaw) = sin_cos(yaw);
    let roll = asin((z.x * sin_yaw - z.y * cos_yaw).clamp(-1.0, 1.0));
    let pitch = atan2(z.x * cos_yaw + z.y * sin_yaw, z.z);
    (roll.clamp(-limit_rad, limit_rad), pitch.clamp(-limit_rad, limit_rad))
}

/// Second-order filter on roll and pitch; yaw comes with its own derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct CommandFilter {
    /// Desired attitude, rad.
    pub eta: Vector3<f64>,
    /// Desired rates, rad/s.
    pub eta_dot: Vector3<f64>,
    /// Desired accelerations, rad/s².
    pub eta_ddot: Vector3<f64>,
}

impl CommandFilter {
    /// One step towards `(roll, pitch)` with `yaw_des = [angle, rate, acceleration]`.
    pub fn step(&mut self, (roll, pitch): (f64, f64), yaw_des: [f64; 3], dt_s: f64) {
        let w = COMMAND_FILTER_RAD_S;
        for (axis, target) in [(0, roll), (1, pitch)] {
            self.eta_ddot[axis] = w * w * (target - self.eta[axis])
                - 2.0 * COMMAND_FILTER_ZETA * w * self.eta_dot[axis];
            self.eta_dot[axis] += self.eta_ddot[axis] * dt_s;
            self.eta[axis] += self.eta_dot[axis] * dt_s;
        }
        (self.eta.z, self.eta_dot.z, self.eta_ddot.z) = (yaw_des[0], yaw_des[1], yaw_des[2]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notation::world_from_body;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_thrust_axis_points_along_the_force(x in -5.0..5.0f64, y in -5.0..5.0f64, z in 10.0..40.0f64, yaw in -3.0..3.0f64) {
            let force = Vector3::new(x, y, z);
            let (roll, pitch) = tilt_from_force(&force, yaw, 1.0);
            let axis = world_from_body(&Vector3::new(roll, pitch, yaw)) * Vector3::z();
            // Exact algebra but for rounding.
            prop_assert!((axis - force.normalize()).norm() < 1e-9);
        }
    }

    #[test]
    fn the_filter_reaches_its_target_without_much_overshoot() {
        let mut filter = CommandFilter::default();
        let mut peak: f64 = 0.0;
        for _ in 0..1000 {
            filter.step((0.2, -0.1), [0.3, 0.0, 0.0], 0.002);
            peak = peak.max(filter.eta.x);
        }
        assert!((filter.eta - Vector3::new(0.2, -0.1, 0.3)).norm() < 1e-6);
        assert!(peak < 0.2 * 1.01, "zeta 0.9 overshoots by 0.2 %: {peak}");
    }

    #[test]
    fn no_force_means_level() {
        assert_eq!(tilt_from_force(&Vector3::zeros(), 1.0, 1.0), (0.0, 0.0));
        assert_eq!(tilt_from_force(&Vector3::repeat(f64::NAN), 1.0, 1.0), (0.0, 0.0));
    }
}
