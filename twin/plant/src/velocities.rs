//! Generalised velocity of the vehicle.

use nalgebra::Vector6;

/// Velocity of the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Velocities {
    /// Centre of mass of the root body (m/s) and its angular velocity (rad/s), in the world.
    pub(super) root: Vector6<f64>,
    /// Moving joints in the order of [`Articulation::dofs`], rad/s or m/s.
    pub(super) joints: Vec<f64>,
}

impl Velocities {
    /// `self + other * factor`.
    pub(super) fn plus(&self, other: &Self, factor: f64) -> Self {
        Self {
            root: self.root + other.root * factor,
            joints: self.joints.iter().zip(&other.joints).map(|(v, o)| v + o * factor).collect(),
        }
    }
}
