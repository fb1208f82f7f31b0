//! Reads a recording back, also one that was cut off in the middle of a write.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use mcap::records::Record;

use crate::lossless;
use crate::output::OutputError;
use crate::pieces::{self, CHUNK, DATA_END, HEAD_BYTES, Next};
use crate::recording_info::MIRRORED;
use twin_core::tick::Tick;
use twin_input::budget::{ATTACHED_BYTES, TICKS};
use twin_input::interruption::{self, Interrupted};
use twin_input::{Excess, Inflation, InputError};

/// Topic of the whole tick.
pub const TICK_TOPIC: &str = "/twin/tick";

/// Topic of the measurement alone.
pub const MEASUREMENT_TOPIC: &str = "/twin/measurement";

/// Name of the metadata record that is written at the start.
pub const METADATA_START: &str = "twin";

/// Name of the metadata record that is written when the flight ends; a run that was killed has none.
pub const METADATA_END: &str = "twin.end";

/// Most topics that an error lists.
const SHOWN_TOPICS: usize = 12;

/// Errors of writing and reading a recording.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be created.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The first bytes of the file cannot be written.
    #[error("{path}: cannot begin the recording: {why}; choose another file with --record or free some space", path = path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The message of the operating system.
        why: String,
    },
    /// The file cannot be written any more.
    #[error("{path}: the recording failed: {why}; {ticks} ticks ({bytes} bytes) are in the file, and `twin recover` finishes it; free some space or record to another place", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Ticks that are safe in the file.
        ticks: u64,
        /// Bytes of the file.
        bytes: u64,
        /// The message of the operating system.
        why: String,
    },
    /// A signal asked the program to end.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// The file cannot be read.
    #[error("{path}: cannot read the recording: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: InputError,
    },
    /// The file holds more than is read.
    #[error("{path}: {excess}", path = path.display())]
    TooMuch {
        /// The file.
        path: PathBuf,
        /// What it holds, and what is allowed.
        excess: Excess,
    },
    /// The file is not an MCAP file.
    #[error("{path}: not an MCAP file: it starts with {found:?}, expected the bytes {expected:?}; check the path, or convert it with the `mcap` tool", path = path.display(), expected = mcap::MAGIC.escape_ascii().to_string())]
    NotMcap {
        /// The file.
        path: PathBuf,
        /// Its first bytes.
        found: String,
    },
    /// The file is an MCAP file without ticks of this program.
    #[error("{path}: no tick on {TICK_TOPIC}; topics found: {found}; only recordings of this program can be replayed exactly", path = path.display())]
    NoTicks {
        /// The file.
        path: PathBuf,
        /// The topics it has.
        found: String,
    },
    /// A tick has a form that this version does not know.
    #[error("{path}: message {number} on {TICK_TOPIC} is not a tick of this version: {why}; read it with the version named in its metadata", path = path.display())]
    BadTick {
        /// The file.
        path: PathBuf,
        /// Number of the message on the topic, from 0.
        number: usize,
        /// The reason.
        why: String,
    },
}

impl RecordingError {
    pub(super) fn create(path: &Path, why: impl std::fmt::Display) -> Self {
        Self::Create { path: path.to_owned(), why: why.to_string() }
    }
}

/// The content of a recording.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// The ticks, in the order in which they were flown.
    pub ticks: Vec<Tick>,
    /// Both metadata records in one map (`scenario`, `seed`, `gains`, `state_hash` …).
    pub metadata: BTreeMap<String, String>,
    /// Attached files by name (`vehicle.urdf`, `scenario.toml`).
    pub attachments: BTreeMap<String, Vec<u8>>,
    /// For a cut-off or damaged file: how much was read, and why the rest is missing.
    pub warning: Option<String>,
}

impl Recording {
    /// Whether the recording is that of a mirrored flight, in which a number that is not finite is unknown.
    pub fn is_mirrored(&self) -> bool {
        self.metadata.contains_key(MIRRORED)
    }
}

/// Reads the ticks of a recording; a cut-off file is read to its last whole chunk, with a warning in the log.
///
/// # Errors
/// [`RecordingError`] if the file cannot be read, is no MCAP, holds no tick or a tick of an unknown form.
pub fn read_ticks(path: &Path) -> Result<Vec<Tick>, RecordingError> {
    Ok(read_recording(path)?.ticks)
}

/// Reads a whole recording; a cut-off or damaged file is read to its last whole chunk and says so in
/// [`Recording::warning`].
///
/// # Errors
/// [`RecordingError`] if the file cannot be read, is no MCAP, holds no tick or a tick of an unknown form.
pub fn read_recording(path: &Path) -> Result<Recording, RecordingError> {
    let unreadable = |source| RecordingError::Read { path: path.to_owned(), source };
    let mut input = twin_input::Reader::open(path).map_err(unreadable)?;
    let mut magic = Vec::new();
    let begun = pieces::fill(&mut input, mcap::MAGIC.len() as u64, &mut magic);
    begun.map_err(|error| unreadable(error.into()))?;
    if magic != mcap::MAGIC {
        let found = magic.escape_ascii().to_string();
        return Err(RecordingError::NotMcap { path: path.to_owned(), found });
    }
    let mut reader = Reader {
        path,
        topics: BTreeMap::new(),
        recording: Recording::default(),
        attached_bytes: 0,
        inflation: Inflation::default(),
    };
    if let Err(stop) = reader.read(&mut input) {
        let why = match stop {
            Stop::Error(error) => return Err(error),
            Stop::Damage(why) => why,
        };
        let ticks = reader.recording.ticks.len();
        let warning = format!(
            "{}: cut off or damaged after {ticks} ticks ({why}); the rest is lost",
            path.display()
        );
        tracing::warn!("{warning}");
        reader.recording.warning = Some(warning);
    }
    if reader.recording.ticks.is_empty() {
        return Err(reader.no_ticks());
    }
    Ok(reader.recording)
}

enum Stop {
    Error(RecordingError),
    Damage(String),
}

struct Reader<'a> {
    path: &'a Path,
    topics: BTreeMap<u16, String>,
    recording: Recording,
    /// Bytes of attachments and metadata so far.
    attached_bytes: u64,
    inflation: Inflation,
}

impl Reader<'_> {
    fn read(&mut self, input: &mut impl Read) -> Result<(), Stop> {
        let (mut record, mut offset) = (Vec::new(), mcap::MAGIC.len() as u64);
        loop {
            interruption::check().map_err(|signal| Stop::Error(signal.into()))?;
            let next = pieces::next(input, &mut record).map_err(|error| {
                let (path, source) = (self.path.to_owned(), error.into());
                Stop::Error(RecordingError::Read { path, source })
            })?;
            if let Some(why) = next.damage(offset) {
                return Err(Stop::Damage(why));
            }
            if next == Next::End {
                return Err(Stop::Damage("the end is missing".to_owned()));
            }
            match record.first() {
                // The records after the end of the data index what was read already.
                Some(&DATA_END) => return Ok(()),
                Some(&CHUNK) => self.chunk(&record)?,
                Some(&opcode) => {
                    let parsed = mcap::parse_record(opcode, &record[HEAD_BYTES..]);
                    self.record(parsed.map_err(|error| Stop::Damage(error.to_string()))?)?;
                }
                None => {}
            }
            offset += record.len() as u64;
        }
    }

    /// Reads a chunk. Its checksum is checked before its first record is seen, so damage never yields a wrong tick.
    fn chunk(&mut self, chunk: &[u8]) -> Result<(), Stop> {
        let mut inflation = self.inflation;
        let mut stop = None;
        let end = pieces::unpack(chunk, true, &mut inflation, &mut |record| {
            if stop.is_none() {
                stop = self.record(record).err();
            }
        });
        self.inflation = inflation;
        match (stop, end) {
            (Some(stop), _) => Err(stop),
            (None, end) => end.map_err(|error| Stop::Damage(error.to_string())),
        }
    }

    fn too_much(&self, excess: Excess) -> Stop {
        Stop::Error(RecordingError::TooMuch { path: self.path.to_owned(), excess })
    }

    /// Counts bytes that are kept beside the ticks.
    fn attach(&mut self, bytes: usize) -> Result<(), Stop> {
        self.attached_bytes = self.attached_bytes.saturating_add(bytes as u64);
        ATTACHED_BYTES.check(self.attached_bytes).map_err(|excess| self.too_much(excess))
    }

    fn record(&mut self, record: Record<'_>) -> Result<(), Stop> {
        match record {
            Record::Channel(channel) => {
                self.topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } if self.is_tick(header.channel_id) => {
                let number = self.recording.ticks.len();
                TICKS.check_count(number + 1).map_err(|excess| self.too_much(excess))?;
                let tick = lossless::from_json(&data).map_err(|error| {
                    Stop::Error(RecordingError::BadTick {
                        path: self.path.to_owned(),
                        number,
                        why: error.to_string(),
                    })
                })?;
                self.recording.ticks.push(tick);
            }
            Record::Metadata(record)
                if record.name == METADATA_START || record.name == METADATA_END =>
            {
                let bytes = |(key, value): (&String, &String)| key.len() + value.len();
                self.attach(record.metadata.iter().map(bytes).sum())?;
                self.recording.metadata.extend(record.metadata);
            }
            Record::Attachment { header, data, .. } => {
                self.attach(data.len())?;
                self.recording.attachments.insert(header.name, data.into_owned());
            }
            _ => {}
        }
        Ok(())
    }

    fn is_tick(&self, channel: u16) -> bool {
        self.topics.get(&channel).is_some_and(|topic| topic == TICK_TOPIC)
    }

    fn no_ticks(&self) -> RecordingError {
        let mut found: Vec<&str> =
            self.topics.values().map(String::as_str).take(SHOWN_TOPICS).collect();
        if found.is_empty() {
            found.push("none");
        }
        RecordingError::NoTicks { path: self.path.to_owned(), found: found.join(", ") }
    }
}

#[cfg(test)]
#[path = "recording_tests.rs"]
mod tests;
