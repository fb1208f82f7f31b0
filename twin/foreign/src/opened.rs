//! An opened recording: its contents, their meaning, and the flight on ticks.

use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::clock::mend;
use super::container::ContainerError;
use super::effort::Effort;
use super::gather::gather_from;
use super::index::Index;
use super::own_parts::OwnParts;
use super::playback::PartReader;
use super::recorded::{LONGEST_S, MirrorError, RecordedFlight, on_ticks};
use super::replayed::replayed;
use super::signals::{Signals, signals};
use super::stretches::{LONG_S, judge};
use super::survey::Survey;
use super::table::Input;
use super::topics::{Map, MapError, SHIPPED};
use super::vehicles::{self, VehicleFound};
use twin_input::budget::SETTINGS_BYTES;
use twin_input::{Asking, InputError, Reader, file};
use twin_record::recording::{RecordingError, TICK_TOPIC};

/// Largest number of topics that an error lists.
const SHOWN_TOPICS: usize = 30;

/// Number of bytes between two progress reports.
const TOLD_BYTES: u64 = 4 << 20;

/// The note on a recording of this program.
const AS_RECORDED: &str =
    "recorded by this program: measurements are taken as they are, nothing is resampled";

/// A recording and its flight.
#[derive(Clone, Debug)]
pub struct OpenedFlight {
    /// Path of the file.
    pub path: PathBuf,
    /// Contents of the file.
    pub survey: Survey,
    /// The map that gives messages their meaning.
    pub map: Map,
    /// Name of the map.
    pub map_name: String,
    /// The sources in use and their samples.
    pub signals: Signals,
    /// The vehicles in the recording, if their topics tell them apart.
    pub vehicles: Vec<VehicleFound>,
    /// The flight; for a long flight only stretches of it.
    pub recorded: RecordedFlight,
    /// The whole of a long flight, which is read while it is played.
    pub long: Option<Arc<dyn PartReader>>,
}

/// Why a recording cannot be mirrored.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file cannot be read.
    #[error("{path}: {why}", path = path.display())]
    Container {
        /// Path of the file.
        path: PathBuf,
        /// The reason.
        why: ContainerError,
    },
    /// The map is neither shipped nor a file.
    #[error("--map {name}: not a shipped map ({shipped}) and not a file that can be read: {why}")]
    MapFile {
        /// The name as given.
        name: String,
        /// Names of the maps that come with the program.
        shipped: String,
        /// The error of the system.
        why: String,
    },
    /// The map cannot be used.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The recording was made by this program and cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording contains no flight.
    #[error("{path}: {why}; topics found: {topics}", path = path.display())]
    Mirror {
        /// Path of the file.
        path: PathBuf,
        /// The reason.
        why: MirrorError,
        /// Topics of the recording.
        topics: String,
    },
}

/// The map called `wanted`, or else the map of the recognised family, over the generic rules; with its name.
///
/// # Errors
/// [`OpenError`] if the map cannot be read or used.
pub fn choose_map(
    wanted: Option<&str>,
    family: Option<&'static str>,
) -> Result<(Map, String), OpenError> {
    let (own, name) = match (wanted, family) {
        (Some(name), _) if Map::shipped(name).is_some() => (Map::shipped(name), name.to_owned()),
        (Some(name), _) => {
            let text = file::read_text(Path::new(name), SETTINGS_BYTES).map_err(|why| {
                let shipped = SHIPPED.map(|(name, _)| name).join(", ");
                OpenError::MapFile { name: name.to_owned(), shipped, why: why.to_string() }
            })?;
            (Some(Map::parse(&text, name)?), name.to_owned())
        }
        (None, Some(name)) => (Map::shipped(name), name.to_owned()),
        (None, None) => (None, "generic".to_owned()),
    };
    Ok((Map::over_generic(own.unwrap_or_default())?, name))
}

/// The contents of `path`, and the map that is asked for or recognised.
///
/// # Errors
/// [`OpenError`] if the file cannot be read, or the map cannot be used.
pub fn survey(path: &Path, map: Option<&str>) -> Result<(Survey, Map, String), OpenError> {
    let mut survey =
        Survey::read(path).map_err(|why| OpenError::Container { path: path.to_owned(), why })?;
    let (map, name) = choose_map(map, survey.family)?;
    survey.mark(&map);
    Ok((survey, map, name))
}

/// A file that is read twice from its start to its end, with progress reports.
struct ProgressReader<'a> {
    file: Reader,
    read: u64,
    told: u64,
    of: u64,
    on: &'a mut dyn FnMut(u64, u64),
}

impl<'a> ProgressReader<'a> {
    fn open(path: &Path, on: &'a mut dyn FnMut(u64, u64)) -> Result<Self, InputError> {
        let file = Reader::open(path)?;
        let of = file.length()?.saturating_mul(2);
        Ok(Self { file, read: 0, told: 0, of, on })
    }

    fn again(&mut self) -> std::io::Result<()> {
        self.read = self.of / 2;
        self.file.rewind()
    }
}

impl Read for ProgressReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.file.read(buffer)?;
        self.read += read as u64;
        if self.read - self.told > TOLD_BYTES {
            self.told = self.read;
            (self.on)(self.read, self.of);
        }
        Ok(read)
    }
}

/// Whether the flight is too long to be read whole. A span beyond [`LONGEST_S`] comes from a damaged time, which only reading mends.
fn is_long(index: &Index) -> bool {
    let span_s = index.span_ns().map(|(first, last)| (last - first) as f64 * 1e-9);
    span_s.is_some_and(|span_s| span_s > LONG_S && span_s <= LONGEST_S)
}

impl OpenedFlight {
    /// Opens `path`. `map` is the name of a shipped map or a TOML file; without it the family is recognised. A long flight in an
    /// MCAP file with chunks is read through its index while it is played.
    ///
    /// # Errors
    /// [`OpenError`] if the file cannot be read, or contains no pose.
    pub fn open(path: &Path, map: Option<&str>) -> Result<Self, OpenError> {
        Self::open_watched(path, map, &mut |_, _| {})
    }

    /// Opens `path` as [`Self::open`] does. Where the file must be read whole, `on` receives from time to time the bytes read and
    /// the bytes in total.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_watched(
        path: &Path,
        map: Option<&str>,
        on: &mut dyn FnMut(u64, u64),
    ) -> Result<Self, OpenError> {
        Self::open_vehicle(path, map, None, on)
    }

    /// Opens `path` as [`Self::open_watched`] does; `vehicle` is the namespace of the vehicle to mirror, if the recording has several.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_vehicle(
        path: &Path,
        map: Option<&str>,
        vehicle: Option<&str>,
        on: &mut dyn FnMut(u64, u64),
    ) -> Result<Self, OpenError> {
        // Errors are dropped here, because the reader of the whole file meets and reports them again.
        let input = file::open(path).ok().map(|file| Box::new(Asking::new(file)) as Box<dyn Input>);
        match input.map_or(Ok(None), |input| Self::read_long(path, map, vehicle, input))? {
            Some(long) => Ok(long),
            None => Self::read_whole(path, map, vehicle, on),
        }
    }

    /// The flight in `input`, called `path`, read through its index; `None` if the flight is short or the file has no index.
    ///
    /// # Errors
    /// [`OpenError`] if the map cannot be used, or the file contains no pose.
    pub fn open_long(
        path: &Path,
        map: Option<&str>,
        input: Box<dyn Input>,
    ) -> Result<Option<Self>, OpenError> {
        Self::read_long(path, map, None, input)
    }

    fn read_long(
        path: &Path,
        map: Option<&str>,
        vehicle: Option<&str>,
        input: Box<dyn Input>,
    ) -> Result<Option<Self>, OpenError> {
        let Some(index) = Index::new(input).ok().flatten().filter(is_long) else { return Ok(None) };
        let mut survey = Survey::of_index(&index);
        let (mut map, map_name) = choose_map(map, survey.family)?;
        map.vehicle.namespace = vehicle.map(str::to_owned).or(map.vehicle.namespace);
        survey.mark(&map);
        let path = path.to_owned();
        if survey.has(TICK_TOPIC) {
            let Some(parts) = OwnParts::new(index) else { return Ok(None) };
            let signals = Signals { notes: vec![AS_RECORDED.to_owned()], ..Signals::default() };
            let recorded = parts.stretches();
            survey.container = parts.findings().clone();
            let (map_name, long) =
                ("twin".to_owned(), Some(Arc::new(parts) as Arc<dyn PartReader>));
            return Ok(Some(Self {
                path,
                survey,
                map,
                map_name,
                signals,
                vehicles: Vec::new(),
                recorded,
                long,
            }));
        }
        let topics = survey.topics(SHOWN_TOPICS);
        match judge(index, &map) {
            Ok((judged, findings)) => {
                survey.container = findings;
                let (signals, recorded, vehicles) =
                    (judged.signals, judged.recorded, judged.vehicles);
                let long = Some(Arc::new(judged.parts) as Arc<dyn PartReader>);
                Ok(Some(Self { path, survey, map, map_name, signals, vehicles, recorded, long }))
            }
            // The pose lasts for a part of the recording only; where it is, only reading tells.
            Err(MirrorError::NoPose) => Ok(None),
            Err(why) => Err(OpenError::Mirror { path, why, topics }),
        }
    }

    /// Opens `path` as [`Self::open`] does, but reads the whole file into memory, however long the flight is.
    ///
    /// # Errors
    /// [`OpenError`] if the file cannot be read, or contains no pose.
    pub fn open_whole(path: &Path, map: Option<&str>) -> Result<Self, OpenError> {
        Self::read_whole(path, map, None, &mut |_, _| {})
    }

    fn read_whole(
        path: &Path,
        map: Option<&str>,
        vehicle: Option<&str>,
        on: &mut dyn FnMut(u64, u64),
    ) -> Result<Self, OpenError> {
        let refused = |why| OpenError::Container { path: path.to_owned(), why };
        let mut file = ProgressReader::open(path, on).map_err(|why| refused(why.into()))?;
        let mut survey = Survey::read_from(&mut file).map_err(refused)?;
        let (mut map, map_name) = choose_map(map, survey.family)?;
        map.vehicle.namespace = vehicle.map(str::to_owned).or(map.vehicle.namespace);
        survey.mark(&map);
        if survey.has(TICK_TOPIC) {
            let signals = Signals { notes: vec![AS_RECORDED.to_owned()], ..Signals::default() };
            let map_name = "twin".to_owned();
            let recorded = replayed(path)?;
            let path = path.to_owned();
            return Ok(Self {
                path,
                survey,
                map,
                map_name,
                signals,
                vehicles: Vec::new(),
                recorded,
                long: None,
            });
        }
        file.again().map_err(|why| refused(why.into()))?;
        let mut gathered = gather_from(&mut file, &map).map_err(refused)?;
        let events = mend(&mut gathered.tracks);
        gathered.notes.extend(events);
        let topics = survey.topics(SHOWN_TOPICS);
        let no_flight = |why| OpenError::Mirror { path: path.to_owned(), why, topics };
        let flown = vehicles::one(gathered, &map.vehicle).and_then(|(gathered, vehicles)| {
            let signals = signals(&gathered);
            let recorded = on_ticks(&signals, &map.vehicle)?;
            Ok((signals, vehicles, recorded))
        });
        let (signals, vehicles, recorded) = flown.map_err(no_flight)?;
        let path = path.to_owned();
        Ok(Self { path, survey, map, map_name, signals, vehicles, recorded, long: None })
    }

    /// True if this program recorded the flight.
    pub fn is_own(&self) -> bool {
        self.survey.has(TICK_TOPIC)
    }

    /// Name of the file without its folder.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// A sentence that names the source of the force.
    pub fn force_sentence(&self) -> String {
        match &self.recorded.effort {
            Effort::Wrench { fit: None } => "force from the wrench in the log".to_owned(),
            Effort::Wrench { fit: Some(fit) } if fit.explains() => format!(
                "force from the wrench in the log; the mass that fits is {:.3} kg, lag {:.2} s, R2 {:.3}, {}",
                1.0 / fit.gain,
                fit.lag_s,
                fit.r2,
                fit.verdict()
            ),
            Effort::Wrench { fit: Some(fit) } => format!(
                "force from the wrench in the log; no mass fits it (R2 {:.3}): {}",
                fit.r2,
                fit.verdict()
            ),
            Effort::Fitted { input, fit, .. } => {
                format!("force from {input:?}: {}", fit.sentence())
            }
            Effort::Recorded => "force as the simulated vehicle measured it".to_owned(),
            Effort::Unknown { why } => format!("no force is known: {why}"),
        }
    }

    /// A sentence that names the source of the torque.
    pub fn torque_sentence(&self) -> String {
        match &self.recorded.effort {
            Effort::Wrench { .. } if self.signals.torque.is_some() => {
                "torque from the wrench in the log".to_owned()
            }
            Effort::Wrench { .. } => {
                "no torque is known: the wrench in the log has none".to_owned()
            }
            Effort::Fitted { torque, .. } => torque.sentence(),
            Effort::Recorded => "torque as the simulated vehicle measured it".to_owned(),
            Effort::Unknown { .. } => "no torque is known, because no force is known".to_owned(),
        }
    }

    /// True if the mass is neither given nor found by a fit; forces are then per kilogram.
    pub fn per_kilogram(&self) -> bool {
        self.recorded.per_kilogram(&self.map.vehicle)
    }
}
