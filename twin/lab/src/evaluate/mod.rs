//! The paper's tables, measured on the twin: prediction of the residual, and tracking of flights.
//!
//! In: recordings and scenarios. Out: tables as plain values, pictures, pages. This module prints nothing; `cli` does.

pub mod series;
pub mod score;
pub mod replay;
pub mod fit;
pub mod entrants;
pub mod sheet;
pub mod prediction;
pub mod pictures;
pub mod ablation;
pub mod pickup;
pub mod plant;
pub mod mirrored;
mod bars;
pub mod residual;
mod page;
pub mod paths;

pub use page::{pictures_page, prediction_page};
pub use prediction::{PredictionTable, Row};
pub use series::{EvaluateError, Series, Statistics};
pub use sheet::Sheet;
