//! Failures: parts of the simulated vehicle that stop working for a time that the scenario gives.

use nalgebra::Vector3;
use rapier3d_f64::prelude::ColliderHandle;

use super::SimulatedVehicle;
use twin_core::source::Failure;

impl SimulatedVehicle {
    /// Makes a part fail (`on`), or makes it work again.
    pub(super) fn fail(&mut self, failure: &Failure, on: bool) {
        let only_on =
            |vector: &[f64; 3]| if on { Vector3::from(*vector) } else { Vector3::zeros() };
        let sensors = &mut self.sensors.failures;
        match failure {
            Failure::MocapLoss => sensors.mocap_lost = on,
            Failure::MocapOutlier { offset_m } => sensors.mocap_offset = only_on(offset_m),
            Failure::ImuBias { accelerometer_m_s2, gyro_rad_s } => {
                sensors.accelerometer_bias = only_on(accelerometer_m_s2);
                sensors.gyro_bias = only_on(gyro_rad_s);
            }
            Failure::EncoderDropout => sensors.encoders_dead = on,
            Failure::MotorEfficiency { rotor, factor } => {
                if let Some(efficiency) = self.propulsion.rotors.efficiency.get_mut(*rotor) {
                    *efficiency = if on { *factor } else { 1.0 };
                }
            }
            Failure::GripperSlip { friction } => self.slip(on.then_some(*friction)),
            Failure::Gust { velocity_m_s } => self.failures.gust = only_on(velocity_m_s),
            Failure::ComputerStall => self.failures.stalled = on,
            // `flight` wraps the predictor for this failure; the plant does nothing.
            Failure::PredictorNan => {}
        }
    }

    /// Sets the friction coefficient of pads and payload, or restores their own with `None`.
    fn slip(&mut self, friction: Option<f64>) {
        match friction {
            Some(friction) => {
                let colliders = self.grip_colliders();
                let healthy = colliders.into_iter().filter_map(|handle| {
                    self.world.colliders.get(handle).map(|c| (handle, c.friction()))
                });
                if self.failures.healthy_friction.is_empty() {
                    self.failures.healthy_friction = healthy.collect();
                }
                self.set_grip_friction(friction);
            }
            None => {
                for (handle, friction) in std::mem::take(&mut self.failures.healthy_friction) {
                    if let Some(collider) = self.world.colliders.get_mut(handle) {
                        collider.set_friction(friction);
                    }
                }
            }
        }
    }

    /// Colliders whose friction holds the payload: the pads and the cube.
    fn grip_colliders(&self) -> Vec<ColliderHandle> {
        let pads = self.gripper.iter().flat_map(|gripper| gripper.pads.iter().copied());
        pads.chain(self.arena.payload_collider).collect()
    }

    /// Sets the friction coefficient of pads and payload.
    pub(super) fn set_grip_friction(&mut self, friction: f64) {
        for handle in self.grip_colliders() {
            if let Some(collider) = self.world.colliders.get_mut(handle) {
                collider.set_friction(friction);
            }
        }
    }
}
