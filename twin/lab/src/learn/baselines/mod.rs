//! The learned baselines of the paper's tables for training, one file each. `residual::learned` has the form that flies.

mod mlp;
mod lstm;
mod gpt2;
mod transformer;
mod neural_fly;
mod ridge;

use burn_tensor::Tensor;

use super::config::TrainConfig;
use super::graph::{Leaves, Network, Output};
use twin_core::residual::learned::{self, Sizes};
use twin_core::residual::weights::ModelKind;

/// The network of the baseline `config.model`, for this number of channels, outputs and flights.
pub fn network(
    config: &TrainConfig,
    channels: usize,
    outputs: usize,
    flights: usize,
) -> Box<dyn Network> {
    let sizes = Sizes {
        channels,
        outputs,
        t_long: config.t_long,
        d_model: config.d_model,
        heads: config.heads,
        d_ff: config.d_ff,
        d_k: match config.model {
            ModelKind::NeuralFly => config.d_k,
            ModelKind::Ridge => 0,
            _ => config.d_model,
        },
        layers: config.layers,
        horizon: config.horizon,
    };
    let (forward, tensors): (Forward, _) = match config.model {
        ModelKind::NeuralFly => return Box::new(neural_fly::NeuralFly { sizes, flights }),
        ModelKind::Ridge => return Box::new(ridge::Ridge { sizes }),
        ModelKind::Lstm => (lstm::forward, learned::lstm::tensors(&sizes)),
        ModelKind::Transformer => (transformer::forward, learned::transformer::tensors(&sizes)),
        ModelKind::Gpt2 => (gpt2::forward, learned::gpt2::tensors(&sizes)),
        ModelKind::Mlp | ModelKind::Fdt => (mlp::forward, learned::mlp::tensors(&sizes)),
    };
    Box::new(Plain { sizes, tensors, forward })
}

/// The forward pass of a baseline: forecast and last hidden vector of the histories `[batch, channels, t]`.
type Forward = fn(&Sizes, &Leaves, Tensor<3>) -> Output;

/// A baseline that has only a forward pass of its own, and is trained with the default [`Network::loss`].
struct Plain {
    sizes: Sizes,
    tensors: Vec<(String, Vec<usize>)>,
    forward: Forward,
}

impl Network for Plain {
    fn config(&self) -> serde_json::Value {
        head(&self.sizes)
    }

    fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        self.tensors.clone()
    }

    fn forward(&self, w: &Leaves, x: Tensor<3>) -> Output {
        (self.forward)(&self.sizes, w, x)
    }
}

/// Sizes in the form of a file's head.
fn head(sizes: &Sizes) -> serde_json::Value {
    serde_json::to_value(sizes).unwrap_or_default()
}

/// Forecast `[batch, horizon + 1, outputs]` that the layer `readout` makes from the last hidden vector.
fn readout(w: &Leaves, sizes: &Sizes, hidden: Tensor<2>) -> Tensor<3> {
    let batch = hidden.dims()[0];
    w.linear("readout", hidden).reshape([batch, sizes.horizon + 1, sizes.outputs])
}

/// Reshapes a batch `[batch, channels, t]` to `[batch * t, channels]`; the tick runs fastest.
fn ticks(x: Tensor<3>) -> Tensor<2> {
    let [batch, channels, t] = x.dims();
    x.swap_dims(1, 2).reshape([batch * t, channels])
}

/// `[n, n]`: 0 where a tick attends to itself or an earlier one, a large negative number where it would attend to a later one.
fn causal_mask(w: &Leaves, n: usize) -> Tensor<2> {
    let ahead = |i: usize| if i % n > i / n { -1e9 } else { 0.0 };
    super::graph::vector((0..n * n).map(ahead).collect(), &w.device()).reshape([n, n])
}
