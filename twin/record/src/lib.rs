//! Recordings of this program: the recorder, the reader of its files, and the scene that viewers draw.
//!
//! A recording is an MCAP file. Other programs can read it, because it uses Foxglove's schemas. The topics `/twin/measurement` and
//! `/twin/tick` also hold every bit of the loop, so that a replay is exact.

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
