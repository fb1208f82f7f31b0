//! Settings of plant, sensors and arena in a scenario. Every default is in `scenarios/defaults.toml`.

use serde::{Deserialize, Serialize};

use super::PlantError;
use twin_core::notation::MAX_ROTORS;

/// Every setting of the simulated source.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantSettings {
    /// The vehicle.
    pub vehicle: VehicleSettings,
    /// Objects around the vehicle.
    pub arena: ArenaSettings,
    /// The cube.
    pub payload: PayloadSettings,
    /// Aerodynamic effects.
    pub aero: AeroSettings,
    /// Wind.
    pub wind: WindSettings,
    /// Sensors.
    pub sensors: SensorSettings,
    /// Contact solver.
    pub contact: ContactSettings,
}

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
    /// True time constant of the rotor speed, s.
    pub lag_s: f64,
    /// Transport delay from command to motor, s.
    pub delay_s: f64,
    /// True thrust divided by the thrust the model expects.
    pub thrust_scale: f64,
    /// Time constant that the model of the applied force assumes, s.
    pub modelled_lag_s: f64,
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

/// Objects around the vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArenaSettings {
    /// Fixed objects.
    pub objects: Vec<ArenaObject>,
    /// Friction coefficient of floor and objects.
    pub friction: f64,
}

/// One fixed object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArenaObject {
    /// Name of the object in the scene.
    pub name: String,
    /// URDF file.
    pub urdf: String,
    /// Origin of its root link in the world, m.
    pub position_m: [f64; 3],
}

/// The cube.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PayloadSettings {
    /// Mass, kg; 0 leaves the cube out.
    pub mass_kg: f64,
    /// Edge, m.
    pub size_m: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Centre at the start, m; ignored when it starts in the gripper.
    pub position_m: [f64; 3],
    /// Half width of the uniform spread of the start position, m.
    pub position_spread_m: f64,
    /// Spread of the start heading, rad.
    pub yaw_std_rad: f64,
}

/// Aerodynamic effects, each with its own switch.
#[expect(clippy::struct_excessive_bools, reason = "independent effects, each with its switch")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AeroSettings {
    /// Drag of the rotors, proportional to thrust and air speed.
    pub rotor_drag: bool,
    /// Rotor drag at 30 N of thrust per axis, N s/m.
    pub rotor_drag_n_s_m: [f64; 3],
    /// Quadratic drag of the body.
    pub body_drag: bool,
    /// Body drag, N s²/m².
    pub body_drag_n_s2_m2: f64,
    /// Increase of thrust near floor, box and table.
    pub ground_effect: bool,
    /// Effective radius of the ground effect, m.
    pub ground_effect_radius_m: f64,
    /// Wake of the rotors on arm and payload.
    pub downwash: bool,
    /// Time constant with which the wake builds up, s.
    pub wake_s: f64,
    /// Drag area of each arm link in the wake, m².
    pub link_drag_area_m2: f64,
    /// Unsteady force of the vehicle's own flow, standard deviation, N.
    pub turbulence_n: f64,
    /// Unsteady moment, standard deviation, N m.
    pub turbulence_n_m: f64,
    /// Correlation time of the unsteady force and moment, s.
    pub turbulence_s: f64,
}

/// Wind model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WindKind {
    /// The mean velocity.
    Constant,
    /// Mean plus a 1-cos gust of `gust_m_s` lasting `gust_s` every `gust_period_s`.
    Gust,
    /// Mean plus Dryden turbulence of `turbulence_m_s`.
    Dryden,
}

/// Wind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindSettings {
    /// Model.
    pub kind: WindKind,
    /// Mean velocity in the world, m/s.
    pub velocity_m_s: [f64; 3],
    /// Peak of a gust along the mean (or x if there is no mean), m/s.
    pub gust_m_s: f64,
    /// Duration of a gust, s.
    pub gust_s: f64,
    /// Time between gusts, s.
    pub gust_period_s: f64,
    /// Standard deviation of the Dryden turbulence, m/s.
    pub turbulence_m_s: f64,
    /// Scale length of the Dryden turbulence, m.
    pub scale_m: f64,
}

/// Sensors; noise is per sample unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSettings {
    /// Motion capture rate, Hz.
    pub mocap_hz: f64,
    /// Motion capture latency, s.
    pub mocap_latency_s: f64,
    /// Motion capture position noise, m.
    pub mocap_noise_m: f64,
    /// Motion capture attitude noise, rad.
    pub mocap_noise_rad: f64,
    /// Fixed calibration error of the payload's markers, m.
    pub payload_calibration_m: f64,
    /// Accelerometer noise at 1 kHz, m/s².
    pub accelerometer_noise_m_s2: f64,
    /// Accelerometer bias, standard deviation between flights, m/s².
    pub accelerometer_bias_m_s2: f64,
    /// Vibration at each rotor's turning frequency at hover, m/s².
    pub vibration_m_s2: f64,
    /// Gyro noise at 1 kHz, rad/s.
    pub gyro_noise_rad_s: f64,
    /// Gyro bias, standard deviation between flights, rad/s.
    pub gyro_bias_rad_s: f64,
    /// Corner of the gyro's low-pass, Hz.
    pub gyro_corner_hz: f64,
    /// Joint encoder counts per turn.
    pub encoder_counts: f64,
    /// Rate at which joint velocity is read, Hz.
    pub joint_velocity_hz: f64,
    /// Resolution of the joint velocity, rad/s.
    pub joint_velocity_step_rad_s: f64,
}

/// Contact solver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSettings {
    /// Solver iterations (substeps) per 1 ms step.
    pub iterations: usize,
    /// Sweeps of the solver over all constraints in a substep.
    pub sweeps: usize,
    /// Natural frequency of contacts between moving bodies, Hz.
    pub frequency_hz: f64,
    /// Natural frequency of contacts with fixed bodies, Hz.
    pub static_frequency_hz: f64,
}
