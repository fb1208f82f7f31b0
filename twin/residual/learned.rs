//! Learned baselines of the paper's tables in flight: the same frame and blocks as the FDT, their own networks.
//!
//! In: [`History`]. Out: [`Forecast`] in N and N m, and the last hidden vector as the regime the adapter corrects on. State: the
//! weights; of those that learn in flight also the last layer.

pub mod mlp;
pub mod lstm;
pub mod transformer;
pub mod gpt2;
pub mod neural_fly;

use serde::{Deserialize, Serialize};

use super::weights::{Weights, WeightsError};
use super::{History, Predictor, PredictorInfo};
use crate::notation::{Coords, N};
use crate::tick::Forecast;

/// Words of the models in the heads of their files.
pub const NAMES: [&str; 5] =
    [lstm::NAME, transformer::NAME, gpt2::NAME, neural_fly::NAME, mlp::NAME];

/// Most of any size: what fits into memory.
const MOST: usize = 4096;

/// Sizes of a baseline; those that a model does not have are ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// Input channels.
    pub channels: usize,
    /// Rows of the residual.
    pub outputs: usize,
    /// Ticks of history.
    pub t_long: usize,
    /// Hidden width.
    pub d_model: usize,
    /// Attention heads.
    pub heads: usize,
    /// Hidden width of the feed-forward blocks.
    pub d_ff: usize,
    /// Width of the last hidden vector, the regime.
    pub d_k: usize,
    /// Layers.
    pub layers: usize,
    /// Horizon `k`.
    pub horizon: usize,
}

impl Sizes {
    /// Numbers of a readout.
    pub fn readout(&self) -> usize {
        (self.horizon + 1) * self.outputs
    }

    /// The sizes in a head.
    fn of(weights: &Weights) -> Result<Self, WeightsError> {
        let head = &weights.head;
        let sizes: Self = serde_json::from_value(head.config.clone())
            .map_err(|error| WeightsError::Head { reason: format!("config: {error}") })?;
        for (key, found, expected) in [
            ("channels", sizes.channels, head.channel_names.len()),
            ("outputs", sizes.outputs, head.output_names.len()),
        ] {
            if found != expected {
                let expected = format!("{expected}, as many as the head names");
                return Err(WeightsError::Config { key, found: found.to_string(), expected });
            }
        }
        let within = [
            ("t_long", sizes.t_long, MOST),
            ("d_model", sizes.d_model, MOST),
            ("heads", sizes.heads, sizes.d_model),
            ("d_ff", sizes.d_ff, MOST),
            ("d_k", sizes.d_k, MOST),
            ("layers", sizes.layers, 64),
            ("horizon", sizes.horizon + 1, 64),
        ];
        for (key, found, most) in within {
            if !(1..=most).contains(&found) {
                let expected = format!("1..={most}");
                return Err(WeightsError::Config { key, found: found.to_string(), expected });
            }
        }
        if !sizes.d_model.is_multiple_of(sizes.heads) {
            return Err(WeightsError::Config {
                key: "heads",
                found: sizes.heads.to_string(),
                expected: format!("a divisor of d_model = {}", sizes.d_model),
            });
        }
        Ok(sizes)
    }
}

/// A list of tensors with their shapes.
type Shapes = Vec<(String, Vec<usize>)>;

/// `stem.weight` `[out, inputs]` and `stem.bias` `[out]`.
fn linear(stem: &str, out: usize, inputs: usize) -> Shapes {
    vec![(format!("{stem}.weight"), vec![out, inputs]), (format!("{stem}.bias"), vec![out])]
}

/// `stem.weight` and `stem.bias`, `[width]` each.
fn norm(stem: &str, width: usize) -> Shapes {
    vec![(format!("{stem}.weight"), vec![width]), (format!("{stem}.bias"), vec![width])]
}

/// A baseline's network.
pub trait Network: Send {
    /// z-scored histories `[channels, t_long]`, oldest first, to z-scored forecasts `[horizon + 1, outputs]` and the last hidden
    /// vector `[d_k]`.
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>);

    /// Learns from the z-scored residual `[outputs]` of the tick whose last hidden vector was `hidden`.
    fn learn(&mut self, _hidden: &[f32], _residual: &[f32]) {}
}

/// The network of `weights`.
///
/// # Errors
/// [`WeightsError`] if they are of no baseline, or a tensor is not what it must be.
pub fn network(weights: &Weights) -> Result<(Sizes, Box<dyn Network>), WeightsError> {
    let sizes = Sizes::of(weights)?;
    let check = |shapes: Shapes| weights.check_tensors(&shapes);
    let network: Box<dyn Network> = match weights.head.model.as_str() {
        lstm::NAME => {
            check(lstm::tensors(&sizes))?;
            Box::new(lstm::Lstm::new(weights, &sizes))
        }
        transformer::NAME => {
            check(transformer::tensors(&sizes))?;
            Box::new(transformer::Transformer::new(weights, &sizes))
        }
        gpt2::NAME => {
            check(gpt2::tensors(&sizes))?;
            Box::new(gpt2::Gpt2::new(weights, &sizes))
        }
        neural_fly::NAME => {
            check(neural_fly::tensors(&sizes))?;
            Box::new(neural_fly::NeuralFly::new(weights, &sizes))
        }
        mlp::NAME => {
            check(mlp::tensors(&sizes))?;
            Box::new(mlp::Mlp::new(weights, &sizes))
        }
        found => {
            return Err(WeightsError::Model {
                found: found.to_owned(),
                expected: "lstm, transformer, gpt2, neural_fly or mlp",
            });
        }
    };
    Ok((sizes, network))
}

/// A baseline in flight.
pub struct Baseline {
    network: Box<dyn Network>,
    sizes: Sizes,
    /// Per channel: mean and reciprocal of the standard deviation; the latter zero where the channel is masked.
    inputs: Vec<(f64, f64)>,
    mean: Coords,
    std: Coords,
    regime_scale: f64,
    /// The last hidden vector of the tick before.
    hidden: Vec<f32>,
}

impl Baseline {
    /// The predictor of `weights`.
    ///
    /// # Errors
    /// [`WeightsError`] if they are of another model or vehicle, or a tensor is not what it must be.
    pub fn new(weights: &Weights) -> Result<Self, WeightsError> {
        let (sizes, network) = network(weights)?;
        weights.head.check_channels()?;
        let n = &weights.head.normalisation;
        let channels = weights.head.channel_names.iter().zip(n.input_mean.iter().zip(&n.input_std));
        let scale = |(name, (mean, std)): (&String, (&f64, &f64))| {
            (*mean, if n.masked.contains(name) { 0.0 } else { std.recip() })
        };
        Ok(Self {
            network,
            sizes,
            inputs: channels.map(scale).collect(),
            mean: Coords::from_column_slice(&n.output_mean),
            std: Coords::from_column_slice(&n.output_std),
            regime_scale: n.regime_scale,
            hidden: Vec::new(),
        })
    }

    /// z-scored histories `[channels, t_long]`; what is missing at the start is the oldest entry, held.
    fn window(&self, history: &History) -> Vec<f32> {
        let t_long = self.sizes.t_long;
        let skip = history.len().saturating_sub(t_long);
        let missing = t_long.saturating_sub(history.len());
        let mut x = vec![0.0; self.inputs.len() * t_long];
        for (tick, entry) in history.iter().skip(skip).enumerate() {
            let parts = [&entry.chi, &entry.chi_dot, &entry.tau_previous];
            let values = parts.into_iter().flat_map(|part| part.iter());
            for (channel, (value, (mean, per_std))) in values.zip(&self.inputs).enumerate() {
                // A masked channel is zero whatever it reads.
                let z = if *per_std == 0.0 { 0.0 } else { ((value - mean) * per_std) as f32 };
                let row = &mut x[channel * t_long..][..t_long];
                row[missing + tick] = z;
                if tick == 0 {
                    row[..missing].fill(z);
                }
            }
        }
        x
    }
}

impl Predictor for Baseline {
    fn regime_len(&self) -> usize {
        self.sizes.d_k
    }

    fn history_len(&self) -> usize {
        self.sizes.t_long
    }

    fn info(&self) -> PredictorInfo {
        PredictorInfo { scale: self.std, ..PredictorInfo::default() }
    }

    fn predict(&mut self, history: &History) -> Forecast {
        if let Some(entry) = history.newest().filter(|_| !self.hidden.is_empty()) {
            let z = (entry.residual_previous - self.mean).component_div(&self.std);
            let z: Vec<f32> = z.iter().map(|v| *v as f32).collect();
            if z.iter().all(|v| v.is_finite()) {
                self.network.learn(&self.hidden, &z);
            }
        }
        let (residual, hidden) = self.network.forward(&self.window(history));
        let physical = |z: &[f32]| {
            Coords::from_fn(|row, _| f64::from(z[row])).component_mul(&self.std) + self.mean
        };
        let forecast = Forecast {
            base: residual.chunks_exact(N).map(physical).collect(),
            regime: hidden.iter().map(|g| f64::from(*g) * self.regime_scale).collect(),
            attention: Vec::new(),
        };
        self.hidden = if hidden.iter().all(|v| v.is_finite()) { hidden } else { Vec::new() };
        forecast
    }
}

/// The ticks `[t, channels]` of histories `[channels, t]`.
fn by_tick(x: &[f32], t: usize) -> Vec<f32> {
    (0..t).flat_map(|tick| x.iter().skip(tick).step_by(t).copied()).collect()
}
