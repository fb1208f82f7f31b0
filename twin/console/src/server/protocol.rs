//! The JSON messages of `/ws`, version 2. `web/src/protocol.ts` is generated from this file and kept fresh by a test.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

pub use crate::server::fork_info::{ForkChange, ForkInfo, ForkMetric, ForkOutcome, ForkState};
pub use crate::server::gain_info::{GainEcho, GainInfo, GainList, PresetName};
pub use crate::server::quantity_info::QuantityInfo;
pub use crate::server::twin_info::{TwinAxis, TwinInfo};
use twin_core::source::Disturbance;
use twin_core::tick::EventKind;
use twin_record::RecordingStatus;
use twin_record::scene::Scene;

/// Version of messages and telemetry; a client of another version asks its user to reload.
pub const PROTOCOL_VERSION: u8 = 2;

/// Events that a new client is told.
pub const EVENTS_KEPT: usize = 200;

/// What the server says.
#[derive(Clone, Debug, Serialize, TS)]
#[serde(rename_all = "snake_case", tag = "type")]
#[expect(clippy::large_enum_variant, reason = "a state is said a few times a second")]
pub enum ServerMessage {
    /// Everything a client needs to start from nothing; first after the connection and after every `reset`.
    Hello(Box<Hello>),
    /// How the flight stands; at least twice a second and on change.
    State(StateInfo),
    /// A gain took effect; to everybody.
    Gain(GainEcho),
    /// All gains after a preset took effect: replaces the list of `hello`, because each has a new preset value.
    Gains(GainList),
    /// Something happened.
    Events {
        /// In the order they happened.
        events: Vec<EventInfo>,
    },
    /// All forks of the flight; after every change of one of them. Their rows are at `/api/forks/{id}/{from}`.
    Forks {
        /// In the order in which they were asked for.
        forks: Vec<ForkInfo>,
    },
    /// For this client alone: why its message had no effect.
    Notice(Notice),
    /// Answer to `ping`.
    Pong {
        /// The number sent.
        t: f64,
        /// Simulated time, s.
        t_s: f64,
    },
    /// The flight starts anew: histories are void; a new `hello` follows.
    Reset {},
}

/// What a client may ask.
#[derive(Clone, Debug, Deserialize, TS)]
#[serde(rename_all = "snake_case", tag = "type", deny_unknown_fields)]
pub enum ClientMessage {
    /// Changes one gain between two ticks.
    SetGain {
        /// Name of the gain.
        name: String,
        /// New value, in the unit of the gain.
        value: f64,
    },
    /// Sets all gains to a preset.
    Preset {
        /// The preset; `custom` is refused.
        name: PresetName,
    },
    /// Stops or resumes the flight.
    Pause {
        /// Stop or resume.
        paused: bool,
    },
    /// Flies some ticks of a paused flight.
    Step {
        /// How many.
        ticks: u32,
    },
    /// Simulated seconds per second; `null` is as fast as the machine can.
    Speed {
        /// Factor.
        value: Option<f64>,
    },
    /// Starts anew.
    Restart {
        /// Seed; `null` keeps the one in use.
        seed: Option<u64>,
        /// Name out of `hello.scenarios`; `null` keeps the one in use.
        scenario: Option<String>,
    },
    /// Asks for a `pong`.
    Ping {
        /// Any number; it comes back.
        t: f64,
    },
    /// Goes to a time of a mirrored recording: histories start anew some seconds before it.
    Seek {
        /// Time of the recording, s; beyond its ends the end is meant.
        t_s: f64,
    },
    /// Copies the flight at a moment and flies the copy ahead with other settings.
    Fork {
        /// Tick before which the copy begins; `null` is the next tick of the flight.
        tick: Option<u64>,
        /// Keys that change, `key=value` each, as in a scenario; none leaves everything as it is.
        set: Vec<String>,
        /// For people; empty takes a number.
        name: String,
    },
    /// Gives a fork another name.
    NameFork {
        /// Its identifier.
        id: u32,
        /// For people.
        name: String,
    },
    /// Forgets a fork.
    DropFork {
        /// Its identifier.
        id: u32,
    },
    /// Changes the world between two ticks.
    Disturb {
        /// What to change.
        #[ts(as = "DisturbanceForm")]
        disturbance: Disturbance,
    },
}

/// The form of a [`Disturbance`] for the generator of protocol.ts.
#[derive(TS)]
#[ts(rename_all = "snake_case", tag = "kind")]
#[ts(rename = "Disturbance")]
pub enum DisturbanceForm {
    /// Mass of the payload.
    PayloadMass {
        /// kg.
        kg: f64,
    },
    /// Mean wind in the world.
    Wind {
        /// m/s.
        velocity_m_s: [f64; 3],
    },
    /// A push on the base.
    Push {
        /// N, in the world.
        force_n: [f64; 3],
        /// s.
        duration_s: f64,
    },
    /// Lets the payload go at once.
    DropPayload,
    /// Switches one aerodynamic effect.
    Effect {
        /// Name of the effect.
        name: String,
        /// In force or not.
        on: bool,
    },
}

/// Everything a client needs to start from nothing.
#[derive(Clone, Debug, Serialize, TS)]
pub struct Hello {
    /// [`PROTOCOL_VERSION`].
    pub protocol: u8,
    /// Which telemetry rows fit these channels and bodies; frames of another id are to be ignored.
    pub schema_id: u16,
    /// Number of this client.
    pub client_id: u64,
    /// Name of the scenario in flight.
    pub scenario: String,
    /// Scenarios that `restart` accepts.
    pub scenarios: Vec<ScenarioInfo>,
    /// Period of a tick, s.
    pub tick_s: f64,
    /// How far the predictor looks into the future, ticks. The channels `fan_*` are known up to there.
    pub horizon_ticks: u32,
    /// Ranges of the numbers that messages carry; those of gains stand with the gains.
    pub quantities: Vec<QuantityInfo>,
    /// Effects that a disturbance of kind `effect` may switch.
    pub effects: Vec<String>,
    /// The recording that is mirrored; `null` if a simulated vehicle flies.
    pub mirror: Option<MirrorInfo>,
    /// What to draw.
    pub scene: Scene,
    /// Channels in the order of a telemetry row.
    pub channels: Vec<ChannelInfo>,
    /// Values that `set_gain` accepts.
    pub gains: Vec<GainInfo>,
    /// Preset in force.
    pub preset: PresetName,
    /// How the flight stands.
    pub state: StateInfo,
    /// The last events, oldest first.
    pub events: Vec<EventInfo>,
    /// The forks of the flight.
    pub forks: Vec<ForkInfo>,
}

/// A real flight from a recording: the loop predicts and adapts beside it, and acts on nothing.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct MirrorInfo {
    /// Name of the file.
    pub file: String,
    /// Name of the map that says which messages mean what.
    pub map: String,
    /// Name of the vehicle.
    pub vehicle: String,
    /// What is drawn instead of the vehicle's own shape, one sentence.
    pub stand_in: String,
    /// What the ghost is, one sentence.
    pub ghost: String,
    /// What predicts, one sentence.
    pub predictor: String,
    /// Where the applied force comes from, one sentence.
    pub force: String,
    /// Rows whose residual is never known; the channels of residual and estimates are NaN there.
    pub unknown_rows: Vec<String>,
    /// Ticks of the recording.
    pub ticks: u64,
    /// Time of the recording, s.
    pub duration_s: f64,
    /// It still goes on: ticks and time are those of now.
    pub live: bool,
    /// What was found wrong or left out, a sentence each.
    pub notes: Vec<String>,
    /// The mass is unknown, so that forces are per kilogram.
    pub per_kilogram: bool,
    /// The phases of the whole recording as events, oldest first; empty if they are not known before they are played.
    pub phases: Vec<EventInfo>,
}

/// A scenario that can be flown.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, TS)]
pub struct ScenarioInfo {
    /// Unique name.
    pub name: String,
    /// For people.
    pub title: String,
}

/// One number of a telemetry row.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct ChannelInfo {
    /// Unique name, `residual.x`.
    pub name: String,
    /// For people.
    pub label: String,
    /// Group it is shown under.
    pub group: String,
    /// Unit, empty if none.
    pub unit: String,
    /// Coordinate it belongs to.
    pub row: Option<String>,
    /// Smallest and largest value that the hardware allows, in the unit of the channel.
    pub limits: Option<[f64; 2]>,
    /// Residuals divided by this are z-scores, in the unit of the channel.
    pub z_scale: Option<f64>,
    /// Known weight of the vehicle that is part of the value, in the unit of the channel; charts leave it out.
    pub weight: Option<f64>,
}

/// How the flight stands.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct StateInfo {
    /// Flying, paused or ended.
    pub phase: FlightPhase,
    /// Simulated seconds per second that are asked for; `null` is as fast as the machine can.
    pub speed: Option<f64>,
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of the run.
    pub seed: u64,
    /// Ticks flown.
    pub tick: u64,
    /// Simulated time, s.
    pub t_s: f64,
    /// Phase of the task.
    pub task_phase: String,
    /// Verdict of a flight that ended.
    pub verdict: Option<String>,
    /// Its reason.
    pub reason: Option<String>,
    /// Simulated seconds per second that are reached.
    pub real_time_factor: f64,
    /// Clients connected.
    pub clients: usize,
    /// Where the time of a tick goes.
    pub stages: Vec<StageCost>,
    /// Mass of the payload, kg; `null` without one.
    pub payload_kg: Option<f64>,
    /// Mean wind in the world, m/s.
    pub wind_m_s: [f64; 3],
    /// Effects that are switched off.
    pub effects_off: Vec<String>,
    /// The twin that flew beside a mirrored recording until now; `null` if a simulated vehicle flies, and until the first tick after
    /// a jump is flown.
    pub twin: Option<Box<TwinInfo>>,
    /// How the newest recording stands; `null` if nothing is recorded.
    pub recording: Option<RecordingStatus>,
}

/// What one stage of a tick costs.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct StageCost {
    /// Name of the stage.
    pub name: String,
    /// Mean wall-clock time per tick since the state before, ms.
    pub ms: f64,
}

/// Whether ticks are flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum FlightPhase {
    /// Ticks are flown.
    Flying,
    /// An operator stopped the clock.
    Paused,
    /// There is a verdict.
    Ended,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct EventInfo {
    /// At which tick.
    pub tick: u64,
    /// At which simulated time, s.
    pub t_s: f64,
    /// What kind of thing.
    #[ts(type = "string")]
    pub kind: EventKind,
    /// One sentence.
    pub text: String,
}

/// A word to one client.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, TS)]
pub struct Notice {
    /// How serious.
    pub level: NoticeLevel,
    /// One sentence.
    pub text: String,
}

/// How serious a notice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum NoticeLevel {
    /// Good to know.
    Info,
    /// The message had no effect.
    Warning,
    /// Something is broken.
    Error,
}
