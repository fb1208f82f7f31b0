//! Multi-layer perceptron on the last ticks. Its last layer continues to learn in flight, by the gradient. After Sanner and Slotine,
//! Gaussian Networks for Direct Adaptive Control, IEEE TNN 3(6), 1992, with learned instead of Gaussian features.

use burn_tensor::Tensor;
use burn_tensor::activation::relu;

use super::readout;
use crate::learn::graph::{Leaves, Output};
use twin_core::residual::learned::Sizes;

/// Forecast and last hidden vector of `x`, `[batch, channels, t]`.
pub(super) fn forward(sizes: &Sizes, w: &Leaves, x: Tensor<3>) -> Output {
    let [batch, channels, t] = x.dims();
    let mut hidden: Tensor<2> = x.reshape([batch, channels * t]);
    for layer in 0..sizes.layers {
        hidden = relu(w.linear(&format!("hidden.{layer}"), hidden));
    }
    Output { forecast: readout(w, sizes, hidden.clone()), regime: hidden }
}
