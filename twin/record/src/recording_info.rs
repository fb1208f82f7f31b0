//! The metadata of a recording, at its start and at its end.

#[cfg(feature = "files")]
use std::collections::BTreeMap;

#[cfg(feature = "files")]
use crate::program;
use crate::scene::Scene;

/// Key in the metadata of a mirrored flight. The unknown numbers of such a recording are written as `null`.
pub const MIRRORED: &str = "mirrored";

/// Key in the metadata of a mirrored flight whose mass is unknown: its forces are per kilogram.
pub const PER_KILOGRAM: &str = "forces_per_kilogram";

/// The metadata that is written at the start of a flight.
#[derive(Clone, Debug)]
pub struct RecordingInfo {
    /// Name of the scenario.
    pub scenario: String,
    /// The scenario as TOML, with every default and every override in it.
    pub scenario_toml: String,
    /// Seed of the run.
    pub seed: u64,
    /// Values in force at the start, as JSON.
    pub gains_json: String,
    /// Limits of the actuators, as JSON.
    pub limits_json: String,
    /// Scale, attention and arithmetic (`kernel`) of the predictor, as JSON.
    pub predictor_json: String,
    /// Arithmetic of the predictor's network. Two flights of one seed are equal only if they use the same.
    pub kernel: String,
    /// The vehicle's URDF.
    pub urdf: String,
    /// Bodies and shapes that viewers draw.
    pub scene: Scene,
    /// URDF names of the arm joints, `q1` first.
    pub joint_names: Vec<String>,
    /// The flight is mirrored: a number that is not finite in its ticks is unknown, and not a fault.
    pub mirrored: bool,
    /// The mass is unknown, and forces are per kilogram.
    pub per_kilogram: bool,
}

/// The metadata that only the end of a flight gives.
#[derive(Clone, Debug, Default)]
pub struct RecordingEnd {
    /// Hash of the flight's final state.
    pub state_hash: u64,
    /// Verdict with its reason; empty if the flight was stopped early.
    pub verdict: String,
}

#[cfg(feature = "files")]
impl RecordingInfo {
    /// The metadata written at the start.
    pub(super) fn metadata(&self) -> BTreeMap<String, String> {
        let flags = [(MIRRORED, self.mirrored), (PER_KILOGRAM, self.per_kilogram)];
        let flags = flags.into_iter().filter(|(_, yes)| *yes);
        let flags = flags.map(|(key, _)| (key.to_owned(), "true".to_owned()));
        let said = [
            ("scenario", self.scenario.clone()),
            ("seed", self.seed.to_string()),
            ("gains", self.gains_json.clone()),
            ("actuator_limits", self.limits_json.clone()),
            ("version", program::VERSION.to_owned()),
            ("git", program::commit().to_owned()),
            ("predictor", self.predictor_json.clone()),
            ("kernel", self.kernel.clone()),
            ("joints", serde_json::json!(self.joint_names).to_string()),
        ]
        .map(|(key, value)| (key.to_owned(), value));
        said.into_iter().chain(flags).collect()
    }
}
