//! What the residual consists of, and whether a long window foresees it better.

pub mod bands;
pub mod variant;
mod windows;
mod ridge;
pub mod foresight;
pub mod measured;

pub use measured::{Measured, Plan, measure};
pub use variant::Variant;
