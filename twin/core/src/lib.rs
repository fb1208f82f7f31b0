//! The loop of the twin: what is measured, predicted, adapted and commanded in one control period, and what is flown.
//!
//! Everything here is pure: no files, no clock, no threads, seeded randomness only, and the same numbers on every platform.
//! Units are SI and radians; frames and symbols are in [`notation`]. Modules stand in reading order: after [`notation`] and
//! [`tick`], read [`flight`]: it is one tick of the loop, top to bottom.

pub mod elementary;
pub mod normal;
pub mod notation;
pub mod quantity;
pub mod tick;
pub mod source;
pub mod filter;
pub mod tuning;
pub mod control;
pub mod residual;
pub mod task;
pub mod flight;
pub mod fixture;
