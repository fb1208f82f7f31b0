//! ARX per coordinate: each coordinate's residual is forecast from its own past, its applied force and its rate, by recursive least
//! squares (RLS) with a bias and forgetting. It needs no training, and no other coordinate, so it serves vehicles of which only some
//! coordinates are known.
//!
//! In: the history with the mask of known residuals. Out: forecasts for `j = 0..=k`. State: one `ArxRow` for each coordinate.
//!
//! [`ArxRls`](super::ArxRls) is one model of all coordinates; it learns their coupling where all of them are known.

use super::arx_row::{ArxRow, FORCE_AGES, Past, RESIDUALS};
use super::history::Entry;
use super::knots::{KNOTS, between};
use super::{HORIZON, History, NOMINAL_SCALE, Predictor};
use crate::notation::{Coords, N};
use crate::tick::Forecast;

/// Number of ticks of history that it reads.
const TICKS: usize = FORCE_AGES[FORCE_AGES.len() - 1] + 1;

/// The autoregressions as a predictor.
#[derive(Clone, Debug)]
pub struct ArxRows {
    rows: [ArxRow; N],
}

impl Default for ArxRows {
    /// The predictor before its first tick: it forecasts the last residual.
    fn default() -> Self {
        Self { rows: NOMINAL_SCALE.map(ArxRow::new) }
    }
}

/// What coordinate `row` did, from entries that are newest first.
fn past(entries: &[&Entry], row: usize) -> Past {
    // What is not finite is a fault of its source; it must never be learned.
    let known = |age: usize| {
        let entry = entries.get(age)?;
        let is_number = entry.residual_previous[row].is_finite();
        (entry.known_previous[row] && is_number && entry.tau_previous[row].is_finite())
            .then_some(entry)
    };
    Past {
        residuals: std::array::from_fn::<_, RESIDUALS, _>(|age| {
            Some(known(age)?.residual_previous[row])
        }),
        forces: FORCE_AGES.map(|age| Some(known(age)?.tau_previous[row])),
        rate: entries.first().map_or(0.0, |entry| entry.chi_dot[row]),
    }
}

impl Predictor for ArxRows {
    fn regime_len(&self) -> usize {
        0
    }

    fn history_len(&self) -> usize {
        TICKS
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let newest_first = history.len().saturating_sub(TICKS);
        let mut entries: Vec<&Entry> = history.iter().skip(newest_first).collect();
        entries.reverse();
        let last = entries.first().map_or_else(Coords::zeros, |entry| entry.residual_previous);
        let knots: [[f64; KNOTS.len()]; N] = std::array::from_fn(|row| {
            let said = self.rows[row].step(&past(&entries, row));
            said.unwrap_or([last[row]; KNOTS.len()])
        });
        let base = (0..=HORIZON)
            .map(|j| Coords::from_fn(|row, _| between(&knots[row], j)).into())
            .collect();
        Forecast { base, regime: Vec::new(), attention: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::cos;
    use crate::notation::KnownCoords;

    fn residual(tick: usize) -> Coords {
        Coords::from_fn(|row, _| 1.0 + cos(tick as f64 * (0.02 + 0.003 * row as f64)))
    }

    #[test]
    fn it_starts_as_persistence_and_learns_a_wave_of_each_known_coordinate() {
        // The line between knots 9 ticks apart misses a wave of at most 0.041 rad a tick by (9 / 2)² / 2 · 0.041² = 0.017; the shrinkage
        // and the running mean, which forget nothing, leave a few times as much.
        const TOLERANCE: f64 = 0.1;
        const TICKS_FLOWN: usize = 4000;
        const UNKNOWN: usize = 3;
        let (mut arx, mut history) = (ArxRows::default(), History::new(TICKS));
        let mut known = [true; N];
        known[UNKNOWN] = false;
        let mut said = None;
        for tick in 0..TICKS_FLOWN {
            let mut residual = residual(tick);
            // A stand-in, which must not be learned.
            residual[UNKNOWN] = 7.0;
            history.push_masked(Coords::zeros(), Coords::zeros(), residual, residual, known);
            let forecast = arx.predict(&history);
            if tick == 0 {
                assert!(forecast.base.iter().all(|base| (**base - residual).norm() < 1e-12));
            }
            said = Some(forecast);
        }
        let said = said.unwrap();
        assert_eq!(said.base.len(), HORIZON + 1);
        for (j, base) in said.base.iter().enumerate() {
            let mut error = **base - residual(TICKS_FLOWN - 1 + j);
            error[UNKNOWN] = 0.0;
            assert!(error.amax() < TOLERANCE, "{error} at {j}");
        }
        let persistence = (residual(TICKS_FLOWN - 2) - residual(TICKS_FLOWN - 1 + HORIZON)).amax();
        assert!(persistence > 5.0 * TOLERANCE, "{persistence}");
        assert!(said.base.iter().all(KnownCoords::is_finite));
    }
}
