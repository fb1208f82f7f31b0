//! Recordings of this program: the recorder, the reader of its files, and the scene that viewers draw.
//! Also the opener of every file that the program writes.
//!
//! A recording is an MCAP file. Other programs can read it, because it uses Foxglove's schemas. The topics `/twin/measurement` and
//! `/twin/tick` also hold every bit of the loop, so that a replay is exact.
//!
//! Without the feature `files` only the scene and the metadata remain; they compile for `wasm32-unknown-unknown`.

pub mod program;
pub mod scene;
mod recording_info;
pub mod lossless;
#[cfg(feature = "files")]
pub mod output;
#[cfg(feature = "files")]
pub mod pieces;
#[cfg(feature = "files")]
pub mod recording;
#[cfg(feature = "files")]
pub mod views;
mod recording_status;
#[cfg(feature = "files")]
mod progress;
#[cfg(feature = "files")]
mod watched_file;
#[cfg(feature = "files")]
mod space;
#[cfg(feature = "files")]
mod track;
#[cfg(feature = "files")]
pub mod recorder;
#[cfg(feature = "files")]
pub mod recover;
pub mod fixture;

#[cfg(feature = "files")]
pub use output::{OutputError, Outputs, RecordingFile};
#[cfg(feature = "files")]
pub use recorder::{Recorder, Written};
#[cfg(feature = "files")]
pub use recording::{Recording, RecordingError, read_recording, read_ticks};
pub use recording_info::{MIRRORED, PER_KILOGRAM, RecordingEnd, RecordingInfo};
pub use recording_status::{RecordingState, RecordingStatus};
