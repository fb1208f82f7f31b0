//! How a recording stands while it is written: what is safe in the file, what is lost, and why it failed.

use std::path::PathBuf;

use serde::Serialize;
use ts_rs::TS;

/// Whether a recording goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum RecordingState {
    /// Ticks are written.
    Recording,
    /// The file is finished.
    Finished,
    /// The file cannot be written any more; the flight goes on.
    Failed,
}

/// How a recording stands.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, TS)]
pub struct RecordingStatus {
    /// Path of the file.
    #[ts(type = "string")]
    pub file: PathBuf,
    /// Whether it goes on.
    pub state: RecordingState,
    /// Bytes written.
    pub bytes: u64,
    /// Ticks that are safe in the file.
    pub ticks: u64,
    /// Ticks that are not, and never will be in the file.
    pub dropped_ticks: u64,
    /// Why it failed, and what to do; one sentence.
    pub error: Option<String>,
    /// Why it may fail before the flight ends; one sentence.
    pub warning: Option<String>,
}
