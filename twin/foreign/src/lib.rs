//! Flights of other vehicles: reads their files and streams, puts them onto the ticks of the loop, and runs the loop in shadow
//! beside them.
//!
//! A foreign flight passes `container` (records) → `survey` (contents) → `topics` (meaning of the messages) → `gather` (numbers)
//! → `signals` (one clock, ENU and FLU) → `recorded` (ticks of the loop) → `playback` (source of the loop). A long flight is judged
//! by `stretches`, and then passes the same stages part by part, through an `index` of its file.

mod idl;
pub mod schema;
mod derivation;
pub mod value;
mod pattern;
pub mod topics;
pub mod series;
mod grid;
pub mod frames;
pub mod cdr;
pub mod protobuf;
mod message_definitions;
mod findings;
mod ulog;
pub mod container;
mod form;
pub mod gather;
pub mod clock;
mod attitude;
pub mod flags;
mod jumps;
pub mod signals;
mod thrust_fit;
pub mod phases;
mod torque_blocks;
mod torque_fit;
mod torque_gains;
pub mod effort;
mod inertial;
mod torque;
pub mod recorded;
pub mod vehicles;
mod replayed;
mod stand_in;
mod table;
mod scan;
mod index;
pub mod survey;
mod recent_cache;
pub mod playback;
mod foreign_parts;
pub mod stretches;
mod own_parts;
pub mod opened;
pub mod live;
mod forecaster;
mod knowledge;
pub mod shadow;
pub mod shadow_score;
pub mod gate;
pub mod divergence;
mod divergence_report;

pub use derivation::Derivation;
pub use divergence::{Flyer, PredictionError, Twin, TwinFlight};
pub use divergence_report::{Light, Report as DivergenceReport};
pub use effort::Effort;
pub use forecaster::Forecaster;
pub use knowledge::Knowledge;
pub use live::Live;
pub use opened::{OpenError, OpenedFlight};
pub use playback::RecordedSource;
pub use recorded::{MirrorError, RecordedFlight};
pub use replayed::recorded_nominal_inertia;
pub use shadow::{Shadow, ShadowReport, shadow};
pub use stand_in::stand_in;
pub use survey::Survey;
pub use table::Input;
pub use thrust_fit::ThrustFit;
pub use topics::{Map, MapError};
pub use torque_fit::{TorqueAxis, TorqueFit};
pub use torque_gains::Torque;
