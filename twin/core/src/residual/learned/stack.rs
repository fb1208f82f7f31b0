//! A stack of rectified layers, `hidden.0`, `hidden.1`, …; the first layer sees the whole history.

use super::super::nn::{Linear, relu_all};
use super::super::weights::Weights;
use super::{Shapes, Sizes, linear};

/// The layers.
#[derive(Clone)]
pub(super) struct Stack(Vec<Linear>);

fn inputs(layer: usize, sizes: &Sizes) -> usize {
    if layer == 0 { sizes.channels * sizes.t_long } else { sizes.d_model }
}

fn stem(layer: usize) -> String {
    format!("hidden.{layer}")
}

/// Name and shape of every tensor of a stack of `layers` layers.
pub(super) fn tensors(layers: usize, sizes: &Sizes) -> Shapes {
    let one = |layer| linear(&stem(layer), sizes.d_model, inputs(layer, sizes));
    (0..layers).flat_map(one).collect()
}

impl Stack {
    /// Loads a stack of `layers` layers from `weights`.
    pub(super) fn load(weights: &Weights, layers: usize, sizes: &Sizes) -> Self {
        let one = |layer| Linear::load(weights, &stem(layer), inputs(layer, sizes));
        Self((0..layers).map(one).collect())
    }

    /// Output of the last layer, `[d_model]`, for a history `x`, `[channels, t_long]`.
    pub(super) fn apply(&self, x: &[f32]) -> Vec<f32> {
        let mut hidden = x.to_vec();
        for layer in &self.0 {
            hidden = layer.apply(&hidden);
            relu_all(&mut hidden);
        }
        hidden
    }
}
