//! A predictor that answers NaN for some time: a scenario uses it to show that the loop survives such a failure.

use std::ops::Range;

use super::{History, Predictor, PredictorInfo};
use crate::notation::Coords;
use crate::tick::Forecast;

/// Another predictor, broken during some of its calls.
#[derive(Clone)]
pub struct Failing {
    predictor: Box<dyn Predictor>,
    /// Ranges of calls that did not begin yet; the first is last.
    broken: Vec<Range<u64>>,
    /// End of the ranges that have begun.
    until: u64,
    calls: u64,
}

impl Failing {
    /// Wraps `predictor`: its answers are NaN in the calls `broken`, counted from 0.
    pub fn new(predictor: Box<dyn Predictor>, mut broken: Vec<Range<u64>>) -> Self {
        broken.sort_by_key(|calls| std::cmp::Reverse(calls.start));
        Self { predictor, broken, until: 0, calls: 0 }
    }

    /// Whether this call is broken. Every range is taken once, so the work over a flight grows with the number of ranges.
    fn is_broken(&mut self) -> bool {
        while let Some(begun) = self.broken.pop_if(|calls| calls.start <= self.calls) {
            self.until = self.until.max(begun.end);
        }
        self.calls < self.until
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
        if self.is_broken() {
            forecast.base.fill(Coords::repeat(f64::NAN).into());
            forecast.regime.fill(f64::NAN);
        }
        self.calls += 1;
        forecast
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::persistence::Persistence;

    #[test]
    fn exactly_the_calls_of_the_ranges_are_broken_in_whichever_order_they_are_given() {
        let ranges = vec![6..7, 0..1, 3..5, 4..4, 3..4, 9..u64::MAX];
        let mut failing = Failing::new(Box::new(Persistence), ranges.clone());
        for call in 0..12 {
            let wanted = ranges.iter().any(|range| range.contains(&call));
            assert_eq!(failing.is_broken(), wanted, "{call}");
            failing.calls += 1;
        }
    }
}
