//! The learned baselines of the paper's tables in flight: same inputs and building blocks as the FDT, but other networks.
//!
//! In: [`History`]. Out: [`Forecast`] in N and N m, with the last hidden vector as the regime that the adapter uses; a model without
//! hidden layers has none. State: the weights; a baseline that learns in flight also changes its last layer.

pub mod mlp;
mod stack;
pub mod lstm;
pub mod transformer;
pub mod gpt2;
pub mod neural_fly;
pub mod ridge;

use dyn_clone::{DynClone, clone_trait_object};
use serde::{Deserialize, Serialize};

use super::scaling::Scaling;
use super::weights::{self, ModelKind, Weights, WeightsError};
use super::{History, Predictor, PredictorInfo};
use crate::tick::Forecast;

/// Largest value of any size, so that the tensors fit into memory.
const MOST: usize = 4096;

/// Sizes of a baseline; a model ignores the sizes that it does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// Input channels.
    pub channels: usize,
    /// Coordinates of the residual.
    pub outputs: usize,
    /// Ticks of history.
    pub t_long: usize,
    /// Hidden width.
    pub d_model: usize,
    /// Attention heads.
    pub heads: usize,
    /// Hidden width of the feed-forward blocks.
    pub d_ff: usize,
    /// Width of the last hidden vector, the regime; 0 for the ridge regression, which has none.
    pub d_k: usize,
    /// Layers.
    pub layers: usize,
    /// Horizon `k`.
    pub horizon: usize,
}

impl Sizes {
    /// Number of values of the readout.
    pub fn readout(&self) -> usize {
        (self.horizon + 1) * self.outputs
    }

    /// The sizes in a head.
    fn of(weights: &Weights) -> Result<Self, WeightsError> {
        let sizes: Self = weights::sizes::read(&weights.head)?;
        weights::sizes::fit(&weights.head, sizes.channels, sizes.outputs)?;
        weights::sizes::within(&[
            ("t_long", sizes.t_long, MOST),
            ("d_model", sizes.d_model, MOST),
            ("heads", sizes.heads, sizes.d_model),
            ("d_ff", sizes.d_ff, MOST),
            ("layers", sizes.layers, 64),
            ("horizon", sizes.horizon + 1, 64),
        ])?;
        if weights.head.model == ModelKind::Ridge.name() {
            weights::sizes::exactly("d_k", sizes.d_k, 0)?;
        } else {
            weights::sizes::within(&[("d_k", sizes.d_k, MOST)])?;
        }
        weights::sizes::heads_divide(sizes.heads, sizes.d_model)?;
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
pub trait Network: DynClone + Send {
    /// z-scored histories `[channels, t_long]`, oldest first, to z-scored forecasts `[horizon + 1, outputs]` and the last hidden
    /// vector `[d_k]`.
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>);

    /// Learns from the z-scored residual `[outputs]` of the tick whose last hidden vector was `hidden`.
    fn learn(&mut self, _hidden: &[f32], _residual: &[f32]) {}
}

clone_trait_object!(Network);

/// How a baseline is read from a file.
struct Layout {
    /// Name and shape of every tensor.
    tensors: fn(&Sizes) -> Shapes,
    /// Builds the network from checked tensors.
    load: fn(&Weights, &Sizes) -> Box<dyn Network>,
}

impl Layout {
    /// The layout of the baseline `kind`; `None` for the FDT, which is no baseline.
    fn of(kind: ModelKind) -> Option<Self> {
        Some(match kind {
            ModelKind::Fdt => return None,
            ModelKind::Lstm => {
                Self { tensors: lstm::tensors, load: |w, s| Box::new(lstm::Lstm::new(w, s)) }
            }
            ModelKind::Transformer => Self {
                tensors: transformer::tensors,
                load: |w, s| Box::new(transformer::Transformer::new(w, s)),
            },
            ModelKind::Gpt2 => {
                Self { tensors: gpt2::tensors, load: |w, s| Box::new(gpt2::Gpt2::new(w, s)) }
            }
            ModelKind::NeuralFly => Self {
                tensors: neural_fly::tensors,
                load: |w, s| Box::new(neural_fly::NeuralFly::new(w, s)),
            },
            ModelKind::Mlp => {
                Self { tensors: mlp::tensors, load: |w, s| Box::new(mlp::Mlp::new(w, s)) }
            }
            ModelKind::Ridge => {
                Self { tensors: ridge::tensors, load: |w, s| Box::new(ridge::Ridge::new(w, s)) }
            }
        })
    }
}

/// The network of `weights`.
///
/// # Errors
/// [`WeightsError`] if they belong to no baseline, or if a tensor is missing or has a wrong shape.
pub fn network(weights: &Weights) -> Result<(Sizes, Box<dyn Network>), WeightsError> {
    let sizes = Sizes::of(weights)?;
    let word = &weights.head.model;
    let layout = ModelKind::named(word).and_then(Layout::of).ok_or_else(|| {
        let expected = "lstm, transformer, gpt2, neural_fly, mlp or ridge";
        WeightsError::Model { found: word.clone(), expected }
    })?;
    weights.check_tensors(&(layout.tensors)(&sizes))?;
    Ok((sizes, (layout.load)(weights, &sizes)))
}

/// A baseline in flight.
#[derive(Clone)]
pub struct Baseline {
    network: Box<dyn Network>,
    sizes: Sizes,
    scaling: Scaling,
    /// The last hidden vector of the previous tick.
    hidden: Vec<f32>,
}

impl Baseline {
    /// The predictor of `weights`.
    ///
    /// # Errors
    /// [`WeightsError`] if they belong to another model or vehicle, or if a tensor is missing or has a wrong shape.
    pub fn new(weights: &Weights) -> Result<Self, WeightsError> {
        let (sizes, network) = network(weights)?;
        Ok(Self { network, sizes, scaling: Scaling::new(&weights.head)?, hidden: Vec::new() })
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
        let horizon = self.sizes.horizon;
        PredictorInfo { scale: self.scaling.std, horizon, ..PredictorInfo::default() }
    }

    fn predict(&mut self, history: &History) -> Forecast {
        if let Some(entry) = history.newest().filter(|_| !self.hidden.is_empty()) {
            let z = self.scaling.z_scores(&entry.residual_previous);
            if z.iter().all(|v| v.is_finite()) {
                self.network.learn(&self.hidden, &z);
            }
        }
        let mut x = vec![0.0; self.sizes.channels * self.sizes.t_long];
        self.scaling.window(history, self.sizes.t_long, &mut x);
        let (residual, hidden) = self.network.forward(&x);
        let forecast = self.scaling.forecast(&residual, &hidden, &[]);
        self.hidden = if hidden.iter().all(|v| v.is_finite()) { hidden } else { Vec::new() };
        forecast
    }
}

/// Transposes histories `[channels, t]` to ticks `[t, channels]`.
fn by_tick(x: &[f32], t: usize) -> Vec<f32> {
    (0..t).flat_map(|tick| x.iter().skip(tick).step_by(t).copied()).collect()
}
