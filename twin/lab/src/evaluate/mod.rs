//! The paper's tables, measured on the twin: how well residuals are predicted, how well flights are tracked.
//!
//! In: recordings and scenarios. Out: tables as plain values, pictures, pages. No printing: that is `cli`.

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
pub mod mirrored;
mod page;
pub mod paths;

pub use page::{pictures_page, prediction_page};
pub use prediction::{PredictionTable, Row};
pub use series::{EvaluateError, Series, Statistics};
pub use sheet::Sheet;
