//! Multi-layer perceptron on the last ticks, whose last layer continues to learn in flight by gradient descent. After Sanner and
//! Slotine, Gaussian Networks for Direct Adaptive Control, IEEE TNN 3(6), 1992, with learned instead of Gaussian features.

use std::sync::Arc;

use super::super::nn::Linear;
use super::super::weights::Weights;
use super::stack::{self, Stack};
use super::{Network, Shapes, Sizes, linear};

/// Share of the error at the last tick that one step removes (normalised gradient, stable below 2).
const STEP: f32 = 0.05;

/// Name and shape of every tensor.
pub fn tensors(sizes: &Sizes) -> Shapes {
    let mut all = stack::tensors(sizes.layers, sizes);
    all.extend(linear("readout", sizes.readout(), sizes.d_model));
    all
}

/// The network.
#[derive(Clone)]
pub struct Mlp {
    hidden: Stack,
    readout: Linear,
}

impl Mlp {
    pub(super) fn new(weights: &Weights, sizes: &Sizes) -> Self {
        Self {
            hidden: Stack::load(weights, sizes.layers, sizes),
            readout: Linear::load(weights, "readout", sizes.d_model),
        }
    }
}

impl Network for Mlp {
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let hidden = self.hidden.apply(x);
        (self.readout.apply(&hidden), hidden)
    }

    /// One gradient step on the squared error at the last tick; all forecasts of a coordinate change by the same amount.
    fn learn(&mut self, hidden: &[f32], residual: &[f32]) {
        let said = self.readout.apply(hidden);
        let rate = STEP / (1.0 + hidden.iter().map(|h| h * h).sum::<f32>());
        let (inputs, outputs) = (self.readout.inputs, residual.len());
        for (at, row) in
            Arc::make_mut(&mut self.readout.weight).chunks_exact_mut(inputs).enumerate()
        {
            let error = residual[at % outputs] - said[at % outputs];
            row.iter_mut().zip(hidden).for_each(|(w, h)| *w += rate * error * h);
        }
        for (at, bias) in Arc::make_mut(&mut self.readout.bias).iter_mut().enumerate() {
            *bias += rate * (residual[at % outputs] - said[at % outputs]);
        }
    }
}
