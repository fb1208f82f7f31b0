//! The oracle: it forecasts the residual of an earlier flight of the same scenario and seed. No method can know this; it is the upper
//! bound beside which methods are judged.
//!
//! In: residuals of that flight, in order. Out: forecasts. State: the number of the next forecast.

use super::{HORIZON, History, Predictor};
use crate::notation::Coords;
use crate::tick::Forecast;

/// A predictor that knows what came.
#[derive(Clone, Debug)]
pub struct Oracle {
    residuals: Vec<Coords>,
    next: usize,
}

impl Oracle {
    /// An oracle that knows the `residuals` of all outer periods, N and N m.
    pub fn new(residuals: Vec<Coords>) -> Self {
        Self { residuals, next: 0 }
    }

    /// The residual of outer period `at`; the last one stays after the end of the earlier flight.
    fn residual(&self, at: usize) -> Coords {
        let last = self.residuals.last().copied().unwrap_or_else(Coords::zeros);
        self.residuals.get(at).copied().unwrap_or(last)
    }
}

impl Predictor for Oracle {
    fn regime_len(&self) -> usize {
        0
    }

    fn predict(&mut self, _history: &History) -> Forecast {
        let base = (0..=HORIZON).map(|j| self.residual(self.next + j).into()).collect();
        self.next += 1;
        Forecast { base, regime: Vec::new(), attention: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_forecast_is_what_came_and_the_end_stays() {
        let came: Vec<Coords> = (0..10).map(|t| Coords::repeat(f64::from(t))).collect();
        let mut oracle = Oracle::new(came);
        let history = History::new(1);
        for t in 0..20 {
            let forecast = oracle.predict(&history);
            for (j, base) in forecast.base.iter().enumerate() {
                assert_eq!(**base, Coords::repeat((t + j).min(9) as f64), "{t} {j}");
            }
        }
    }
}
