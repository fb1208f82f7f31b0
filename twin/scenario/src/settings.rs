//! The scenario file as types; `scenarios/defaults.toml` explains each key and gives its default.

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

/// Every setting of a scenario file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Title in one line.
    pub title: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The flight ends as timed out after this time, s.
    pub time_limit_s: f64,
    /// The vehicle.
    pub vehicle: VehicleSettings,
    /// Objects around the vehicle.
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
    /// Task to fly.
    pub task: TaskSettings,
    /// Predictor of the residual.
    pub predictor: PredictorSettings,
    /// Control law.
    pub controller: ControllerSettings,
    /// Gains at the start.
    pub gains: GainSettings,
    /// Criteria for the end of the flight.
    pub verdict: VerdictSettings,
    /// Changes of the world at given times.
    #[serde(default)]
    pub disturbances: Vec<Scheduled>,
    /// Failures of the vehicle's parts at given times.
    #[serde(default)]
    pub faults: Vec<ScheduledFailure>,
    /// Keys that change in the air, earliest first.
    #[serde(default)]
    pub changes: Vec<Changed>,
    /// Limits on metrics of the whole flight.
    #[serde(default)]
    pub bounds: BTreeMap<String, Bound>,
    /// Limits on signals over a window.
    #[serde(default)]
    pub checks: Vec<Check>,
    /// A stored flight that this flight must repeat.
    pub golden: Option<GoldenSettings>,
    /// Repeats the scenario with other values of some keys.
    pub sweep: Option<Sweep>,
    /// Expected end of the flight.
    pub expect: Expect,
}

/// Task to fly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskSettings {
    /// Kind of the task.
    pub kind: TaskKind,
    /// Start of the flight.
    pub start: StartKind,
    /// Base position at the start, m.
    pub start_position_m: [f64; 3],
    /// Cruise speed on the path, m/s.
    pub speed_m_s: f64,
    /// Target position of the centre of the cube, m.
    pub place_position_m: [f64; 3],
    /// Joint angles while grasping, rad.
    pub grasp_joints_rad: [f64; 2],
    /// Joint angles during transport, rad.
    pub transit_joints_rad: [f64; 2],
    /// Largest number of attempts before the task gives up.
    pub retry_limit: u32,
    /// Smallest payload whose weight a lift must show, kg.
    pub least_payload_kg: f64,
    /// Duration of a hover or of an excitation, s.
    pub duration_s: f64,
    /// Transport path.
    pub path: PathSettings,
    /// Random way-points.
    pub excitation: ExcitationSettings,
}

/// Kind of the task.
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

/// Start of the flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartKind {
    /// In the air; the payload is at the position in its section.
    Hover,
    /// In the air with the payload in the closed gripper.
    Grasped,
}

/// Transport path of the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathSettings {
    /// Shape of the path.
    pub shape: PathShape,
    /// Start of the S or crossing of the eight, m.
    pub origin_m: [f64; 3],
    /// S: along x, m.
    pub length_m: f64,
    /// S: amplitude to the sides, m.
    pub sway_m: f64,
    /// S: height gained, m.
    pub rise_m: f64,
    /// S: vertical swing, m.
    pub bob_m: f64,
    /// Eight: half extent along x, m.
    pub half_length_m: f64,
    /// Eight: half extent along y, m.
    pub half_width_m: f64,
    /// Eight: number of laps.
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
    /// Largest heading to either side, rad.
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

/// Predictor of the residual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictorSettings {
    /// Kind of the predictor.
    pub kind: PredictorKind,
    /// Width `d_k` of random features.
    pub features: usize,
    /// Seed of random features.
    pub seed: u64,
    /// Unit of the innovation.
    pub units: Units,
    /// File of trained weights, relative to the scenario file; `default` names the weights that are built into the program.
    pub weights: String,
    /// Fly weights even if they were not accepted in closed loop.
    pub force: bool,
    /// Arithmetic of a network; `auto` selects the fastest one for this processor.
    pub kernel: String,
}

/// Kind of the predictor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PredictorKind {
    /// A residual of zero.
    None,
    /// Gravity of the empty vehicle.
    Gravity,
    /// The last residual (time-delay control).
    Persistence,
    /// The residual of rehearsals of the same flight: the upper bound that no method reaches.
    Oracle,
    /// The last residual and its fading slope.
    TdcExtrapolated,
    /// An autoregression that learns in flight by recursive least squares.
    ArxRls,
    /// Gravity and an adapted offset.
    Bias,
    /// Gravity and adapted random features.
    RandomFeatures,
    /// The Factorized Dynamics Transformer.
    Fdt,
    /// The model in the file of weights.
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

/// Control law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerSettings {
    /// Kind of the control law.
    pub kind: ControllerKind,
    /// Rate of the inner controller, Hz: a divisor of 1000, such as 1000, 500, 250 or 125.
    pub inner_hz: f64,
    /// Number of ticks of one period of residual, adapter and control of x y z.
    pub outer_divisor: u32,
    /// Effective inertia about roll, pitch, yaw for the PX4-like rate loop, kg m².
    pub attitude_inertia_kg_m2: [f64; 3],
    /// Nominal inertia `M_bar` per coordinate, kg and kg m².
    pub nominal_inertia: [f64; 8],
    /// The safe set around nominal gravity.
    pub limits: SafeSet,
    /// Settings of L1 adaptive control.
    pub l1: L1Settings,
    /// Excitation that is added to the command.
    pub multisine: MultisineSettings,
}

/// Settings of an L1 controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct L1Settings {
    /// `-A_s`, 1/s.
    pub pole_per_s: f64,
    /// Corner of its low-pass for x y z, then for the other coordinates, rad/s.
    pub cutoff_rad_s: [f64; 2],
}

/// Sines that are added to the command; their phases follow from the scenario's seed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MultisineSettings {
    /// Number of sines per coordinate; 0 switches the excitation off.
    pub tones: usize,
    /// Lowest and highest frequency for x y z, Hz.
    pub force_hz: [f64; 2],
    /// Lowest and highest frequency for the other coordinates, Hz.
    pub moment_hz: [f64; 2],
    /// Root mean square of the excitation per coordinate, N and N m.
    pub rms: [f64; 8],
}

/// Kind of the control law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ControllerKind {
    /// The paper's adaptive law.
    Adaptive,
    /// Plain PID.
    Pid,
    /// L1 adaptive control.
    L1,
}

/// Gains at the start: a preset and the gains that differ from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GainSettings {
    /// Preset to start from.
    pub preset: Preset,
    /// Law on attitude.
    pub inner_law: Option<InnerLaw>,
    /// Error slope per coordinate.
    pub slope: Option<[f64; 8]>,
    /// Damping per coordinate.
    pub damping: Option<[f64; 8]>,
    /// Share of the loop's delay by which the compensation looks ahead, per coordinate.
    pub lead: Option<[f64; 8]>,
    /// Every other parameter by its name in the registry of [`twin_core::tuning::Tuning`].
    #[serde(flatten)]
    pub scalars: BTreeMap<String, f64>,
}

/// A change of the world at a given time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scheduled {
    /// Time of the change, s.
    pub at_s: f64,
    /// The change.
    #[serde(flatten)]
    pub disturbance: Disturbance,
}

/// A failure over a given time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduledFailure {
    /// Begin of the failure, s from the start, or from when the condition is first true.
    pub at_s: f64,
    /// Duration, s; without it the failure lasts to the end of the flight.
    pub duration_s: Option<f64>,
    /// Condition that the failure waits for.
    pub when: Option<Condition>,
    /// The failure.
    #[serde(flatten)]
    pub failure: Failure,
}

/// Keys that change in the air.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Changed {
    /// Time of the change, s: it acts from the first tick at or after it.
    pub at_s: f64,
    /// The changed keys, `key=value` each, as after `--set`.
    pub set: Vec<String>,
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

/// Expected end of the flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// The verdict.
    pub verdict: Verdict,
    /// Name of a check that must fail (a metric, a signal, the kind of an event, or `verdict`): the scenario proves that this check can
    /// fail, and passes only if it does.
    pub fails: Option<String>,
    /// Events that must or must not happen.
    #[serde(default)]
    pub events: Vec<EventCheck>,
}

impl Settings {
    /// Longest time that the flight may take, s.
    pub fn planned_s(&self) -> f64 {
        match self.task.kind {
            TaskKind::Hover | TaskKind::Excitation => self.task.duration_s.min(self.time_limit_s),
            TaskKind::PickPlace | TaskKind::Path => self.time_limit_s,
        }
    }

    /// The settings of the plant.
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
