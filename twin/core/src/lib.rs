//! The loop of the twin: it measures, predicts, adapts and commands in every control period; and the tasks that it flies.
//!
//! Everything here is pure: no files, no clock, no threads, seeded randomness only, and the same numbers on every platform. Units
//! are SI and radians. [`notation`] defines frames and symbols. Modules stand in reading order. After [`notation`] and [`tick`],
//! read [`flight`]: one tick of the loop from top to bottom.

pub mod elementary;
pub mod normal;
pub mod notation;
pub mod quantity;
pub mod force_budget;
pub mod foreseen;
pub mod tick;
pub mod source;
pub mod filter;
pub mod tuning;
pub mod control;
pub mod residual;
pub mod task;
pub mod flight;
pub mod fixture;
