//! Replays a recording through a predictor and its adapter in shadow, in the order of [`twin_core::flight::Flight`], without control.
//!
//! Every figure is a priori: the forecast for `j` is `base_j + W'_{t-1} g'_t`, made before `r_t` was seen.

use std::time::Instant;

use serde::Serialize;

use super::score::{Horizon, Score};
use super::series::{SCORED_FROM_S, Series, Statistics};
use twin_core::notation::{Coords, TICK_S};
use twin_core::residual::foresight::a_priori;
use twin_core::residual::{History, Predictor, lra};

/// The steps of a forecast that pictures draw over time.
pub const DRAWN_STEPS: [usize; 3] = [0, 6, 20];

/// Predictor and adapter that are replayed.
pub struct Entrant {
    /// Base forecast.
    pub predictor: Box<dyn Predictor>,
    /// Latent Residual Adapter.
    pub adapter: lra::Adapter,
    /// Settings of the adapter.
    pub settings: lra::Settings,
    /// Number of ticks of history.
    pub history_len: usize,
}

/// Result of a replay.
#[derive(Clone, Debug, Serialize)]
pub struct Replayed {
    /// Errors at `j = 0..=k`.
    pub horizons: Vec<Horizon>,
    /// Mean of the norm of the innovation, in the adapter's units.
    pub innovation_norm_mean: f64,
    /// 99.9 % quantile of the norm of the smoothed innovation, which the reset threshold is compared with.
    pub innovation_mean_q999: f64,
    /// Mean leverage `g'K`: the share of the newest residual's error that the adapter corrects; 0 without an adapter.
    pub leverage: f64,
    /// Number of covariance resets.
    pub resets: u64,
    /// Time for one forecast with its adaptation, median, ms.
    pub inference_ms_p50: f64,
    /// The same, 99 % quantile, ms.
    pub inference_ms_p99: f64,
    /// A-priori forecasts of [`DRAWN_STEPS`], per tick, for pictures; `None` beyond the horizon.
    #[serde(skip)]
    pub traces: Vec<[Option<Coords>; DRAWN_STEPS.len()]>,
}

impl Replayed {
    /// The errors `j` ticks ahead; `None` beyond the horizon of the predictor, and if no forecast was scored.
    pub fn at(&self, j: usize) -> Option<&Horizon> {
        self.horizons.get(j).filter(|horizon| horizon.samples > 0)
    }
}

/// Replays `series` through `entrant`.
pub fn replay(entrant: &mut Entrant, series: &Series, statistics: &Statistics) -> Replayed {
    let mut history = History::new(entrant.history_len);
    let mut score = Score::new(statistics);
    let mut times_ms = Vec::with_capacity(series.samples.len());
    let (mut norms, mut smoothed, mut leverages) = (Vec::new(), Vec::new(), Vec::new());
    let mut traces = Vec::with_capacity(series.samples.len());
    let mut resets = 0;
    for sample in &series.samples {
        history.push(sample.chi, sample.chi_dot, sample.tau, sample.residual);
        let started = now();
        let forecast = entrant.predictor.predict(&history);
        let adapted = entrant.adapter.step(
            &forecast,
            &history,
            &sample.residual.into(),
            TICK_S,
            !sample.usable,
            &entrant.settings,
        );
        times_ms.push(started.elapsed().as_secs_f64() * 1e3);
        let ahead = a_priori(&forecast, &adapted);
        let counts = sample.usable && sample.t_s >= SCORED_FROM_S;
        traces.push(DRAWN_STEPS.map(|j| ahead.get(j).copied()));
        score.add(ahead, &sample.residual, counts);
        if counts {
            resets += u64::from(adapted.reset);
            norms.push(adapted.innovation.norm());
            smoothed.push(adapted.innovation_mean_norm);
            leverages.push(leverage(&adapted, &sample.residual));
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    Replayed {
        horizons: score.finish(),
        innovation_norm_mean: mean(&norms),
        innovation_mean_q999: quantile(&mut smoothed, 0.999),
        leverage: mean(&leverages),
        resets,
        inference_ms_p50: quantile(&mut times_ms.clone(), 0.5),
        inference_ms_p99: quantile(&mut times_ms, 0.99),
        traces,
    }
}

/// `g'K`: the share of the estimate's error that one step of the adapter corrects.
fn leverage(adapted: &twin_core::tick::Adapted, residual: &Coords) -> f64 {
    let before = residual - *adapted.r_hat_prior;
    let moved = *adapted.r_hat - *adapted.r_hat_prior;
    let size = before.norm_squared();
    if size > 0.0 { moved.dot(&before) / size } else { 0.0 }
}

#[allow(clippy::disallowed_methods, reason = "inference time is what is measured")]
fn now() -> Instant {
    Instant::now()
}

/// The quantile `q` of the values; NaN if there are none. Sorts `values`.
pub(super) fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let index = ((values.len() as f64 - 1.0) * q).round().max(0.0) as usize;
    values.get(index).copied().unwrap_or(f64::NAN)
}
