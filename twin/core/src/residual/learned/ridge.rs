//! Ridge regression on the last ticks: one linear map from the history to every forecast. Hoerl and Kennard, Ridge Regression: Biased
//! Estimation for Nonorthogonal Problems, Technometrics 12(1), 1970.
//!
//! Every network must beat this line of best fit. It has no hidden vector, so its regime is empty and the adapter learns nothing.

use super::super::nn::Linear;
use super::super::weights::Weights;
use super::{Network, Shapes, Sizes, linear};

/// Name and shape of every tensor.
pub fn tensors(sizes: &Sizes) -> Shapes {
    linear("readout", sizes.readout(), sizes.channels * sizes.t_long)
}

/// The linear map.
#[derive(Clone)]
pub struct Ridge {
    readout: Linear,
}

impl Ridge {
    pub(super) fn new(weights: &Weights, sizes: &Sizes) -> Self {
        Self { readout: Linear::load(weights, "readout", sizes.channels * sizes.t_long) }
    }
}

impl Network for Ridge {
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        (self.readout.apply(x), Vec::new())
    }
}
