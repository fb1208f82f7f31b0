//! What makes `tau`: total functions that cannot fail.

pub mod gains;

pub use gains::{Gains, Preset};
