//! Settings of plant, sensors and arena in a scenario. Every default is in `scenarios/defaults.toml`.

mod vehicle;
mod parts;
mod air;
mod effects;

use serde::{Deserialize, Serialize};

pub use air::{AeroSettings, WindKind, WindSettings};
pub use parts::{BatterySettings, LinkSettings, MismatchSettings, ServoSettings};
pub use vehicle::{GripperSettings, RotorPlace, RotorSettings, VehicleSettings};

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
    /// Centre of mass in the frame of the cube, whose origin is its middle, m.
    pub centre_of_mass_m: [f64; 3],
    /// Friction coefficient.
    pub friction: f64,
    /// Centre at the start, m; ignored when it starts in the gripper.
    pub position_m: [f64; 3],
    /// Half width of the uniform spread of the start position, m.
    pub position_spread_m: f64,
    /// Spread of the start heading, rad.
    pub yaw_std_rad: f64,
}

/// Sensors; noise is per sample unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorSettings {
    /// Motion capture rate, Hz.
    pub mocap_hz: f64,
    /// Motion capture latency, s: the smallest, and the one that the estimator assumes.
    pub mocap_latency_s: f64,
    /// Link over which the poses of motion capture arrive.
    pub mocap_link: LinkSettings,
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
