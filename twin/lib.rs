//! A digital twin of an aerial manipulator: URDF, Rapier contacts, the paper's loop, a live console.
//!
//! Units are SI and radians everywhere; frames and symbols are in [`notation`]. Modules stand in reading order; after
//! [`notation`] and [`tick`], read [`flight`]: it is one tick of the loop, top to bottom.

pub mod control;
pub mod elementary;
pub mod evaluate;
pub mod filter;
#[cfg(test)]
pub(crate) mod fixture;
pub mod flight;
pub mod learn;
pub mod mirror;
pub mod model;
pub mod normal;
pub mod notation;
pub mod plant;
pub mod replay;
pub mod residual;
pub mod scenario;
pub mod server;
pub mod source;
pub mod suite;
pub mod task;
pub mod tick;
pub mod tuning;
