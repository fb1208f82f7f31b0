//! Servos of the arm's joints: what of a commanded torque reaches the joint, and the friction that resists it.

use nalgebra::Vector2;
use rapier3d_f64::prelude::*;

use super::Articulation;
use super::settings::ServoSettings;
use crate::model::Robot;
use twin_core::elementary::{exp, squared};

/// The servos of the arm.
#[derive(Clone, Debug)]
pub(super) struct Servos {
    pub(super) settings: ServoSettings,
    /// Coulomb friction of each joint, N m.
    coulomb_n_m: Vector2<f64>,
    /// Command that each servo follows, N m.
    held: Vector2<f64>,
    /// Part of the servo's period that has passed.
    phase: f64,
    dt_s: f64,
}

impl Servos {
    /// Servos of the joints `arm` of `robot`, with the Coulomb friction of its URDF.
    pub(super) fn new(settings: &ServoSettings, robot: &Robot, arm: &[usize], dt_s: f64) -> Self {
        let friction = |row: usize| arm.get(row).map_or(0.0, |joint| robot.joints[*joint].friction);
        Self::with_friction(settings, Vector2::new(friction(0), friction(1)), dt_s)
    }

    /// Servos of joints with this Coulomb friction, N m.
    pub(super) fn with_friction(
        settings: &ServoSettings,
        coulomb_n_m: Vector2<f64>,
        dt_s: f64,
    ) -> Self {
        Self { settings: *settings, coulomb_n_m, held: Vector2::zeros(), phase: 1.0, dt_s }
    }

    /// Torque on the joints in this step, N m, for the commanded torque and the rates of the joints, rad/s.
    pub(super) fn torque(
        &mut self,
        command_n_m: Vector2<f64>,
        joint_dot: &Vector2<f64>,
    ) -> Vector2<f64> {
        let s = self.settings;
        if !s.on {
            return command_n_m;
        }
        self.phase += s.command_hz * self.dt_s;
        if self.phase >= 1.0 {
            self.phase -= self.phase.floor();
            self.held = command_n_m;
        }
        self.held.zip_map(joint_dot, |torque, rate| limited(torque, rate, &s))
    }

    /// Friction of each joint at these rates, N m: `tau_c (1 + (stiction - 1) exp(-(q_dot / v_s)^2))` (Stribeck; Armstrong-Hélouvry 1994).
    pub(super) fn friction(&self, joint_dot: &Vector2<f64>) -> Vector2<f64> {
        let s = self.settings;
        if !s.on {
            return self.coulomb_n_m;
        }
        self.coulomb_n_m.zip_map(joint_dot, |coulomb, rate| {
            // Rapier panics at a friction that is NaN.
            if rate.is_nan() {
                return coulomb;
            }
            coulomb * (1.0 + (s.stiction - 1.0) * exp(-squared(rate / s.stribeck_rad_s)))
        })
    }

    /// Gives the joints their friction.
    pub(super) fn resist(
        &self,
        world: &mut PhysicsWorld,
        articulation: &Articulation,
        columns: &[usize],
        joint_dot: &Vector2<f64>,
    ) {
        let friction = self.friction(joint_dot);
        if let Some(multibody) = articulation.multibody_mut(world) {
            for (column, friction) in columns.iter().zip(friction.iter()) {
                multibody.frictions_mut()[*column] = *friction;
            }
        }
    }
}

/// The part of a torque that current and voltage allow: a motor that turns gives less torque in the sense in which it turns, and at its
/// free speed none.
fn limited(torque_n_m: f64, rate_rad_s: f64, s: &ServoSettings) -> f64 {
    let driving = torque_n_m.signum() * rate_rad_s / s.free_rad_s;
    let most = s.stall_n_m * (1.0 - driving).clamp(0.0, 1.0);
    // A flight whose state has become infinite ends with its own verdict; until then a limit that is unknown limits nothing.
    if most.is_nan() { torque_n_m } else { torque_n_m.clamp(-most, most) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn servos() -> Servos {
        let settings = ServoSettings {
            on: true,
            command_hz: 500.0,
            stall_n_m: 3.0,
            free_rad_s: 8.0,
            stiction: 1.5,
            stribeck_rad_s: 0.1,
        };
        Servos::with_friction(&settings, Vector2::new(0.02, 0.04), 1e-3)
    }

    #[test]
    fn torque_falls_to_zero_at_the_free_speed_and_braking_keeps_the_stall_torque() {
        let mut servos = servos();
        let rates = Vector2::new(4.0, -4.0);
        assert_eq!(servos.torque(Vector2::new(5.0, 5.0), &rates), Vector2::new(1.5, 3.0));
        let mut free = self::servos();
        assert_eq!(
            free.torque(Vector2::new(5.0, -5.0), &Vector2::new(9.0, -9.0)),
            Vector2::zeros()
        );
    }

    #[test]
    fn a_rate_that_is_not_finite_limits_nothing() {
        let mut servos = servos();
        let rates = Vector2::new(f64::NAN, f64::INFINITY);
        let torque = servos.torque(Vector2::new(5.0, 5.0), &rates);
        assert!((torque.x - 5.0).abs() < 1e-12 && torque.y.abs() < 1e-12, "{torque}");
        let friction = servos.friction(&rates);
        assert!((friction - Vector2::new(0.02, 0.04)).norm() < 1e-12, "{friction}");
    }

    #[test]
    fn a_servo_takes_a_command_at_its_own_rate() {
        let mut servos = servos();
        let still = Vector2::zeros();
        let commands = [0.1, 0.2, 0.3, 0.4].map(|t| servos.torque(Vector2::new(t, 0.0), &still).x);
        let wanted = [0.1_f64, 0.2, 0.2, 0.4];
        assert!(
            commands.iter().zip(wanted).all(|(c, w)| c.to_bits() == w.to_bits()),
            "{commands:?}"
        );
    }

    #[test]
    fn friction_is_largest_at_standstill_and_coulombs_at_speed() {
        let servos = servos();
        assert!((servos.friction(&Vector2::zeros()) - Vector2::new(0.03, 0.06)).norm() < 1e-12);
        let fast = servos.friction(&Vector2::new(1.0, -1.0));
        assert!((fast - Vector2::new(0.02, 0.04)).norm() < 1e-9);
    }
}
