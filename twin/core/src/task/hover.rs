//! Hovers at one posture: the simplest task, for tuning, wind and payload steps.

use nalgebra::{Vector2, Vector3};

use super::motion::{Motion, Posture};
use super::{Step, Task, View};
use crate::tick::{GripperCommand, Reference};

/// Hovers at one posture for a time.
#[derive(Clone, Debug)]
pub struct Hover {
    motion: Motion,
    duration_s: f64,
    gripper: GripperCommand,
}

impl Hover {
    /// A hover at `position` (m) with the arm at `joints` (rad) for `duration_s`.
    pub fn new(
        position: Vector3<f64>,
        joints: Vector2<f64>,
        duration_s: f64,
        gripper: GripperCommand,
    ) -> Self {
        let posture = Posture::new(position.x, position.y, position.z, 0.0, joints.x, joints.y);
        Self { motion: Motion::new(posture), duration_s, gripper }
    }
}

impl Task for Hover {
    fn update(&mut self, view: &View<'_>, _dt_s: f64) -> Step {
        Step {
            reference: Reference {
                transporting: self.gripper == GripperCommand::Close,
                ..self.motion.reference(self.gripper)
            },
            phase: "hover",
            events: Vec::new(),
            finished: view.measurement.t_s >= self.duration_s,
            gave_up: None,
        }
    }
}
