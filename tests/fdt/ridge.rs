//! The ridge regression in flight: its forecast is the plain sum, and the adapter copes with a predictor that has no regime.

use twin_core::notation::{COORDINATE_NAMES, Coords, N};
use twin_core::residual::learned::{Baseline, Sizes, ridge};
use twin_core::residual::weights::{FdtConfig, Tensor, Weights, WeightsError};
use twin_core::residual::{History, Predictor, lra};
use twin_core::tick::Forecast;

use super::made;

/// Sums of 240 products in f32, for forecasts of a few newtons.
const TOLERANCE: f64 = 1e-4;

const SIZES: Sizes = Sizes {
    channels: 3 * N,
    outputs: N,
    t_long: 10,
    d_model: 1,
    heads: 1,
    d_ff: 1,
    d_k: 0,
    layers: 1,
    horizon: 25,
};

/// Random weights with these sizes.
fn weights(sizes: Sizes) -> Weights {
    let mut chance = made::Chance::new(4);
    let mut head = made::head(&FdtConfig::SMALL);
    "ridge".clone_into(&mut head.model);
    head.config = serde_json::to_value(sizes).expect("plain numbers");
    let tensors = ridge::tensors(&sizes).into_iter().map(|(name, shape)| {
        let values = chance.normals(shape.iter().product()).iter().map(|v| 0.1 * v).collect();
        (name, Tensor { shape, values })
    });
    Weights { tensors: tensors.collect(), head }
}

/// A history of `ticks` ticks, and the values of its channels tick by tick.
fn history(ticks: usize) -> (History, Vec<[Coords; 3]>) {
    let mut chance = made::Chance::new(7);
    let mut draw = || Coords::from_fn(|_, _| f64::from(chance.normal()));
    let (mut history, mut rows, mut tau) = (History::new(SIZES.t_long), Vec::new(), None);
    for _ in 0..ticks {
        let [chi, chi_dot, now] = [draw(), draw(), draw()];
        history.push(chi, chi_dot, now, Coords::zeros());
        rows.push([chi, chi_dot, tau.unwrap_or(now)]);
        tau = Some(now);
    }
    (history, rows)
}

#[test]
fn its_forecast_is_the_sum_over_channels_and_ticks() {
    let weights = weights(SIZES);
    let (history, rows) = history(15);
    let said = Baseline::new(&weights).expect("weights").predict(&history);
    let (z, n) = (&weights.head.normalisation, &weights.head.channel_names);
    let (w, b) =
        (&weights.tensors["readout.weight"].values, &weights.tensors["readout.bias"].values);
    assert_eq!((said.base.len(), said.regime.len()), (SIZES.horizon + 1, 0));
    for (j, base) in said.base.iter().enumerate() {
        for row in 0..N {
            let output = j * N + row;
            let mut sum = f64::from(b[output]);
            for channel in (0..SIZES.channels).filter(|c| !z.masked.contains(&n[*c])) {
                for tick in 0..SIZES.t_long {
                    let value = rows[5 + tick][channel / N][channel % N];
                    let score = (value - z.input_mean[channel]) / z.input_std[channel];
                    let at = (output * SIZES.channels + channel) * SIZES.t_long + tick;
                    sum += f64::from(w[at]) * score;
                }
            }
            let wanted = sum * z.output_std[row] + z.output_mean[row];
            let name = COORDINATE_NAMES[row];
            assert!((base[row] - wanted).abs() < TOLERANCE, "{name} at {j}: {base:?} {wanted}");
        }
    }
}

#[test]
fn the_adapter_leaves_a_forecast_without_regime_as_it_is() {
    let mut predictor = Baseline::new(&weights(SIZES)).expect("weights");
    let settings = lra::Settings::default();
    let mut adapter = lra::Adapter::new(predictor.regime_len(), predictor.info().scale, &settings);
    let (history, _) = history(15);
    let forecast: Forecast = predictor.predict(&history);
    for _ in 0..3 {
        let residual = Coords::repeat(2.0).into();
        let adapted = adapter.step(&forecast, &history, &residual, 0.01, false, &settings);
        assert_eq!(*adapted.r_hat, *forecast.base[0]);
        assert!(adapted.innovation.iter().all(|v| v.is_finite()) && !adapted.reset);
    }
    adapter.move_to(&forecast, &Coords::repeat(1.0), &settings);
    assert_eq!(adapter.weights().len(), 0);
}

#[test]
fn a_width_of_a_regime_that_it_does_not_have_is_refused() {
    let refused = Baseline::new(&weights(Sizes { d_k: 4, ..SIZES })).err();
    let (found, expected) = ("4".to_owned(), "0".to_owned());
    assert_eq!(refused, Some(WeightsError::Config { key: "d_k", found, expected }));
}
