//! Converts between the units of a flight and the z-scores of a network, by the statistics of the network's training data.
//!
//! In: histories in their units, forecasts as z-scores. Out: histories as z-scores, a [`Forecast`] in N and N m. State: the
//! statistics, which never change.

use super::History;
use super::weights::{Head, WeightsError};
use crate::notation::{Coords, N};
use crate::tick::Forecast;

/// Statistics of the training data of one network.
#[derive(Clone, Debug)]
pub(super) struct Scaling {
    /// Mean of each input channel in its unit, and the reciprocal of its standard deviation; the reciprocal is zero for a masked
    /// channel.
    inputs: Vec<(f64, f64)>,
    /// Mean of each coordinate of the residual, N and N m.
    mean: Coords,
    /// Standard deviation of each coordinate of the residual, N and N m.
    pub(super) std: Coords,
    /// Factor on the regime that the adapter receives.
    regime_scale: f64,
}

impl Scaling {
    /// The statistics from `head`.
    ///
    /// # Errors
    /// [`WeightsError`] if the channels or outputs belong to another vehicle.
    pub(super) fn new(head: &Head) -> Result<Self, WeightsError> {
        head.check_channels()?;
        let n = &head.normalisation;
        let channels = head.channel_names.iter().zip(n.input_mean.iter().zip(&n.input_std));
        let scale = |(name, (mean, std)): (&String, (&f64, &f64))| {
            (*mean, if n.masked.contains(name) { 0.0 } else { std.recip() })
        };
        Ok(Self {
            inputs: channels.map(scale).collect(),
            mean: Coords::from_column_slice(&n.output_mean),
            std: Coords::from_column_slice(&n.output_std),
            regime_scale: n.regime_scale,
        })
    }

    /// Writes the last `t_long` ticks of `history` to `x`, `[channels, t_long]`, z-scored, oldest first. At the start of a flight
    /// the oldest entry stands for the missing ticks.
    pub(super) fn window(&self, history: &History, t_long: usize, x: &mut [f32]) {
        let skip = history.len().saturating_sub(t_long);
        let missing = t_long.saturating_sub(history.len());
        for (tick, entry) in history.iter().skip(skip).enumerate() {
            let parts = [&entry.chi, &entry.chi_dot, &entry.tau_previous];
            let values = parts.into_iter().flat_map(|part| part.iter());
            for (channel, (value, (mean, per_std))) in values.zip(&self.inputs).enumerate() {
                // A masked channel is zero whatever its value is.
                let z = if *per_std == 0.0 { 0.0 } else { ((value - mean) * per_std) as f32 };
                let row = &mut x[channel * t_long..][..t_long];
                row[missing + tick] = z;
                if tick == 0 {
                    row[..missing].fill(z);
                }
            }
        }
    }

    /// A residual in N and N m as z-scores.
    pub(super) fn z_scores(&self, residual: &Coords) -> Vec<f32> {
        (residual - self.mean).component_div(&self.std).iter().map(|v| *v as f32).collect()
    }

    /// The forecast from z-scored residuals `[horizon + 1, N]`, a regime `[d_k]` and the attention `[channels]`.
    pub(super) fn forecast(&self, residual: &[f32], regime: &[f32], attention: &[f32]) -> Forecast {
        let physical = |z: &[f32]| {
            Coords::from_fn(|row, _| f64::from(z[row])).component_mul(&self.std) + self.mean
        };
        Forecast {
            base: residual.chunks_exact(N).map(physical).map(Into::into).collect(),
            regime: regime.iter().map(|g| f64::from(*g) * self.regime_scale).collect(),
            attention: attention.iter().map(|weight| f64::from(*weight)).collect(),
        }
    }
}
