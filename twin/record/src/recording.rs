//! Reads a recording back, also one that was cut off in the middle of a write.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::interruption::{self, Interrupted};
use crate::lossless;
use crate::output::OutputError;
use crate::recording_info::MIRRORED;
use twin_core::tick::Tick;

/// Topic of the whole tick.
pub const TICK_TOPIC: &str = "/twin/tick";

/// Topic of the measurement alone.
pub const MEASUREMENT_TOPIC: &str = "/twin/measurement";

/// Name of the metadata record that is written at the start.
pub const METADATA_START: &str = "twin";

/// Name of the metadata record that is written when the flight ends; a run that was killed has none.
pub const METADATA_END: &str = "twin.end";

/// Longest record and chunk that is read: a hundred times as long as the recorder's own.
const LONGEST_RECORD_BYTES: usize = 256 << 20;

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
        /// The error of the operating system.
        source: std::io::Error,
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
    let bytes = std::fs::read(path)
        .map_err(|source| RecordingError::Read { path: path.to_owned(), source })?;
    if !bytes.starts_with(mcap::MAGIC) {
        let found = bytes[..bytes.len().min(8)].escape_ascii().to_string();
        return Err(RecordingError::NotMcap { path: path.to_owned(), found });
    }
    let mut reader = Reader { path, topics: BTreeMap::new(), recording: Recording::default() };
    if let Err(stop) = reader.read(&bytes) {
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

impl From<mcap::McapError> for Stop {
    fn from(error: mcap::McapError) -> Self {
        Self::Damage(error.to_string())
    }
}

struct Reader<'a> {
    path: &'a Path,
    topics: BTreeMap<u16, String>,
    recording: Recording,
}

impl Reader<'_> {
    fn read(&mut self, mut bytes: &[u8]) -> Result<(), Stop> {
        // A chunk's checksum is checked before its first record is seen, so damage never yields a wrong tick; the limit
        // keeps a damaged length from asking for all memory.
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LONGEST_RECORD_BYTES);
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            interruption::check().map_err(|signal| Stop::Error(signal.into()))?;
            match event? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let length = wanted.min(bytes.len());
                    let (part, rest) = bytes.split_at(length);
                    reader.insert(length).copy_from_slice(part);
                    reader.notify_read(length);
                    bytes = rest;
                }
                LinearReadEvent::Record { opcode, data } => match mcap::parse_record(opcode, data)?
                {
                    // The records after the end of the data index what was read already.
                    Record::DataEnd(_) => return Ok(()),
                    record => self.record(record)?,
                },
            }
        }
        Err(Stop::Damage("the end is missing".to_owned()))
    }

    fn record(&mut self, record: Record<'_>) -> Result<(), Stop> {
        match record {
            Record::Channel(channel) => {
                self.topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } if self.is_tick(header.channel_id) => {
                let number = self.recording.ticks.len();
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
                self.recording.metadata.extend(record.metadata);
            }
            Record::Attachment { header, data, .. } => {
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
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::fixture;
    use crate::{Recorder, RecordingEnd, RecordingInfo};

    /// More ticks than two chunks hold, so that a cut leaves at least one whole chunk.
    const TICKS: u64 = 250;

    fn file(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("twin-recording-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder.join(name)
    }

    fn info() -> RecordingInfo {
        RecordingInfo {
            scenario: "unit".to_owned(),
            scenario_toml: "seed = 7\n".to_owned(),
            seed: 7,
            gains_json: "{}".to_owned(),
            limits_json: "{}".to_owned(),
            predictor_json: "{}".to_owned(),
            kernel: "scalar".to_owned(),
            urdf: "<robot name=\"r\"/>".to_owned(),
            scene: fixture::scene(),
            joint_names: vec!["joint1".to_owned(), "joint2".to_owned()],
            mirrored: false,
        }
    }

    fn record(path: &Path, ticks: &[Tick]) {
        let mut recorder = Recorder::create(path, &info()).unwrap();
        for tick in ticks {
            recorder.record(Arc::new(tick.clone())).unwrap();
        }
        let end = RecordingEnd { state_hash: 0xabc, verdict: "placed".to_owned() };
        let written = recorder.finish(end).unwrap();
        assert_eq!((written.ticks, written.dropped), (ticks.len() as u64, 0));
    }

    #[test]
    fn ticks_read_are_the_ticks_written_and_metadata_and_files_come_along() {
        let ticks: Vec<Tick> = (0..TICKS).map(fixture::tick).collect();
        let path = file("whole.mcap");
        record(&path, &ticks);
        let read = read_recording(&path).unwrap();
        // Equality of f64 compares all bits except for the sign of zero; the JSON text of both sides compares that, too.
        assert_eq!(read.ticks, ticks);
        assert_eq!(
            serde_json::to_string(&read.ticks).unwrap(),
            serde_json::to_string(&ticks).unwrap()
        );
        assert_eq!(read.warning, None);
        assert_eq!(read.metadata["seed"], "7");
        assert_eq!(read.metadata["state_hash"], "0000000000000abc");
        assert_eq!(read.metadata["ticks"], TICKS.to_string());
        assert_eq!(read.attachments["scenario.toml"], b"seed = 7\n");
        assert_eq!(read.attachments["vehicle.urdf"], b"<robot name=\"r\"/>");
    }

    #[test]
    fn a_cut_file_is_read_to_its_last_whole_chunk_and_says_so() {
        let ticks: Vec<Tick> = (0..TICKS).map(fixture::tick).collect();
        let path = file("cut.mcap");
        record(&path, &ticks);
        let bytes = std::fs::read(&path).unwrap();
        let data_end = bytes.len() - 1;
        let mut most = 0;
        for part in 1..=20 {
            std::fs::write(&path, &bytes[..data_end * part / 20]).unwrap();
            match read_recording(&path) {
                Ok(read) => {
                    assert_eq!(read.ticks, ticks[..read.ticks.len()]);
                    assert!(read.ticks.len() as u64 == TICKS || read.warning.is_some());
                    most = most.max(read.ticks.len());
                }
                Err(error) => assert!(matches!(error, RecordingError::NoTicks { .. }), "{error}"),
            }
        }
        assert!(most >= 200, "two whole chunks of 100 ticks were expected, {most} ticks read");
    }

    #[test]
    fn a_damaged_byte_never_yields_a_wrong_tick() {
        let ticks: Vec<Tick> = (0..TICKS).map(fixture::tick).collect();
        let path = file("damaged.mcap");
        record(&path, &ticks);
        let bytes = std::fs::read(&path).unwrap();
        for part in 1..60 {
            let mut damaged = bytes.clone();
            damaged[bytes.len() * part / 60] ^= 0x10;
            std::fs::write(&path, &damaged).unwrap();
            if let Ok(read) = read_recording(&path) {
                assert_eq!(
                    read.ticks,
                    ticks[..read.ticks.len()],
                    "byte {}",
                    bytes.len() * part / 60
                );
            }
        }
    }

    #[test]
    fn a_text_file_an_empty_file_and_no_file_are_clear_errors() {
        let path = file("text.mcap");
        std::fs::write(&path, "hello, this is text").unwrap();
        let text = read_ticks(&path).unwrap_err().to_string();
        assert!(text.contains("not an MCAP file") && text.contains("hello, t"), "{text}");
        std::fs::write(&path, "").unwrap();
        assert!(matches!(read_ticks(&path), Err(RecordingError::NotMcap { .. })));
        assert!(matches!(read_ticks(&file("absent.mcap")), Err(RecordingError::Read { .. })));
    }

    #[test]
    fn a_recorder_that_is_dropped_leaves_a_whole_file_without_an_end() {
        let path = file("dropped.mcap");
        let mut recorder = Recorder::create(&path, &info()).unwrap();
        recorder.record(Arc::new(fixture::tick(0))).unwrap();
        drop(recorder);
        let read = read_recording(&path).unwrap();
        assert_eq!((read.ticks.len(), read.warning), (1, None));
        assert!(!read.metadata.contains_key("state_hash"));
    }

    #[test]
    fn what_is_flushed_can_be_read_while_the_recorder_still_writes() {
        let path = file("live.mcap");
        let mut recorder = Recorder::create(&path, &info()).unwrap();
        for index in 0..150 {
            recorder.record(Arc::new(fixture::tick(index))).unwrap();
        }
        // A chunk is closed after half a second; the rest is for a loaded machine.
        let readable = (0..100).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            read_ticks(&path).is_ok_and(|ticks| ticks.len() == 150)
        });
        assert!(readable, "the file was not readable within 5 s");
        recorder.finish(RecordingEnd::default()).unwrap();
    }

    #[test]
    fn a_folder_that_does_not_exist_is_an_error_that_names_the_file() {
        let error = Recorder::create(&file("no-such-folder").join("x.mcap"), &info())
            .unwrap_err()
            .to_string();
        assert!(error.contains("x.mcap") && error.contains("--record"), "{error}");
    }
}
