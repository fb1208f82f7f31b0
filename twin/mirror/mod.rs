//! Flights to files and from outside: the recorder, and reading its files back.
//!
//! The only place that knows the MCAP container.

#[cfg(test)]
pub(crate) mod fixture;
mod lossless;
pub mod recorder;
pub mod recording;
pub mod scene;
mod track;
mod views;

pub use recorder::{Recorder, RecordingEnd, RecordingInfo, Written};
pub use recording::{Recording, RecordingError, read_recording, read_ticks};
