//! Fits the baselines without a network to recordings, and writes them as files of weights.

use serde_json::json;

use super::series::{Series, Statistics};
use twin_core::notation::{N, TICK_S};
use twin_core::residual::HORIZON;
use twin_core::residual::baselines::{Sindy, Standard, gp, sindy};
use twin_core::residual::weights::{
    Acceptance, FORMAT, Head, Normalisation, Tensor, Training, Weights, channel_names, output_names,
};

/// Channels that give the position and heading of the vehicle, on which the residual does not depend.
const MASKED: [&str; 3] = ["chi.x", "chi.y", "chi.psi"];

/// Ticks between two samples of the least squares, because neighbours are nearly equal.
const STRIDE: usize = 4;

/// Samples of the Gaussian process, and the number of those that choose its kernel.
pub const GP_SAMPLES: usize = 1000;
const GP_FEW: usize = 400;

/// A baseline without a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Baseline {
    /// [`sindy`].
    Sindy,
    /// [`gp`].
    Gp,
}

/// Fits `baseline` to `flights`. Returns `None` if the least squares cannot be solved.
pub fn fit(baseline: Baseline, flights: &[Series], data_hash: &str) -> Option<Weights> {
    let statistics = Statistics::of(flights);
    let mut head = head(flights, &statistics, data_hash)?;
    let standard = Standard::new(&head).ok()?;
    let (tensors, model, config) = match baseline {
        Baseline::Sindy => {
            let (x, y) = samples(flights, &standard, &statistics, STRIDE);
            let coefficients = sindy::fit(&x, &y, sindy::THRESHOLD);
            let config =
                json!({"library": "quadratic", "threshold": sindy::THRESHOLD, "samples": x.len()});
            (vec![Sindy::tensors(&coefficients)], sindy::NAME, config)
        }
        Baseline::Gp => {
            let ticks: usize = flights.iter().map(|flight| flight.samples.len()).sum();
            let stride = (ticks / GP_SAMPLES).max(1);
            let (x, y) = samples(flights, &standard, &statistics, stride);
            // Every k-th sample chooses the kernel, because neighbours in time say little about its length scales.
            let order = spread(x.len());
            let pick =
                |from: &[Vec<f64>]| order.iter().map(|i| from[*i].clone()).collect::<Vec<_>>();
            let found = gp::fit(&pick(&x), &pick(&y), GP_FEW)?;
            let config = json!({"kernel": "ard_rbf", "samples": x.len(), "kernel_samples": GP_FEW});
            (found.tensors(), gp::NAME, config)
        }
    };
    model.clone_into(&mut head.model);
    head.config = config;
    let tensors =
        tensors.into_iter().map(|(name, shape, values)| (name, Tensor { shape, values })).collect();
    Some(Weights { head, tensors })
}

/// The indices `0..n` in an order whose first entries already spread over the whole range.
fn spread(n: usize) -> Vec<usize> {
    const STEP: usize = 7;
    (0..STEP).flat_map(|first| (first..n).step_by(STEP)).collect()
}

/// z-scored inputs and targets at every `stride`-th tick for which the whole horizon is usable.
fn samples(
    flights: &[Series],
    standard: &Standard,
    statistics: &Statistics,
    stride: usize,
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    for flight in flights {
        let windows = flight.samples.windows(HORIZON + 2).step_by(stride.max(1));
        for window in windows.filter(|window| window.iter().all(|sample| sample.usable)) {
            let (before, ahead) = (&window[0], &window[1..]);
            x.push(standard.z([&ahead[0].chi, &ahead[0].chi_dot, &before.tau]));
            let target = ahead.iter().flat_map(|sample| {
                let z = (sample.residual - statistics.output_mean)
                    .component_div(&statistics.output_std);
                (0..N).map(move |row| z[row])
            });
            y.push(target.collect());
        }
    }
    (x, y)
}

fn head(flights: &[Series], statistics: &Statistics, data_hash: &str) -> Option<Head> {
    let list = |values: &twin_core::notation::Coords| values.iter().copied().collect::<Vec<f64>>();
    Some(Head {
        format: FORMAT,
        model: String::new(),
        config: serde_json::Value::Null,
        channel_names: channel_names(),
        output_names: output_names(),
        normalisation: Normalisation {
            masked: MASKED.map(str::to_owned).to_vec(),
            input_mean: statistics.input_mean.clone(),
            input_std: statistics.input_std.clone(),
            output_mean: list(&statistics.output_mean),
            output_std: list(&statistics.output_std),
            regime_scale: 1.0,
        },
        rate_hz: 1.0 / TICK_S,
        m_bar: list(&flights.first()?.m_bar),
        data_hash: data_hash.to_owned(),
        git: twin_record::program::commit().to_owned(),
        seed: 0,
        training: Training::default(),
        acceptance: Acceptance::default(),
    })
}
