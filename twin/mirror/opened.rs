//! A recording opened: what it holds, what it means, the flight on ticks.

use std::path::{Path, PathBuf};

use super::container::ContainerError;
use super::effort::Effort;
use super::gather::gather;
use super::recorded::{MirrorError, RecordedFlight, on_ticks};
use super::recording::{RecordingError, TICK_TOPIC};
use super::replayed::replayed;
use super::signals::{Signals, signals};
use super::survey::Survey;
use super::topics::{Map, MapError, SHIPPED};

/// Most topics that an error lists.
const SHOWN_TOPICS: usize = 30;

/// What is said about a recording of this program.
const AS_RECORDED: &str =
    "recorded by this program: measurements are taken as they are, nothing is resampled";

/// A recording with its flight.
#[derive(Clone, Debug)]
pub struct OpenedFlight {
    /// The file.
    pub path: PathBuf,
    /// What it holds.
    pub survey: Survey,
    /// Which messages mean what.
    pub map: Map,
    /// Name of the map.
    pub map_name: String,
    /// What was chosen.
    pub signals: Signals,
    /// The flight.
    pub recorded: RecordedFlight,
}

/// Why a recording cannot be mirrored.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Nothing can be read.
    #[error("{path}: {why}", path = path.display())]
    Container {
        /// The file.
        path: PathBuf,
        /// Why.
        why: ContainerError,
    },
    /// The map is neither shipped nor a file.
    #[error("--map {name}: not a shipped map ({shipped}) and not a file that can be read: {why}")]
    MapFile {
        /// As given.
        name: String,
        /// Maps that come with the program.
        shipped: String,
        /// The system's words.
        why: String,
    },
    /// The map is not usable.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A recording of this program that cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// There is no flight in it.
    #[error("{path}: {why}; topics found: {topics}", path = path.display())]
    Mirror {
        /// The file.
        path: PathBuf,
        /// Why.
        why: MirrorError,
        /// What the recording has.
        topics: String,
    },
}

/// The map that is asked for, or that of the recognised family, over the generic rules; with its name.
///
/// # Errors
/// [`OpenError`] if it cannot be read or is not usable.
pub fn choose_map(
    wanted: Option<&str>,
    family: Option<&'static str>,
) -> Result<(Map, String), OpenError> {
    let (own, name) = match (wanted, family) {
        (Some(name), _) if Map::shipped(name).is_some() => (Map::shipped(name), name.to_owned()),
        (Some(file), _) => {
            let text = std::fs::read_to_string(Path::new(file)).map_err(|why| {
                let shipped = SHIPPED.map(|(name, _)| name).join(", ");
                OpenError::MapFile { name: file.to_owned(), shipped, why: why.to_string() }
            })?;
            (Some(Map::parse(&text, file)?), file.to_owned())
        }
        (None, Some(name)) => (Map::shipped(name), name.to_owned()),
        (None, None) => (None, "generic".to_owned()),
    };
    Ok((Map::over_generic(own.unwrap_or_default())?, name))
}

/// What `path` holds under the map that is asked for or recognised.
///
/// # Errors
/// [`OpenError`] if nothing can be read, or the map is not usable.
pub fn survey(path: &Path, map: Option<&str>) -> Result<(Survey, Map, String), OpenError> {
    let mut survey =
        Survey::read(path).map_err(|why| OpenError::Container { path: path.to_owned(), why })?;
    let (map, name) = choose_map(map, survey.family)?;
    survey.mark(&map);
    Ok((survey, map, name))
}

impl OpenedFlight {
    /// Opens `path`; `map` is the name of a shipped map or a TOML file, else the family is recognised.
    ///
    /// # Errors
    /// [`OpenError`] if it cannot be read, or holds no pose.
    pub fn open(path: &Path, map: Option<&str>) -> Result<Self, OpenError> {
        let (survey, map, map_name) = survey(path, map)?;
        if survey.has(TICK_TOPIC) {
            let signals = Signals { notes: vec![AS_RECORDED.to_owned()], ..Signals::default() };
            let map_name = "twin".to_owned();
            let recorded = replayed(path)?;
            return Ok(Self { path: path.to_owned(), survey, map, map_name, signals, recorded });
        }
        let gathered = gather(path, &map)
            .map_err(|why| OpenError::Container { path: path.to_owned(), why })?;
        let signals = signals(&gathered);
        let recorded = on_ticks(&signals, &map.vehicle).map_err(|why| OpenError::Mirror {
            path: path.to_owned(),
            why,
            topics: survey.topics(SHOWN_TOPICS),
        })?;
        Ok(Self { path: path.to_owned(), survey, map, map_name, signals, recorded })
    }

    /// Recorded by this program.
    pub fn is_own(&self) -> bool {
        self.survey.has(TICK_TOPIC)
    }

    /// File name without folder.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Where the force comes from, in a sentence.
    pub fn force_sentence(&self) -> String {
        match &self.recorded.effort {
            Effort::Wrench { fit: None } => "force from the wrench in the log".to_owned(),
            Effort::Wrench { fit: Some(fit) } => format!(
                "force from the wrench in the log; the mass that fits is {:.3} kg, lag {:.2} s, R2 {:.3}",
                1.0 / fit.gain,
                fit.lag_s,
                fit.r2
            ),
            Effort::Fitted { input, fit } => format!("force from {input:?}: {}", fit.sentence()),
            Effort::Recorded => "force as the simulated vehicle measured it".to_owned(),
            Effort::Unknown { why } => format!("no force is known: {why}"),
        }
    }

    /// The mass is neither given nor found.
    pub fn per_kilogram(&self) -> bool {
        self.recorded.per_kilogram(&self.map.vehicle)
    }
}
