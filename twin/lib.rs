//! A digital twin of an aerial manipulator: URDF, Rapier contacts, the paper's loop, a live console.
//!
//! Units are SI and radians everywhere; frames and symbols are in [`notation`]. Modules stand in reading order; after
//! [`notation`] and [`tick`], read [`flight`]: it is one tick of the loop, top to bottom.

pub mod elementary;
pub mod normal;
pub mod notation;
pub mod tick;
pub mod source;
pub mod filter;
pub mod tuning;
pub mod control;
pub mod residual;
pub mod task;
pub mod flight;
pub mod model;
pub mod plant;
pub mod mirror;
pub mod scenario;
pub mod suite;
pub mod learn;
pub mod evaluate;
pub mod server;
pub mod replay;

#[cfg(test)]
pub(crate) mod fixture;
