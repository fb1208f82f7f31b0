//! How well the residual is foreseen: by its newest value, and by ridge regressions on a short and on a long window.
//!
//! In: training flights and test flights. Out: root mean square errors by model, horizon and coordinate. The last fifth of each training
//! flight chooses the ridge; then the models are fitted to all of the training flights.

use serde::Serialize;

use super::super::series::ReplayTick;
use super::windows::{HORIZONS_TICKS, LONG, SHORT, Scale, TARGETS, Windows, inputs, matrices};
use crate::ridge::{Fitted, Normal, fit};
use twin_core::elementary::squared;
use twin_core::notation::{Coords, N};

/// Names of the models, in the order of [`Foresight::rmse`].
pub const MODEL_NAMES: [&str; 3] = ["persistence", "10 ticks", "120 ticks"];

/// Share of a training flight that chooses the ridge.
const VALIDATION: f64 = 0.2;

/// Ticks between two samples of the fit, because neighbours are nearly equal. The test uses every tick.
const STRIDE: usize = 4;

/// Number of windows that are in memory at a time.
const BLOCK: usize = 1000;

/// Errors of the forecasts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Foresight {
    /// Root mean square error by model, horizon and coordinate, N and N m; NaN without samples.
    pub rmse: [[Coords; HORIZONS_TICKS.len()]; MODEL_NAMES.len()],
    /// Ridge of the two regressions; `None` without samples.
    pub ridge: Option<[f64; 2]>,
    /// Windows of the fit and of the test.
    pub samples: [usize; 2],
}

impl Foresight {
    /// RMSE of a model at a horizon over coordinates and time, in units of `std`.
    pub fn rmse_z(&self, model: usize, horizon: usize, std: &Coords) -> f64 {
        let z = self.rmse[model][horizon].component_div(std);
        (z.norm_squared() / N as f64).sqrt()
    }

    /// RMSE of the long window divided by that of the short window.
    pub fn ratio(&self, horizon: usize, std: &Coords) -> f64 {
        self.rmse_z(2, horizon, std) / self.rmse_z(1, horizon, std)
    }
}

/// Fits the models to the flights `training`, and scores their forecasts on the flights `test`.
pub fn foresee(training: &[&[ReplayTick]], test: &[&[ReplayTick]]) -> Foresight {
    let scale = Scale::of(training);
    let (models, fitted) = regressions(training, &scale);
    let flights: Vec<Windows> = test.iter().map(|ticks| Windows::new(ticks, &scale)).collect();
    let ends = ends(&flights, 1, |ends| 0..ends);
    let mut squares = [[Coords::zeros(); HORIZONS_TICKS.len()]; MODEL_NAMES.len()];
    for block in ends.chunks(BLOCK) {
        let (x, y) = matrices(&flights, block);
        let foreseen = models.as_ref().map(|models| {
            models.each_ref().map(|model| {
                let inputs = model.coefficients.nrows();
                model.coefficients.tr_mul(&x.rows(0, inputs))
            })
        });
        for (sample, (flight, t)) in block.iter().enumerate() {
            for target in 0..TARGETS {
                let (horizon, row) = (target / N, target % N);
                let actual = y[(target, sample)];
                let newest = flights[*flight].newest_residual(*t, row);
                squares[0][horizon][row] += squared(actual - newest);
                for (model, foreseen) in foreseen.iter().flatten().enumerate() {
                    let error = actual - foreseen[(target, sample)];
                    squares[1 + model][horizon][row] += squared(error);
                }
            }
        }
    }
    let std = Coords::from(scale.output.map(|[_, std]| std));
    let root = |known: bool, squares: Coords| {
        let count = if known { ends.len() as f64 } else { 0.0 };
        (squares / count).map(f64::sqrt).component_mul(&std)
    };
    let known = |model: usize| model == 0 || models.is_some();
    let rmse = |model: usize| squares[model].map(|squares| root(known(model), squares));
    Foresight {
        rmse: std::array::from_fn(rmse),
        ridge: models.as_ref().map(|models| models.each_ref().map(|model| model.ridge)),
        samples: [fitted, ends.len()],
    }
}

/// The regressions on the short and on the long window, and the number of samples that they are fitted to.
fn regressions(training: &[&[ReplayTick]], scale: &Scale) -> (Option<[Fitted; 2]>, usize) {
    let flights: Vec<Windows> = training.iter().map(|ticks| Windows::new(ticks, scale)).collect();
    let split = |n: usize| (n as f64 * (1.0 - VALIDATION)) as usize;
    let sum = |ends: &[(usize, usize)]| {
        let mut sum = Normal::new(inputs(LONG), TARGETS);
        for block in ends.chunks(BLOCK) {
            let (x, y) = matrices(&flights, block);
            sum.add(&x, &y);
        }
        sum
    };
    let part = ends(&flights, STRIDE, |n| 0..split(n));
    // Windows of the two parts do not overlap.
    let rest = ends(&flights, STRIDE, |n| (split(n) + LONG).min(n)..n);
    let (fitted, validation) = (sum(&part), sum(&rest));
    let model = |ticks: usize| fit(&fitted, &validation, inputs(ticks));
    let models = model(SHORT).zip(model(LONG)).map(|(short, long)| [short, long]);
    (models, part.len() + rest.len())
}

/// Flight and tick of every `stride`-th window end within the part of each flight that `range` chooses by its number of ends.
fn ends(
    flights: &[Windows<'_>],
    stride: usize,
    range: impl Fn(usize) -> std::ops::Range<usize>,
) -> Vec<(usize, usize)> {
    let of = |(flight, windows): (usize, &Windows<'_>)| {
        let ends = windows.ends();
        let chosen = ends[range(ends.len())].iter().step_by(stride);
        chosen.map(|t| (flight, *t)).collect::<Vec<_>>()
    };
    flights.iter().enumerate().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;
    use twin_core::normal::StandardNormal;

    const TICKS: usize = 20_000;

    /// Share by which an error over 20 000 ticks may differ from its expectation: sampling, and coefficients that are fitted to 8000
    /// samples.
    const SAMPLING: f64 = 0.05;

    /// A process `r_t = share r_{t-lag} + e_t` with e of variance 1 in the first `rows` coordinates; all other channels are zero.
    fn process(seed: u64, lag: usize, share: f64, rows: usize) -> Vec<ReplayTick> {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut residuals = vec![Coords::zeros(); lag];
        for i in 0..TICKS {
            let mut draw = || -> f64 { rand::RngExt::sample(&mut rng, StandardNormal) };
            let e = Coords::from_fn(|row, _| if row < rows { draw() } else { 0.0 });
            residuals.push(residuals[i] * share + e);
        }
        let zero = Coords::zeros();
        let tick = |residual: &Coords| ReplayTick {
            t_s: 0.0,
            chi: zero,
            chi_dot: zero,
            tau: zero,
            residual: *residual,
            usable: true,
        };
        residuals[lag..].iter().map(tick).collect()
    }

    fn close(found: f64, expected: f64) -> bool {
        (found / expected - 1.0).abs() < SAMPLING
    }

    #[test]
    fn a_process_of_the_first_order_is_foreseen_as_well_as_it_can_be() {
        let share = 0.95;
        let (training, test) = (process(1, 1, share, N), process(2, 1, share, N));
        let found = foresee(&[&training], &[&test]);
        let variance = 1.0 / (1.0 - share * share);
        for (horizon, ticks) in HORIZONS_TICKS.into_iter().enumerate() {
            // The newest residual is one tick old, so h ticks ahead are h + 1 steps.
            let steps = i32::try_from(ticks + 1).unwrap();
            let kept = twin_core::elementary::powi(share, steps);
            let best = (variance * (1.0 - kept * kept)).sqrt();
            let persistence = (2.0 * variance * (1.0 - kept)).sqrt();
            let rmse = |model: usize| found.rmse_z(model, horizon, &Coords::repeat(1.0));
            assert!(close(rmse(0), persistence), "{ticks}: {} {persistence}", rmse(0));
            assert!(close(rmse(1), best), "{ticks}: {} {best}", rmse(1));
            assert!(close(rmse(2), best), "{ticks}: {} {best}", rmse(2));
        }
    }

    #[test]
    fn only_the_long_window_sees_a_cause_that_lies_half_a_second_back() {
        let share = 0.9;
        let (training, test) = (process(3, 50, share, 1), process(4, 50, share, 1));
        let found = foresee(&[&training], &[&test]);
        let rmse = |model: usize| found.rmse[model][0][0];
        // The short window sees nothing. A mean of 5 ticks, of which one is the cause, explains a fifth of what the cause explains.
        let variance = 1.0 / (1.0 - share * share);
        let (short, long) = (variance.sqrt(), (variance * (1.0 - share * share / 5.0)).sqrt());
        assert!(close(rmse(1), short), "{} {short}", rmse(1));
        assert!(close(rmse(2), long), "{} {long}", rmse(2));
        // One coordinate alone has errors, so the ratio over all coordinates is its ratio.
        let ratio = found.ratio(0, &Coords::repeat(1.0));
        assert!((ratio - rmse(2) / rmse(1)).abs() < 1e-12 && ratio < 0.95, "{ratio}");
    }

    #[test]
    fn flights_that_are_too_short_give_no_figures() {
        let ticks = process(5, 1, 0.5, N);
        let found = foresee(&[&ticks[..50]], &[&ticks[..50]]);
        assert_eq!((found.ridge, found.samples), (None, [0, 0]));
        assert!(found.rmse_z(0, 0, &Coords::repeat(1.0)).is_nan());
    }
}
