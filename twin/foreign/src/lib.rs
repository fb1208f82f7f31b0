//! Flights to files and from outside: the recorder, reading its files back, and reading flights that others recorded.
//!
//! The only place that knows the MCAP container. A foreign flight goes `container` (records) → `survey` (what is there) →
//! `topics` (what it means) → `gather` (numbers) → `signals` (one clock, ENU and FLU) → `recorded` (ticks of the loop) → `film`
//! (what the loop reads). A long one is judged by `stretches` and goes the same way part by part, through an `index` of its file.

mod idl;
pub mod schema;
mod derivation;
pub mod value;
pub mod topics;
pub mod series;
mod grid;
pub mod frames;
pub mod cdr;
pub mod protobuf;
mod findings;
mod ulog;
pub mod container;
pub mod gather;
pub mod clock;
mod attitude;
pub mod signals;
mod thrust_fit;
mod torque_blocks;
mod torque_fit;
mod torque_gains;
pub mod effort;
mod inertial;
mod torque;
pub mod recorded;
mod replayed;
mod stand_in;
mod table;
mod scan;
mod index;
pub mod survey;
mod kept;
pub mod film;
mod footage;
pub mod stretches;
mod own_footage;
pub mod opened;
pub mod live;
pub mod shadow;
mod shadow_score;
pub mod divergence;
mod divergence_report;

pub use derivation::Derivation;
pub use divergence::{Flyer, Miss, Shot, Twin};
pub use divergence_report::{Light, Report as DivergenceReport};
pub use effort::Effort;
pub use film::RecordedSource;
pub use live::Live;
pub use opened::{OpenError, OpenedFlight};
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
