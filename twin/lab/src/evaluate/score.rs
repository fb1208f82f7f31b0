//! Scores of forecasts: RMSE and R² by horizon, in standard deviations of the training data and in N and N m.
//!
//! RMSE = √(mean over coordinates and time of the squared z-scored error). R² = mean over coordinates of
//! `1 - Σ(r - r̂)² / Σ(r - mean r)²`, with the mean over the scored ticks.

use std::collections::VecDeque;

use serde::Serialize;

use super::series::Statistics;
use twin_core::notation::{Coords, N};

/// Errors at one horizon.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Horizon {
    /// Ticks ahead.
    pub j: usize,
    /// Root mean square error over coordinates and time, z-scored.
    pub rmse_z: f64,
    /// Coefficient of determination, mean over coordinates.
    pub r2: f64,
    /// Root mean square error over the coordinates x y z, N.
    pub rmse_n: f64,
    /// Root mean square error over the other coordinates, N m.
    pub rmse_n_m: f64,
    /// Root mean square error of each coordinate, N and N m.
    pub rmse_rows: Coords,
    /// Number of forecasts that were scored.
    pub samples: u64,
}

#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    error: Coords,
    value: Coords,
    square: Coords,
}

/// Collects forecasts, and compares each with the residual of its tick.
pub struct Score {
    statistics: Statistics,
    pending: VecDeque<Vec<Coords>>,
    /// By horizon, as far as the longest forecast reaches.
    sums: Vec<Sums>,
}

impl Score {
    /// A score without forecasts; z-scores use `statistics`.
    pub fn new(statistics: &Statistics) -> Self {
        Self { statistics: statistics.clone(), pending: VecDeque::new(), sums: Vec::new() }
    }

    /// Adds a tick: its residual, and the forecast for `j = 0..=k` that was made at this tick before the residual was known. If `counts`
    /// is false, no forecast is scored against this residual.
    pub fn add(&mut self, forecast: Vec<Coords>, residual: &Coords, counts: bool) {
        self.sums.resize(self.sums.len().max(forecast.len()), Sums::default());
        self.pending.push_front(forecast);
        self.pending.truncate(self.sums.len());
        if !counts {
            return;
        }
        let z = |r: &Coords| {
            (r - self.statistics.output_mean).component_div(&self.statistics.output_std)
        };
        let value = z(residual);
        for (j, made) in self.pending.iter().enumerate() {
            let Some(forecast) = made.get(j) else { continue };
            let error = value - z(forecast);
            let sums = &mut self.sums[j];
            sums.count += 1.0;
            sums.error += error.component_mul(&error);
            sums.value += value;
            sums.square += value.component_mul(&value);
        }
    }

    /// The scores of every horizon, as far as the forecasts reach.
    pub fn finish(&self) -> Vec<Horizon> {
        let std = &self.statistics.output_std;
        let one = |(j, sums): (usize, &Sums)| {
            let n = sums.count.max(1.0);
            let rows = (sums.error / n).component_mul(&std.component_mul(std));
            let spread = sums.square - sums.value.component_mul(&sums.value) / n;
            let r2 = (0..N).map(|row| 1.0 - sums.error[row] / spread[row].max(f64::MIN_POSITIVE));
            let root = |from: usize, to: usize| {
                (rows.iter().skip(from).take(to - from).sum::<f64>() / (to - from) as f64).sqrt()
            };
            Horizon {
                j,
                rmse_z: (sums.error.sum() / (n * N as f64)).sqrt(),
                r2: r2.sum::<f64>() / N as f64,
                rmse_n: root(0, 3),
                rmse_n_m: root(3, N),
                rmse_rows: rows.map(f64::sqrt),
                samples: sums.count as u64,
            }
        };
        self.sums.iter().enumerate().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::residual::HORIZON;

    /// A few thousand roundings of numbers near 1.
    const ROUNDING: f64 = 1e-12;

    fn statistics() -> Statistics {
        Statistics {
            input_mean: vec![0.0; 24],
            input_std: vec![1.0; 24],
            output_mean: Coords::repeat(3.0),
            output_std: Coords::from_fn(|row, _| if row < 3 { 2.0 } else { 0.5 }),
        }
    }

    /// A square wave whose amplitude is one standard deviation about the mean, so its z-scores are ±1.
    fn wave(tick: usize) -> Coords {
        let sign = if tick.is_multiple_of(2) { 1.0 } else { -1.0 };
        statistics().output_mean + statistics().output_std * sign
    }

    #[test]
    fn a_perfect_forecast_scores_one_and_the_mean_scores_nothing() {
        let (mut perfect, mut mean) = (Score::new(&statistics()), Score::new(&statistics()));
        for tick in 0..1000 {
            let ahead = (0..=HORIZON).map(|j| wave(tick + j)).collect();
            perfect.add(ahead, &wave(tick), true);
            mean.add(vec![statistics().output_mean; HORIZON + 1], &wave(tick), true);
        }
        for (good, none) in perfect.finish().iter().zip(mean.finish()) {
            assert!(good.rmse_z == 0.0 && (good.r2 - 1.0).abs() < ROUNDING);
            // The error is one standard deviation: 1 in z, 2 N and 0.5 N m.
            assert!((none.rmse_z - 1.0).abs() < ROUNDING && none.r2.abs() < 1e-5);
            assert!((none.rmse_n - 2.0).abs() < ROUNDING && (none.rmse_n_m - 0.5).abs() < ROUNDING);
        }
    }

    #[test]
    fn persistence_of_a_square_wave_is_wrong_by_two_at_even_horizons_only() {
        let mut score = Score::new(&statistics());
        for tick in 1..2001 {
            score.add(vec![wave(tick - 1); HORIZON + 1], &wave(tick), true);
        }
        for horizon in score.finish() {
            // r_{t-1} against r_{t+j}: j + 1 ticks apart. R² = 1 - 4/1 where they differ.
            let wanted = if horizon.j.is_multiple_of(2) { (2.0, -3.0) } else { (0.0, 1.0) };
            assert!((horizon.rmse_z - wanted.0).abs() < ROUNDING, "{horizon:?}");
            assert!((horizon.r2 - wanted.1).abs() < 1e-5, "{horizon:?}");
            assert_eq!(horizon.samples, 2000 - horizon.j as u64);
        }
    }

    #[test]
    fn one_bad_row_of_eight_weighs_an_eighth() {
        let mut score = Score::new(&statistics());
        for tick in 0..100 {
            let mut forecast = wave(tick);
            forecast[4] += 0.5 * 3.0;
            score.add(vec![forecast], &wave(tick), true);
        }
        let now = score.finish()[0];
        // One coordinate is wrong by three standard deviations: sqrt(9/8), R² = (7 + (1 - 9))/8.
        assert!((now.rmse_z - (9.0_f64 / 8.0).sqrt()).abs() < ROUNDING);
        assert!((now.r2 + 0.125).abs() < ROUNDING && (now.rmse_rows[4] - 1.5).abs() < ROUNDING);
    }

    #[test]
    fn a_forecast_is_scored_as_far_as_it_reaches() {
        let mut score = Score::new(&statistics());
        for tick in 0..20 {
            score.add((0..=6).map(|j| wave(tick + j)).collect(), &wave(tick), true);
        }
        let horizons = score.finish();
        assert_eq!(horizons.len(), 7);
        assert!(horizons.iter().all(|h| h.rmse_z == 0.0 && h.samples == 20 - h.j as u64));
    }

    #[test]
    fn ticks_that_do_not_count_still_age_the_forecasts() {
        let mut score = Score::new(&statistics());
        for tick in 0..HORIZON + 6 {
            score.add((0..=HORIZON).map(|j| wave(tick + j)).collect(), &wave(tick), tick > HORIZON);
        }
        assert!(score.finish().iter().all(|h| h.rmse_z == 0.0 && h.samples == 5));
    }
}
