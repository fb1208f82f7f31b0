//! Predictors that know physics and nothing else: nothing, gravity of the empty vehicle, gravity with an adapted offset.

use super::{GravityModel, History, Predictor, constant_forecast};
use crate::notation::Coords;
use crate::tick::Forecast;

/// `r_hat = 0`: the vehicle falls; kept as the honest zero of every comparison.
#[derive(Clone, Copy, Debug, Default)]
pub struct None;

impl Predictor for None {
    fn regime_len(&self) -> usize {
        0
    }

    fn predict(&mut self, _history: &History) -> Forecast {
        constant_forecast(Coords::zeros(), Vec::new())
    }
}

/// `r_hat = g(chi)` of the vehicle without payload.
pub struct Gravity {
    model: GravityModel,
}

impl Gravity {
    /// With the gravity force of the vehicle.
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

/// `g(chi)` with a one-feature regime `g' = [1]`: the adapter learns a plain offset per row. Slow on purpose, it is where a
/// covariance reset shows what it is for.
pub struct Bias {
    model: GravityModel,
}

impl Bias {
    /// With the gravity force of the vehicle.
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

/// Gravity at the newest coordinates.
pub(super) fn base(model: &GravityModel, history: &History) -> Coords {
    history.newest().map_or_else(Coords::zeros, |entry| model(&entry.chi))
}
