//! GPT-2-style decoder over time. Radford et al., Language Models are Unsupervised Multitask Learners, 2019: one token per tick,
//! learned positions, layer normalisation before attention and feed-forward and at the end, GELU. The last token is read.

use burn_tensor::Tensor;

use super::{causal_mask, readout, ticks};
use crate::learn::graph::{Leaves, Output};
use twin_core::residual::learned::Sizes;

/// Forecast and last hidden vector of `x`, `[batch, channels, t]`.
pub(super) fn forward(sizes: &Sizes, w: &Leaves, x: Tensor<3>) -> Output {
    let Sizes { d_model: d, heads, layers, .. } = *sizes;
    let [batch, _, t] = x.dims();
    let mut tokens = w.linear("embed", ticks(x)).reshape::<3, _>([batch, t, d])
        + w.matrix("positions").unsqueeze::<3>();
    let mask = causal_mask(w, t);
    for layer in 0..layers {
        let name = |part: &str| format!("layer.{layer}.{part}");
        let (norm, qkv, out) = (name("attention_norm"), name("qkv"), name("out"));
        let mixed = w.attention([&norm, &qkv, &out], heads, tokens.clone(), Some(mask.clone()));
        let sum: Tensor<2> = (tokens + mixed).reshape([batch * t, d]);
        let normed = w.norm(&name("ffn_norm"), sum.clone());
        let sum = sum + w.mlp([&name("ffn.hidden"), &name("ffn.out")], normed);
        tokens = sum.reshape([batch, t, d]);
    }
    let last = tokens.narrow(1, t - 1, 1).reshape([batch, d]);
    let regime = w.norm("final_norm", last);
    Output { forecast: readout(w, sizes, regime.clone()), regime }
}
