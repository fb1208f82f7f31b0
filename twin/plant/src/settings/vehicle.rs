//! The vehicle in a scenario: its URDF, and the properties that URDF cannot describe.

use serde::{Deserialize, Serialize};

use super::{BatterySettings, LinkSettings, MismatchSettings, ServoSettings};
use crate::PlantError;
use twin_core::notation::MAX_ROTORS;

/// The vehicle: its URDF, and the properties that URDF cannot describe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleSettings {
    /// URDF file, relative to the scenario file's folder or the working folder.
    pub urdf: String,
    /// `name=folder` pairs for `package://`.
    pub packages: Vec<String>,
    /// Joints that have the coordinates q1 and q2; with fewer than two joints the remaining coordinates are masked.
    pub arm_joints: Vec<String>,
    /// Link whose origin is the grasp point; empty if there is none.
    pub tool_link: String,
    /// Rotor inertia seen at each arm joint, kg m².
    pub joint_armature_kg_m2: f64,
    /// Transport delay from joint command to torque, s.
    pub joint_delay_s: f64,
    /// Rotors in order.
    pub rotors: Vec<RotorPlace>,
    /// Properties that all rotors share.
    pub rotor: RotorSettings,
    /// How far the true vehicle may be from what the loop assumes.
    pub mismatch: MismatchSettings,
    /// The battery.
    pub battery: BatterySettings,
    /// Servos of the arm's joints.
    pub servo: ServoSettings,
    /// Link over which the commands reach rotors and joints.
    pub link: LinkSettings,
    /// The gripper.
    pub gripper: GripperSettings,
}

impl VehicleSettings {
    /// Checks that the vehicle has as many rotors as the allocation can use.
    ///
    /// # Errors
    /// [`PlantError::Rotors`] for fewer than three rotors, or more than [`MAX_ROTORS`].
    pub fn check_rotors(&self) -> Result<(), PlantError> {
        match self.rotors.len() {
            3..=MAX_ROTORS => Ok(()),
            found => Err(PlantError::Rotors { found, max: MAX_ROTORS }),
        }
    }
}

/// One rotor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotorPlace {
    /// Position in the root link, m.
    pub position_m: [f64; 3],
    /// +1: turns counter-clockwise seen from above (its reaction torque is negative about body z), -1: clockwise.
    pub spin: f64,
}

/// Rotor properties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotorSettings {
    /// Radius, m.
    pub radius_m: f64,
    /// Smallest commanded thrust, N.
    pub min_thrust_n: f64,
    /// Largest thrust, N.
    pub max_thrust_n: f64,
    /// Reaction torque per thrust, m.
    pub torque_ratio_m: f64,
    /// Thrust per squared rotor speed, N s²/rad².
    pub thrust_coefficient_n_s2: f64,
    /// True time constant of a rotor speed that rises, s.
    pub lag_s: f64,
    /// True time constant of a rotor speed that falls, s: longer, because the air alone brakes the rotor.
    pub fall_lag_s: f64,
    /// Transport delay from command to motor, s.
    pub delay_s: f64,
    /// True thrust divided by the thrust the model expects.
    pub thrust_scale: f64,
    /// Time constant that the model of the applied force assumes, s.
    pub modelled_lag_s: f64,
    /// Area of all blades of a rotor: number of blades × mean chord × radius, m².
    pub blade_area_m2: f64,
    /// Slope of the blades' lift per angle of attack, 1/rad.
    pub lift_slope_per_rad: f64,
    /// Moment on the hub per angle by which the rotor disc tilts, N m/rad.
    pub flap_stiffness_n_m_rad: f64,
}

/// The gripper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripperSettings {
    /// Prismatic joint that drives the fingers; empty if there is no gripper.
    pub joint: String,
    /// Palm link, for the slip measurement.
    pub palm_link: String,
    /// Finger speed while closing and opening, m/s.
    pub close_m_s: f64,
    /// Finger speed while opening, m/s.
    pub open_m_s: f64,
    /// Grip force per finger, N.
    pub force_n: f64,
    /// Friction coefficient of the pads.
    pub friction: f64,
    /// Distance between the open pads, m.
    pub opening_m: f64,
}
