//! The force budget: which forces accelerate the vehicle.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Forces on the vehicle in the world, N, as means over one control period. Mass times acceleration of the root link's origin is their
/// sum; `unexplained` is what is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ForceBudget {
    /// Mass of the vehicle without payload times acceleration of the root link's origin.
    pub inertia: Vector3<f64>,
    /// Thrust that the rotors give at their speed in still air far from everything.
    pub thrust: Vector3<f64>,
    /// Weight of the vehicle without payload.
    pub gravity: Vector3<f64>,
    /// Reaction of the arm: its links accelerate differently from the root link's origin.
    pub arm: Vector3<f64>,
    /// Force of the payload on the gripper.
    pub payload: Vector3<f64>,
    /// Drag of body, arm and rotors through still air.
    pub drag: Vector3<f64>,
    /// Change of thrust by the air that flows through the rotors.
    pub inflow: Vector3<f64>,
    /// Change of thrust by the ground.
    pub ground: Vector3<f64>,
    /// Force of the rotors' wakes on the arm.
    pub wake: Vector3<f64>,
    /// What the wind adds to the drag.
    pub wind: Vector3<f64>,
    /// Unsteady flow around the vehicle.
    pub unsteady: Vector3<f64>,
    /// Contacts with anything but the payload.
    pub contact: Vector3<f64>,
    /// Push by an operator or a scenario.
    pub push: Vector3<f64>,
    /// Inertia without all forces above.
    pub unexplained: Vector3<f64>,
}

impl ForceBudget {
    /// Names of the forces, in the order of [`Self::forces`].
    pub const NAMES: [&str; 12] = [
        "thrust", "gravity", "arm", "payload", "drag", "inflow", "ground", "wake", "wind",
        "unsteady", "contact", "push",
    ];

    /// All forces that are explained, N.
    pub fn forces(&self) -> [Vector3<f64>; 12] {
        [
            self.thrust,
            self.gravity,
            self.arm,
            self.payload,
            self.drag,
            self.inflow,
            self.ground,
            self.wake,
            self.wind,
            self.unsteady,
            self.contact,
            self.push,
        ]
    }

    /// All forces and the inertia times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            inertia: self.inertia * factor,
            thrust: self.thrust * factor,
            gravity: self.gravity * factor,
            arm: self.arm * factor,
            payload: self.payload * factor,
            drag: self.drag * factor,
            inflow: self.inflow * factor,
            ground: self.ground * factor,
            wake: self.wake * factor,
            wind: self.wind * factor,
            unsteady: self.unsteady * factor,
            contact: self.contact * factor,
            push: self.push * factor,
            unexplained: self.unexplained * factor,
        }
    }

    /// The budget with the force that is missing.
    #[must_use]
    pub fn closed(mut self) -> Self {
        self.unexplained = self.inertia - self.forces().iter().sum::<Vector3<f64>>();
        self
    }
}
