//! Multi-layer perceptron on the last ticks whose last layer goes on learning in flight by gradient. After Sanner and Slotine,
//! Gaussian Networks for Direct Adaptive Control, IEEE TNN 3(6), 1992, with learned instead of Gaussian features.

use burn_tensor::Tensor;
use burn_tensor::activation::relu;

use super::{head, readout};
use crate::learn::graph::{Leaves, Network, Output};
use crate::residual::learned::{Sizes, mlp};

/// The network.
pub(super) struct Mlp(pub(super) Sizes);

impl Network for Mlp {
    fn name(&self) -> &'static str {
        mlp::NAME
    }

    fn config(&self) -> serde_json::Value {
        head(&self.0)
    }

    fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        mlp::tensors(&self.0)
    }

    fn forward(&self, w: &Leaves, x: Tensor<3>) -> Output {
        let [batch, channels, t] = x.dims();
        let mut hidden: Tensor<2> = x.reshape([batch, channels * t]);
        for layer in 0..self.0.layers {
            hidden = relu(w.linear(&format!("hidden.{layer}"), hidden));
        }
        Output { forecast: readout(w, &self.0, hidden.clone()), regime: hidden }
    }
}
