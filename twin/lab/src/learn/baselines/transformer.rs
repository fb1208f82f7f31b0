//! Causal Transformer over time. Vaswani et al., Attention Is All You Need, Advances in Neural Information Processing Systems
//! 30, 2017: one token per tick, sinusoidal positions, layer normalisation after each sum, `ReLU`. The last token is read.

use burn_tensor::Tensor;
use burn_tensor::activation::relu;

use super::{causal_mask, readout, ticks};
use crate::learn::graph::{Leaves, Output, vector};
use twin_core::residual::learned::{Sizes, transformer};

/// Forecast and last hidden vector of `x`, `[batch, channels, t]`.
pub(super) fn forward(sizes: &Sizes, w: &Leaves, x: Tensor<3>) -> Output {
    let Sizes { d_model: d, heads, layers, .. } = *sizes;
    let [batch, _, t] = x.dims();
    let positions: Tensor<3> = vector(transformer::positions(t, d), &w.device()).reshape([1, t, d]);
    let mut tokens = w.linear("embed", ticks(x)).reshape::<3, _>([batch, t, d]) + positions;
    let mask = causal_mask(w, t);
    for layer in 0..layers {
        let name = |part: &str| format!("layer.{layer}.{part}");
        let (qkv, out) = (name("qkv"), name("out"));
        let mixed = w.attend([&qkv, &out], heads, tokens.clone(), Some(mask.clone()));
        let sum: Tensor<2> = (tokens + mixed).reshape([batch * t, d]);
        let sum = w.norm(&name("attention_norm"), sum);
        let hidden = relu(w.linear(&name("ffn.hidden"), sum.clone()));
        let sum = sum + w.linear(&name("ffn.out"), hidden);
        tokens = w.norm(&name("ffn_norm"), sum).reshape([batch, t, d]);
    }
    let regime: Tensor<2> = tokens.narrow(1, t - 1, 1).reshape([batch, d]);
    Output { forecast: readout(w, sizes, regime.clone()), regime }
}
