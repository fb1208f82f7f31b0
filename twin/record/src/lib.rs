//! Recordings of this program: the recorder, the reader of its files, and the scene that viewers draw.
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
pub mod pieces;
#[cfg(feature = "files")]
pub mod recording;
#[cfg(feature = "files")]
pub mod views;
#[cfg(feature = "files")]
mod track;
#[cfg(feature = "files")]
pub mod recorder;
pub mod fixture;

#[cfg(feature = "files")]
pub use recorder::{Recorder, Written};
#[cfg(feature = "files")]
pub use recording::{Recording, RecordingError, read_recording, read_ticks};
pub use recording_info::{MIRRORED, RecordingEnd, RecordingInfo};
