//! A digital twin of an aerial manipulator: URDF, Rapier contacts, the paper's loop, a live console.
//!
//! Units are SI and radians everywhere; frames and symbols are in [`notation`]. Read `flight.rs` first.

pub mod notation;
pub mod model;
pub mod tick;
pub mod source;
pub mod tuning;
pub mod residual;
pub mod control;
pub mod scenario;
