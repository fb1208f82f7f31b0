//! What was salvaged from a recording, what is lost, and why a recording cannot be salvaged.

use std::path::PathBuf;

use twin_input::interruption::Interrupted;

/// Most places of damage that are described one by one.
const MOST_LOSSES: usize = 20;

/// A part of the file that could not be used.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Loss {
    /// Offset of its first byte.
    pub at_byte: u64,
    /// Its bytes.
    pub bytes: u64,
    /// What is lost there and why, in a sentence.
    pub what: String,
}

/// What was found in a recording and what is lost.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Salvaged {
    /// Bytes of the recording.
    pub bytes: u64,
    /// Whether the recording has its summary and its end, as a finished one.
    pub finished: bool,
    /// Messages that were written to the new file.
    pub messages: u64,
    /// Channels of the new file.
    pub channels: u64,
    /// Attachments of the new file.
    pub attachments: u64,
    /// Metadata records of the new file, without the one about the salvage.
    pub metadata: u64,
    /// Chunks whose messages were read.
    pub chunks: u64,
    /// Of the messages, those whose checksum is missing or wrong: they stood in an unfinished chunk, or were asked for.
    pub unverified_messages: u64,
    /// Log times of the first and the last message, ns.
    pub times_ns: Option<(u64, u64)>,
    /// Messages that are known to be lost: by the statistics of the recording, or by the index behind a damaged chunk.
    pub lost_messages: u64,
    /// Whether more messages than `lost_messages` may be lost.
    pub lost_more: bool,
    /// Log time that damaged chunks covered, s.
    pub lost_s: f64,
    /// Places of damage; only the first of them are described in `losses`.
    pub damaged_places: u64,
    /// Damage, in the order of the file.
    pub losses: Vec<Loss>,
}

impl Salvaged {
    /// Log time between the first and the last message, s.
    pub fn duration_s(&self) -> f64 {
        self.times_ns.map_or(0.0, |(first, last)| last.saturating_sub(first) as f64 / 1e9)
    }

    /// Notes a place of damage.
    pub(super) fn lose(&mut self, at_byte: u64, bytes: u64, what: impl Into<String>) {
        self.damaged_places += 1;
        if self.losses.len() < MOST_LOSSES {
            self.losses.push(Loss { at_byte, bytes, what: what.into() });
        }
    }

    /// Notes a message that was written.
    pub(super) fn keep(&mut self, log_time: u64, verified: bool) {
        self.messages += 1;
        self.unverified_messages += u64::from(!verified);
        let (first, last) = self.times_ns.unwrap_or((log_time, log_time));
        self.times_ns = Some((first.min(log_time), last.max(log_time)));
    }
}

/// Why a salvage stops before the end of the file.
#[derive(Debug)]
pub(super) enum Trouble {
    Read(std::io::Error),
    Write(mcap::McapError),
    Signal(Interrupted),
}

impl From<std::io::Error> for Trouble {
    fn from(error: std::io::Error) -> Self {
        Self::Read(error)
    }
}

impl From<mcap::McapError> for Trouble {
    fn from(error: mcap::McapError) -> Self {
        Self::Write(error)
    }
}

impl From<Interrupted> for Trouble {
    fn from(signal: Interrupted) -> Self {
        Self::Signal(signal)
    }
}

/// Why a recording cannot be salvaged.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// The recording cannot be read.
    #[error("{path}: cannot read the recording: {why}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        why: std::io::Error,
    },
    /// The file has nothing that can be salvaged.
    #[error("{path}: no record of an MCAP file can be read in its {bytes} bytes; nothing was written", path = path.display())]
    Nothing {
        /// The file.
        path: PathBuf,
        /// Its bytes.
        bytes: u64,
    },
    /// The new file cannot be written.
    #[error("the salvaged recording cannot be written: {0}")]
    Write(String),
    /// A signal asked the program to end.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}
