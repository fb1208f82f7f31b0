//! What the residual consists of, and whether a long window foresees it better.

pub mod bands;
pub mod variant;
mod windows;
mod ridge;
pub mod foresight;
pub mod measured;
pub mod foreseen;
mod conclusion;
pub mod table;
mod sheets;

pub use measured::{Measured, Plan, measure};
pub use table::ResidualTable;
pub use variant::Variant;
