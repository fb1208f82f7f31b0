//! A scenario: one TOML file describes one flight and gives one verdict.

pub mod checks;
pub mod golden;
#[cfg(feature = "suite")]
pub mod markup;
#[cfg(feature = "suite")]
pub mod plot;
pub mod sweep;
mod ending;
pub mod settings;
mod document;
mod merge;
pub mod file;
mod demands;
mod rms;
mod coverage;
mod course;
pub mod verdict;
pub mod metrics;
mod failures;
mod trained;
mod mission;
mod assemble;
pub mod differences;
mod changes;
pub mod scene;
pub mod run;
mod judged;
mod moved;
pub mod fork;
mod rehearsal;
mod parallel;
#[cfg(feature = "suite")]
mod variations;
#[cfg(feature = "suite")]
pub mod collect;
#[cfg(feature = "suite")]
pub mod cache;
#[cfg(feature = "suite")]
pub mod table;
pub mod acceptance;
mod json_schema;
#[cfg(feature = "suite")]
pub mod suite;

use std::path::{Path, PathBuf};

pub use checks::{Check, ReadSignal, Violation, limited_signal};
pub use ending::Verdict;
pub use file::ScenarioError;
pub use json_schema::json_schema;
pub use judged::{Judgement, Row, Values, side_by_side as metrics_side_by_side};
pub use parallel::side_by_side;
pub use run::{Assessor, Report, fly, fly_until_signal};
pub use scene::ActuatorLimits;
pub use settings::Settings;
pub use verdict::Judge;

pub use twin_core::control::Preset;
use twin_core::flight::{Flight, Parts};
use twin_core::notation::GRAVITY_M_S2;
use twin_core::residual::PredictorInfo;
use twin_core::residual::weights::WeightsError;
use twin_core::tuning::{Parameter, Tuning};
use twin_input::budget::URDF_BYTES;
#[cfg(feature = "suite")]
use twin_plant::model::Packages;
use twin_record::RecordingInfo;
use twin_record::scene::Scene;

/// Text of the defaults: every key of a scenario with its default value; also the schema.
pub const DEFAULTS: &str = include_str!("../../../scenarios/defaults.toml");

/// A scenario ready to fly.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// File name without its ending.
    pub name: String,
    /// Path of the file; model files are relative to its folder.
    pub file: PathBuf,
    /// Settings that the file contains.
    pub settings: Settings,
}

/// Files of a scenario's vehicle, and the names of its arm's joints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VehicleFiles {
    /// URDF.
    pub urdf: PathBuf,
    /// Name and folder of each package that contains meshes.
    pub packages: Vec<(String, PathBuf)>,
    /// Names of the arm's joints.
    pub joints: Vec<String>,
}

impl Scenario {
    /// The scenario in `file` merged over the defaults, with `overrides` (`key=value` each).
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
        scenario.checked()?;
        changes::after_each(&scenario)?;
        Ok(scenario)
    }

    /// This scenario with `overrides` (`key=value` each) over its settings. Changes to come are not taken along.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the override, what was found and what is allowed.
    pub fn with(&self, overrides: &[String]) -> Result<Self, ScenarioError> {
        let settings = changes::without_changes(&self.settings);
        let text = toml::to_string(&settings).map_err(|error| ScenarioError::Value {
            place: self.file.display().to_string(),
            key: "settings".into(),
            reason: format!("cannot be written as TOML: {error}"),
        })?;
        let settings = file::read_text::<Settings>(&text, &self.file, DEFAULTS, overrides)?;
        let scenario = Self { settings, ..self.clone() };
        scenario.checked()?;
        Ok(scenario)
    }

    /// Refuses gains out of range, and demands that cannot be judged.
    fn checked(&self) -> Result<(), ScenarioError> {
        let refused = |key: String, reason: String| ScenarioError::Value {
            place: self.file.display().to_string(),
            key,
            reason,
        };
        self.tuning().map_err(|error| refused("gains".into(), error.to_string()))?;
        demands::validate(&self.settings).map_err(|error| refused(error.key, error.reason))
    }

    /// The scenario that stands for a recording while `file` is mirrored: the defaults, which are not flown.
    ///
    /// # Errors
    /// [`BuildError`] if the defaults cannot be read.
    pub fn of_recording(name: &str, file: &Path) -> Result<Self, BuildError> {
        let mut settings =
            file::read_text::<Settings>("", file, DEFAULTS, &[]).map_err(|error| {
                BuildError::Unreadable { file: "defaults".into(), reason: error.to_string() }
            })?;
        // A recording does not contain the mass of its payload.
        settings.payload.mass_kg = 0.0;
        Ok(Self { name: name.to_owned(), file: file.to_owned(), settings })
    }

    /// This scenario with the gains of `tuning` written out; those beyond the range of a scenario stay as they are.
    #[must_use]
    pub fn with_gains(mut self, tuning: &Tuning) -> Self {
        let allowed = |parameter: &Parameter| {
            let value = tuning.get(&parameter.name)?;
            parameter.quantity.allows(value).then_some(value)
        };
        let parameters = Tuning::parameters();
        let row = |stem: &str| -> Option<Vec<f64>> {
            let of = parameters
                .iter()
                .filter(|p| p.name.split_once('.').is_some_and(|(s, _)| s == stem));
            of.map(allowed).collect()
        };
        let list = |stem: &str| row(stem)?.try_into().ok();
        let scalars = parameters.iter().filter(|parameter| !parameter.name.contains('.'));
        let named = scalars.filter_map(|p| Some((p.name.clone(), allowed(p)?)));
        let gains = &mut self.settings.gains;
        gains.inner_law = Some(tuning.gains.inner_law);
        gains.slope = list("slope").or(gains.slope);
        gains.damping = list("damping").or(gains.damping);
        gains.lead = list("lead").or(gains.lead);
        gains.scalars.extend(named);
        self
    }

    /// The flight at its first tick.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable or does not fit the scenario.
    pub fn build(&self) -> Result<Flight, BuildError> {
        let mut flight = Flight::new(self.parts()?);
        flight.set_alterations(changes::alterations(self)?);
        Ok(flight)
    }

    /// The parts of the flight, for flying them with another source, predictor or task.
    ///
    /// # Errors
    /// The errors of [`Scenario::build`].
    pub fn parts(&self) -> Result<Parts, BuildError> {
        rehearsal::parts(self)
    }

    /// The vehicle as its URDF describes it.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable.
    pub fn robot(&self) -> Result<twin_plant::model::Robot, BuildError> {
        Ok(assemble::models(self)?.robot)
    }

    /// Weight of the vehicle without payload, N.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable.
    pub fn weight_n(&self) -> Result<f64, BuildError> {
        Ok(self.robot()?.total_mass_kg() * GRAVITY_M_S2)
    }

    /// The values of a preset in this scenario.
    pub fn preset_tuning(&self, preset: Preset) -> Tuning {
        assemble::preset_tuning(&self.settings, preset)
    }

    /// The values in force at the start.
    ///
    /// # Errors
    /// [`twin_core::tuning::TuningError`] for a value out of range.
    pub fn tuning(&self) -> Result<Tuning, twin_core::tuning::TuningError> {
        assemble::tuning(&self.settings)
    }

    /// The scene for the viewers.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable.
    pub fn scene(&self) -> Result<Scene, BuildError> {
        scene::scene(self)
    }

    /// The limits of the vehicle's actuators.
    ///
    /// # Errors
    /// [`BuildError`] if a model file is not usable.
    pub fn actuator_limits(&self) -> Result<ActuatorLimits, BuildError> {
        scene::actuator_limits(self)
    }

    /// Text of the vehicle's URDF.
    ///
    /// # Errors
    /// [`BuildError::Unreadable`] if it cannot be read.
    pub fn urdf_text(&self) -> Result<String, BuildError> {
        let path = self.folder().join(&self.settings.vehicle.urdf);
        twin_input::file::read_text(&path, URDF_BYTES).map_err(|error| BuildError::Unreadable {
            file: path.display().to_string(),
            reason: error.to_string(),
        })
    }

    /// Properties of the predictor that are known before its first forecast.
    ///
    /// # Errors
    /// [`BuildError`] if its weights are not usable.
    pub fn predictor_info(&self) -> Result<PredictorInfo, BuildError> {
        assemble::predictor_info(self)
    }

    /// Paths of the vehicle's files.
    ///
    /// # Errors
    /// [`BuildError::Unfit`] if a package has no name or no folder.
    pub fn vehicle_files(&self) -> Result<VehicleFiles, BuildError> {
        Ok(VehicleFiles {
            urdf: self.folder().join(&self.settings.vehicle.urdf),
            packages: assemble::packages(self)?,
            joints: self.settings.vehicle.arm_joints.clone(),
        })
    }

    /// The files that a flight of this scenario reads, as far as they can be found; no output may replace them. The golden run is one of
    /// them.
    #[cfg(feature = "suite")]
    pub fn input_files(&self) -> Vec<PathBuf> {
        let folder = self.folder();
        let Settings { vehicle, arena, predictor, golden, .. } = &self.settings;
        let packages = Packages(assemble::packages(self).unwrap_or_default());
        let models = arena.objects.iter().map(|object| &object.urdf).chain([&vehicle.urdf]);
        let mut files = vec![self.file.clone()];
        files.extend(models.flat_map(|urdf| packages.files(&folder.join(urdf))));
        files.push(folder.join(&predictor.weights));
        files.extend(golden.iter().map(|golden| folder.join(&golden.file)));
        files
    }

    /// Metadata of the recording of a flight of this scenario that starts with `tuning`.
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
            mirrored: false,
            per_kilogram: false,
            scenario: self.name.clone(),
            scenario_toml: toml::to_string(&self.settings)
                .map_err(|e| unwritable("scenario")(&e))?,
            seed: self.settings.seed,
            gains_json: serde_json::to_string(tuning).map_err(|e| unwritable("gains")(&e))?,
            limits_json: serde_json::to_string(&self.actuator_limits()?)
                .map_err(|e| unwritable("vehicle")(&e))?,
            predictor_json: serde_json::to_string(&self.predictor_info()?)
                .map_err(|e| unwritable("predictor")(&e))?,
            kernel: self.predictor_info()?.kernel,
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

/// Reason why a valid scenario cannot be flown.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A model file is not usable.
    #[error(transparent)]
    Model(#[from] twin_plant::model::ModelError),
    /// The plant cannot be built.
    #[error(transparent)]
    Plant(#[from] twin_plant::PlantError),
    /// A gain is refused.
    #[error(transparent)]
    Tuning(#[from] twin_core::tuning::TuningError),
    /// Trained weights are not usable.
    #[error("predictor.weights: {file}: {error}")]
    Weights {
        /// File.
        file: String,
        /// Reason.
        error: WeightsError,
    },
    /// A file cannot be read.
    #[error("{file}: {reason}")]
    Unreadable {
        /// File.
        file: String,
        /// Error of the operating system.
        reason: String,
    },
    /// A value contradicts another value.
    #[error("{key}: {reason}")]
    Unfit {
        /// Key.
        key: &'static str,
        /// What is wrong and how to correct it.
        reason: String,
    },
    /// A change in the air is not possible.
    #[error(transparent)]
    Change(Box<ScenarioError>),
    /// A signal asked the program to end before the flight was over.
    #[error(transparent)]
    Interrupted(#[from] twin_input::interruption::Interrupted),
}

impl From<ScenarioError> for BuildError {
    fn from(error: ScenarioError) -> Self {
        Self::Change(Box::new(error))
    }
}
