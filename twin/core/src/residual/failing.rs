//! A predictor that answers NaN for some time: a scenario uses it to show that the loop survives such a failure.

use std::ops::Range;

use super::{History, Predictor, PredictorInfo};
use crate::notation::Coords;
use crate::tick::Forecast;

/// Another predictor, broken during some of its calls.
pub struct Failing {
    predictor: Box<dyn Predictor>,
    broken: Vec<Range<u64>>,
    calls: u64,
}

impl Failing {
    /// Wraps `predictor`: its answers are NaN in the calls `broken`, counted from 0.
    pub fn new(predictor: Box<dyn Predictor>, broken: Vec<Range<u64>>) -> Self {
        Self { predictor, broken, calls: 0 }
    }
}

impl Predictor for Failing {
    fn regime_len(&self) -> usize {
        self.predictor.regime_len()
    }

    fn history_len(&self) -> usize {
        self.predictor.history_len()
    }

    fn info(&self) -> PredictorInfo {
        self.predictor.info()
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let mut forecast = self.predictor.predict(history);
        if self.broken.iter().any(|calls| calls.contains(&self.calls)) {
            forecast.base.fill(Coords::repeat(f64::NAN).into());
            forecast.regime.fill(f64::NAN);
        }
        self.calls += 1;
        forecast
    }
}
