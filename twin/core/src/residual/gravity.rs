//! Predictors from physics alone: zero, gravity of the empty vehicle, and gravity with an adapted offset.

use super::{GravityModel, History, Predictor, constant_forecast};
use crate::notation::Coords;
use crate::tick::Forecast;

/// Predicts `r_hat = 0`, so that the vehicle falls; the zero line of every comparison.
#[derive(Clone, Copy, Debug, Default)]
pub struct ZeroPredictor;

impl Predictor for ZeroPredictor {
    fn regime_len(&self) -> usize {
        0
    }

    fn predict(&mut self, _history: &History) -> Forecast {
        constant_forecast(Coords::zeros(), Vec::new())
    }
}

/// Predicts `r_hat = g(chi)`, the gravity force of the vehicle without payload.
#[derive(Clone)]
pub struct Gravity {
    model: GravityModel,
}

impl Gravity {
    /// A predictor with the gravity force `model`.
    pub fn new(model: GravityModel) -> Self {
        Self { model }
    }
}

impl Predictor for Gravity {
    fn regime_len(&self) -> usize {
        0
    }

    fn predict(&mut self, history: &History) -> Forecast {
        constant_forecast(base(&self.model, history), Vec::new())
    }
}

/// Predicts `g(chi)` with the one-feature regime `g' = [1]`, so that the adapter learns one offset per coordinate. It adapts
/// slowly on purpose: with it the effect of a covariance reset is visible.
#[derive(Clone)]
pub struct Bias {
    model: GravityModel,
}

impl Bias {
    /// A predictor with the gravity force `model`.
    pub fn new(model: GravityModel) -> Self {
        Self { model }
    }
}

impl Predictor for Bias {
    fn regime_len(&self) -> usize {
        1
    }

    fn predict(&mut self, history: &History) -> Forecast {
        constant_forecast(base(&self.model, history), vec![1.0])
    }
}

/// Gravity force at the newest coordinates, N and N m.
pub(super) fn base(model: &GravityModel, history: &History) -> Coords {
    history.newest().map_or_else(Coords::zeros, |entry| model(&entry.chi))
}
