//! The scenario file as types; what each key means and its default stand in `scenarios/defaults.toml`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::checks::{Check, EventCheck};
use super::ending::{Verdict, VerdictSettings};
use super::golden::GoldenSettings;
use super::sweep::Sweep;
use twin_core::control::{Preset, SafeSet};
use twin_core::flight::Condition;
use twin_core::source::{Disturbance, Failure};
use twin_core::tick::InnerLaw;
use twin_plant::{
    AeroSettings, ArenaSettings, ContactSettings, PayloadSettings, PlantSettings, SensorSettings,
    VehicleSettings, WindSettings,
};

/// Everything a scenario file may say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// One line for people.
    pub title: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The flight ends as timed out after this time, s.
    pub time_limit_s: f64,
    /// The vehicle.
    pub vehicle: VehicleSettings,
    /// What stands around.
    pub arena: ArenaSettings,
    /// The cube.
    pub payload: PayloadSettings,
    /// Aerodynamics.
    pub aero: AeroSettings,
    /// Wind.
    pub wind: WindSettings,
    /// Sensors.
    pub sensors: SensorSettings,
    /// Contact solver.
    pub contact: ContactSettings,
    /// What to fly.
    pub task: TaskSettings,
    /// What predicts the residual.
    pub predictor: PredictorSettings,
    /// What controls.
    pub controller: ControllerSettings,
    /// Gains at the start.
    pub gains: GainSettings,
    /// When the flight is over.
    pub verdict: VerdictSettings,
    /// Changes of the world by time.
    #[serde(default)]
    pub disturbances: Vec<Scheduled>,
    /// Failures of the vehicle's parts by time.
    #[serde(default)]
    pub faults: Vec<ScheduledFailure>,
    /// Limits of metrics of the whole flight.
    #[serde(default)]
    pub bounds: BTreeMap<String, Bound>,
    /// Limits of signals over a window.
    #[serde(default)]
    pub checks: Vec<Check>,
    /// A stored flight to repeat.
    pub golden: Option<GoldenSettings>,
    /// The scenario flown many times with other values of some keys.
    pub sweep: Option<Sweep>,
    /// What the scenario must end with.
    pub expect: Expect,
}

/// What to fly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskSettings {
    /// Which task.
    pub kind: TaskKind,
    /// Where it begins.
    pub start: StartKind,
    /// Base position at the start, m.
    pub start_position_m: [f64; 3],
    /// Cruise speed on the path, m/s.
    pub speed_m_s: f64,
    /// Where the centre of the cube shall rest, m.
    pub place_position_m: [f64; 3],
    /// Arm while grasping, rad.
    pub grasp_joints_rad: [f64; 2],
    /// Arm during transport, rad.
    pub transit_joints_rad: [f64; 2],
    /// Attempts before giving up.
    pub retry_limit: u32,
    /// Lightest payload that a lift is checked against, kg.
    pub least_payload_kg: f64,
    /// Duration of a hover or of an excitation, s.
    pub duration_s: f64,
    /// Transport path.
    pub path: PathSettings,
    /// Random way-points.
    pub excitation: ExcitationSettings,
}

/// Which task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskKind {
    /// Pick, carry, place.
    PickPlace,
    /// Hold a posture.
    Hover,
    /// Fly the transport path only.
    Path,
    /// Fly random way-points.
    Excitation,
}

/// Where a flight begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartKind {
    /// In the air, payload where its section says.
    Hover,
    /// In the air with the payload in the closed gripper.
    Grasped,
}

/// Transport path of the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathSettings {
    /// Which shape.
    pub shape: PathShape,
    /// Start of the S or crossing of the eight, m.
    pub origin_m: [f64; 3],
    /// S: along x, m.
    pub length_m: f64,
    /// S: amplitude to the sides, m.
    pub sway_m: f64,
    /// S: rise, m.
    pub rise_m: f64,
    /// S: vertical swing, m.
    pub bob_m: f64,
    /// Eight: half extent along x, m.
    pub half_length_m: f64,
    /// Eight: half extent along y, m.
    pub half_width_m: f64,
    /// Eight: laps.
    pub laps: f64,
}

/// Random way-points of an excitation, drawn from the scenario's seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExcitationSettings {
    /// Smallest base position, m.
    pub low_m: [f64; 3],
    /// Largest base position, m.
    pub high_m: [f64; 3],
    /// Smallest joint angles, rad.
    pub joints_low_rad: [f64; 2],
    /// Largest joint angles, rad.
    pub joints_high_rad: [f64; 2],
    /// Heading either way, rad.
    pub yaw_rad: f64,
    /// Slowest and fastest mean speed between two way-points, m/s.
    pub mean_speed_m_s: [f64; 2],
    /// Largest acceleration of the reference, m/s².
    pub acceleration_m_s2: f64,
}

/// Shape of the transport path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathShape {
    /// Scenario A of the paper.
    S,
    /// Scenario B of the paper.
    FigureEight,
}

/// What predicts the residual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictorSettings {
    /// Which predictor.
    pub kind: PredictorKind,
    /// Width `d_k` of random features.
    pub features: usize,
    /// Seed of random features.
    pub seed: u64,
    /// Unit of the innovation.
    pub units: Units,
    /// File of trained weights, relative to the scenario file; `default` stands for those the program was built with.
    pub weights: String,
    /// Weights that were not accepted in closed loop fly all the same.
    pub force: bool,
    /// Arithmetic of a network; `auto` is the fastest of this processor.
    pub kernel: String,
}

/// Which predictor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PredictorKind {
    /// Zero.
    None,
    /// Gravity of the empty vehicle.
    Gravity,
    /// The last residual (time-delay control).
    Persistence,
    /// Gravity and an adapted offset.
    Bias,
    /// Gravity and adapted random features.
    RandomFeatures,
    /// The Factorized Dynamics Transformer.
    Fdt,
    /// Whatever model the file of weights is of.
    Trained,
}

/// Unit of the innovation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Units {
    /// Divided by the residual's standard deviation.
    ZScore,
    /// N and N m.
    Physical,
}

/// What controls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSettings {
    /// Which law.
    pub kind: ControllerKind,
    /// Rate of the inner rows, Hz: 1000, 500, 250, 125 or so; a divisor of 1000.
    pub inner_hz: f64,
    /// Residual, adapter and translation rows run every so many ticks.
    pub outer_divisor: u32,
    /// Effective inertia about roll, pitch, yaw for the PX4-like rate loop, kg m².
    pub attitude_inertia_kg_m2: [f64; 3],
    /// Nominal inertia `M_bar` per row, kg and kg m².
    pub nominal_inertia: [f64; 8],
    /// The safe set around nominal gravity.
    pub limits: SafeSet,
    /// L1 adaptive control.
    pub l1: L1Settings,
    /// Excitation on top of the law.
    pub multisine: MultisineSettings,
}

/// What decides how an L1 controller flies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct L1Settings {
    /// `-A_s`, 1/s.
    pub pole_per_s: f64,
    /// Corner of its low-pass of the rows x y z, then of the others, rad/s.
    pub cutoff_rad_s: [f64; 2],
}

/// Sines on top of what the law commands, their phases from the scenario's seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultisineSettings {
    /// Sines per row; none switches the excitation off.
    pub tones: usize,
    /// Slowest and fastest of the rows x y z, Hz.
    pub force_hz: [f64; 2],
    /// Slowest and fastest of the other rows, Hz.
    pub moment_hz: [f64; 2],
    /// Root mean square of each row, N and N m.
    pub rms: [f64; 8],
}

/// Which law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// The paper's.
    Adaptive,
    /// Plain PID.
    Pid,
    /// L1 adaptive control.
    L1,
}

/// Gains at the start: a preset and what differs from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GainSettings {
    /// Where to start from.
    pub preset: Preset,
    /// Law on attitude.
    pub inner_law: Option<InnerLaw>,
    /// Error slope per row.
    pub slope: Option<[f64; 8]>,
    /// Damping per row.
    pub damping: Option<[f64; 8]>,
    /// Every other parameter by its name in the registry of [`twin_core::tuning::Tuning`].
    #[serde(flatten)]
    pub scalars: BTreeMap<String, f64>,
}

/// A change of the world at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scheduled {
    /// When, s.
    pub at_s: f64,
    /// What.
    #[serde(flatten)]
    pub disturbance: Disturbance,
}

/// A failure for a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduledFailure {
    /// When it begins, s: from the start, or from when the condition first holds.
    pub at_s: f64,
    /// How long it lasts, s; to the end of the flight if absent.
    pub duration_s: Option<f64>,
    /// What it waits for.
    pub when: Option<Condition>,
    /// What fails.
    #[serde(flatten)]
    pub failure: Failure,
}

/// Limits of one metric.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// Largest allowed value.
    pub max: Option<f64>,
    /// Smallest allowed value.
    pub min: Option<f64>,
}

/// What the scenario must end with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// The verdict.
    pub verdict: Verdict,
    /// The scenario proves that a test can fail: it passes only if what is named here is broken (a metric, a signal, the kind of
    /// an event, or `verdict`).
    pub fails: Option<String>,
    /// Events that must or must not happen.
    #[serde(default)]
    pub events: Vec<EventCheck>,
}

impl Settings {
    /// The part the plant needs.
    pub fn plant(&self) -> PlantSettings {
        PlantSettings {
            vehicle: self.vehicle.clone(),
            arena: self.arena.clone(),
            payload: self.payload,
            aero: self.aero,
            wind: self.wind,
            sensors: self.sensors,
            contact: self.contact,
        }
    }
}
