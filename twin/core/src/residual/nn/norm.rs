//! Layer normalisation.

use super::super::weights::Weights;
use crate::elementary::squared;

/// Added to the variance, so that the result for a constant vector stays finite.
pub(super) const EPSILON: f32 = 1e-5;

/// `(x - mean) / sqrt(var + eps) * weight + bias` on each vector of a sequence; mean and variance are over the numbers of the
/// vector.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerNorm {
    /// Scale, `[d]`.
    pub weight: Vec<f32>,
    /// Offset, `[d]`.
    pub bias: Vec<f32>,
}

impl LayerNorm {
    /// Loads the tensors `{stem}.weight` and `{stem}.bias`.
    pub fn load(weights: &Weights, stem: &str) -> Self {
        Self {
            weight: weights.values(&format!("{stem}.weight")),
            bias: weights.values(&format!("{stem}.bias")),
        }
    }

    /// `x`: [n, d]. Result: [n, d].
    pub fn apply(&self, x: &[f32]) -> Vec<f32> {
        let d = self.weight.len();
        let mut y = Vec::with_capacity(x.len());
        for row in x.chunks_exact(d) {
            let mean = row.iter().sum::<f32>() / d as f32;
            let variance = row.iter().map(|v| squared(v - mean)).sum::<f32>() / d as f32;
            let scale = 1.0 / (variance + EPSILON).sqrt();
            let scaled = row.iter().zip(&self.weight).zip(&self.bias);
            y.extend(scaled.map(|((v, w), b)| (v - mean) * scale * w + b));
        }
        y
    }
}
