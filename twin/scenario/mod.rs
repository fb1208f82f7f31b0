//! One TOML file, one flight, one verdict.

mod assemble;
mod document;
pub mod file;
mod limits;
mod merge;
pub mod metrics;
pub mod run;
pub mod scene;
pub mod settings;
pub mod table;
pub mod verdict;

use std::path::{Path, PathBuf};

pub use file::ScenarioError;
pub use run::{Report, fly};
pub use settings::Settings;
pub use verdict::{Judge, Verdict};

pub use crate::control::Preset;
use crate::flight::{Flight, Parts};
use crate::mirror::RecordingInfo;
use crate::mirror::scene::Scene;
use crate::tuning::Tuning;

/// Every key of a scenario with its default; also the schema.
pub const DEFAULTS: &str = include_str!("../../scenarios/defaults.toml");

/// A scenario ready to fly.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// File name without its ending.
    pub name: String,
    /// Where the file lies; model files are relative to its folder.
    pub file: PathBuf,
    /// What it says.
    pub settings: Settings,
}

impl Scenario {
    /// The scenario in `file` over the defaults, under `overrides` (`key=value` each).
    ///
    /// # Errors
    /// [`ScenarioError`] naming file, line, key, what was found and what is allowed.
    pub fn load(file: &Path, overrides: &[String]) -> Result<Self, ScenarioError> {
        let settings = file::read::<Settings>(file, DEFAULTS, overrides)?;
        let scenario = Self {
            name: file
                .file_stem()
                .map_or_else(|| "scenario".into(), |stem| stem.to_string_lossy().into_owned()),
            file: file.to_owned(),
            settings,
        };
        scenario.tuning().map_err(|error| ScenarioError::Value {
            place: file.display().to_string(),
            key: "gains".into(),
            reason: error.to_string(),
        })?;
        Ok(scenario)
    }

    /// The flight at its first tick.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable or does not fit the scenario.
    pub fn build(&self) -> Result<Flight, BuildError> {
        self.parts().map(Flight::new)
    }

    /// The parts of the flight, for whoever flies them with another source, predictor or task.
    ///
    /// # Errors
    /// As [`Scenario::build`].
    pub fn parts(&self) -> Result<Parts, BuildError> {
        assemble::parts(self)
    }

    /// The values a preset stands for in this scenario.
    pub fn preset_tuning(&self, preset: Preset) -> Tuning {
        assemble::preset_tuning(&self.settings, preset)
    }

    /// The values in force at the start.
    ///
    /// # Errors
    /// [`crate::tuning::TuningError`] for a value out of range.
    pub fn tuning(&self) -> Result<Tuning, crate::tuning::TuningError> {
        assemble::tuning(&self.settings)
    }

    /// What the viewers draw.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable.
    pub fn scene(&self) -> Result<Scene, BuildError> {
        scene::scene(self)
    }

    /// Text of the vehicle's URDF.
    ///
    /// # Errors
    /// [`BuildError::Unreadable`] if it cannot be read.
    pub fn urdf_text(&self) -> Result<String, BuildError> {
        let path = self.folder().join(&self.settings.vehicle.urdf);
        std::fs::read_to_string(&path).map_err(|error| BuildError::Unreadable {
            file: path.display().to_string(),
            reason: error.to_string(),
        })
    }

    /// What a recording says about a flight of this scenario that starts with `tuning`.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable.
    pub fn recording_info(&self, tuning: &Tuning) -> Result<RecordingInfo, BuildError> {
        let unwritable = |what: &'static str| {
            move |error: &dyn std::fmt::Display| BuildError::Unfit {
                key: what,
                reason: format!("cannot be written into a recording: {error}"),
            }
        };
        Ok(RecordingInfo {
            scenario: self.name.clone(),
            scenario_toml: toml::to_string(&self.settings)
                .map_err(|e| unwritable("scenario")(&e))?,
            seed: self.settings.seed,
            gains_json: serde_json::to_string(tuning).map_err(|e| unwritable("gains")(&e))?,
            urdf: self.urdf_text()?,
            scene: self.scene()?,
            joint_names: self.settings.vehicle.arm_joints.clone(),
        })
    }

    /// Folder of the scenario file.
    pub(crate) fn folder(&self) -> &Path {
        self.file.parent().unwrap_or_else(|| Path::new("."))
    }
}

/// Why a scenario that reads well cannot be flown.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A model file.
    #[error(transparent)]
    Model(#[from] crate::model::ModelError),
    /// The plant.
    #[error(transparent)]
    Plant(#[from] crate::plant::PlantError),
    /// Gains.
    #[error(transparent)]
    Tuning(#[from] crate::tuning::TuningError),
    /// A file cannot be read.
    #[error("{file}: {reason}")]
    Unreadable {
        /// File.
        file: String,
        /// The system's words.
        reason: String,
    },
    /// A value that only makes sense with another.
    #[error("{key}: {reason}")]
    Unfit {
        /// Key.
        key: &'static str,
        /// What is wrong and what to do.
        reason: String,
    },
}
