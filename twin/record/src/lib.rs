//! Flights of this program on disk: the recorder, reading its files back, and the scene that viewers draw.
//!
//! A recording is an MCAP file. Foxglove's schemas make it readable for other programs; the topics `/twin/measurement` and
//! `/twin/tick` hold every bit of the loop beside them, so that a replay is exact.

pub mod program;
pub mod scene;
pub mod lossless;
pub mod recording;
mod recording_info;
pub mod views;
mod track;
pub mod recorder;
pub mod fixture;

pub use recorder::{Recorder, Written};
pub use recording::{Recording, RecordingError, read_recording, read_ticks};
pub use recording_info::{RecordingEnd, RecordingInfo};
