//! A digital twin of an aerial manipulator: URDF, Rapier contacts, the paper's loop, a live console.
//!
//! Units are SI and radians everywhere; frames and symbols are in [`notation`]. Modules stand in reading order; after
//! [`notation`] and [`tick`], read [`flight`]: it is one tick of the loop, top to bottom.

pub mod notation;
pub mod tick;
pub mod source;
pub mod flight;
pub mod tuning;
pub mod filter;
pub mod model;
pub mod plant;
pub mod residual;
pub mod control;
pub mod task;
pub mod mirror;
pub mod scenario;
pub mod server;
