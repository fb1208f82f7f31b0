//! Persistence: the residual keeps its last value. As a controller this is time-delay control (TDC); as a prediction it is the
//! baseline that every predictor must beat.

use super::{History, Predictor, constant_forecast};
use crate::notation::Coords;
use crate::tick::Forecast;

/// Predicts `r_hat(t+j|t) = r_{t-1}` for every `j`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Persistence;

impl Predictor for Persistence {
    fn regime_len(&self) -> usize {
        0
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let base = history.newest().map_or_else(Coords::zeros, |entry| entry.residual_previous);
        constant_forecast(base, Vec::new())
    }
}
