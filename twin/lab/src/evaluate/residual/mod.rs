//! What the residual consists of, and whether a long window foresees it better: `twin evaluate residual`.
//!
//! In: scenarios of training flights. Each is flown with every effect on, with each effect of [`twin_core::source::EFFECTS`] off in turn,
//! and with all of them off. Out: [`ResidualTable`] with the variance by band of frequency, the share of each effect in it, and the errors
//! of forecasts from a short and from a long window.

pub mod bands;
pub mod variant;
mod windows;
pub mod foresight;
pub mod measured;
pub mod foreseen;
mod conclusion;
pub mod table;
mod sheets;
mod drawing;

pub use drawing::pictures;
pub use measured::{Measured, Plan, measure};
pub use table::ResidualTable;
pub use variant::Variant;
