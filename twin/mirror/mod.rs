//! Flights to files and from outside: the recorder, reading its files back, and reading flights that others recorded.
//!
//! The only place that knows the MCAP container. A foreign flight goes `container` (records) → `survey` (what is there) →
//! `topics` (what it means) → `gather` (numbers) → `signals` (one clock, ENU and FLU) → `recorded` (ticks of the loop) → `film`
//! (what the loop reads). A long one is judged by `stretches` and goes the same way part by part, through an `index` of its file.

mod attitude;
pub mod cdr;
pub mod clock;
pub mod container;
mod derivation;
pub mod effort;
pub mod film;
mod findings;
#[cfg(test)]
pub(crate) mod fixture;
mod footage;
pub mod frames;
pub mod gather;
mod grid;
mod idl;
mod index;
mod inertial;
mod kept;
pub mod live;
mod lossless;
pub mod opened;
mod own_footage;
pub mod protobuf;
pub mod recorded;
pub mod recorder;
pub mod recording;
mod recording_info;
mod replayed;
mod scan;
pub mod scene;
pub mod schema;
pub mod series;
pub mod signals;
mod stand_in;
pub mod stretches;
pub mod survey;
mod table;
mod thrust_fit;
pub mod topics;
mod torque;
mod torque_blocks;
mod torque_fit;
mod torque_gains;
mod track;
mod ulog;
pub mod value;
pub(crate) mod views;

pub use derivation::Derivation;
pub use effort::Effort;
pub use film::RecordedSource;
pub use live::Live;
pub use opened::{OpenError, OpenedFlight};
pub use recorded::{MirrorError, RecordedFlight};
pub use recorder::{Recorder, Written};
pub use recording::{Recording, RecordingError, read_recording, read_ticks};
pub use recording_info::{RecordingEnd, RecordingInfo};
pub use replayed::recorded_nominal_inertia;
pub use stand_in::stand_in;
pub use survey::Survey;
pub use table::Input;
pub use thrust_fit::ThrustFit;
pub use topics::{Map, MapError};
pub use torque_fit::{TorqueAxis, TorqueFit};
pub use torque_gains::Torque;
