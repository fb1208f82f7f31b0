//! Neural-Fly. O'Connell, Shi, Shi, Azizzadenesheli, Anandkumar, Yue and Chung, Neural-Fly Enables Rapid Learning for Agile Flight
//! in Strong Winds, Science Robotics 7(66), 2022: features `phi(x)` of the present tick that many flights share, and a last
//! layer that adapts in flight by a regularised Kalman filter (their equations 6 to 8 without the tracking error, in discrete
//! time).

use super::super::nn::Linear;
use super::super::weights::Weights;
use super::stack::{self, Stack};
use super::{Network, Shapes, Sizes, linear};
use crate::elementary::squared;

/// Number of hidden layers before the features.
pub const HIDDEN: usize = 3;

/// Rate at which the last layer returns to its initial weights, per tick.
const FORGETTING: f64 = 1e-3;

/// Growth of the covariance per tick, and its initial value.
const PROCESS: f64 = 1e-3;
const START: f64 = 0.1;

/// Variance of a measured z-scored residual.
const MEASUREMENT: f64 = 0.1;

/// Name and shape of every tensor.
pub fn tensors(sizes: &Sizes) -> Shapes {
    let mut all = stack::tensors(HIDDEN, sizes);
    all.extend(linear("features", sizes.d_k, sizes.d_model));
    all.extend(linear("readout", sizes.readout(), sizes.d_k));
    all
}

/// The network.
#[derive(Clone)]
pub struct NeuralFly {
    hidden: Stack,
    features: Linear,
    readout: Linear,
    /// Change of the last layer by the adaptation, `[outputs, d_k]`, z-scored.
    added: Vec<f64>,
    /// Covariance of the last layer, `[d_k, d_k]`, shared by all coordinates.
    covariance: Vec<f64>,
}

impl NeuralFly {
    pub(super) fn new(weights: &Weights, sizes: &Sizes) -> Self {
        let h = sizes.d_k;
        let diagonal = |i: usize| if i / h == i % h { START } else { 0.0 };
        Self {
            hidden: Stack::load(weights, HIDDEN, sizes),
            features: Linear::load(weights, "features", sizes.d_model),
            readout: Linear::load(weights, "readout", h),
            added: vec![0.0; sizes.outputs * h],
            covariance: (0..h * h).map(diagonal).collect(),
        }
    }

    fn outputs(&self) -> usize {
        self.added.len() / self.readout.inputs
    }

    /// Correction of each coordinate by the adaptation, z-scored, `[outputs]`.
    fn correction(&self, phi: &[f32]) -> Vec<f64> {
        let dot = |row: &[f64]| row.iter().zip(phi).map(|(a, p)| a * f64::from(*p)).sum();
        self.added.chunks_exact(phi.len()).map(dot).collect()
    }
}

impl Network for NeuralFly {
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let hidden = self.hidden.apply(x);
        let phi = self.features.apply(&hidden);
        let (mut said, added, outputs) =
            (self.readout.apply(&phi), self.correction(&phi), self.outputs());
        for (at, value) in said.iter_mut().enumerate() {
            *value += added[at % outputs] as f32;
        }
        (said, phi)
    }

    fn learn(&mut self, phi: &[f32], residual: &[f32]) {
        let h = phi.len();
        let g: Vec<f64> = phi.iter().map(|p| f64::from(*p)).collect();
        let p_g: Vec<f64> = self
            .covariance
            .chunks_exact(h)
            .map(|row| row.iter().zip(&g).map(|(p, g)| p * g).sum())
            .collect();
        let spread = MEASUREMENT + g.iter().zip(&p_g).map(|(g, p)| g * p).sum::<f64>();
        let (said, added) = (self.readout.apply(phi), self.correction(phi));
        for (row, weights) in self.added.chunks_exact_mut(h).enumerate() {
            let error = f64::from(residual[row] - said[row]) - added[row];
            for (weight, p) in weights.iter_mut().zip(&p_g) {
                *weight = (1.0 - FORGETTING) * *weight + p / spread * error;
            }
        }
        for (i, row) in self.covariance.chunks_exact_mut(h).enumerate() {
            for (j, p) in row.iter_mut().enumerate() {
                let kept = *p - p_g[i] * p_g[j] / spread;
                *p = squared(1.0 - FORGETTING) * kept + if i == j { PROCESS } else { 0.0 };
            }
        }
    }
}
