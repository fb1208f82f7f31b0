//! Linear map with optional bias.

use std::sync::Arc;

use super::super::weights::Weights;

/// `y = W x + b` on each vector of a sequence. Copies share the numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// `W`, [outputs, inputs].
    pub weight: Arc<[f32]>,
    /// `b`, `[outputs]`; empty if there is none.
    pub bias: Arc<[f32]>,
    /// Width of an input.
    pub inputs: usize,
}

impl Linear {
    /// Loads the tensors `{stem}.weight` and, if it exists, `{stem}.bias`; `inputs` is at least 1.
    pub fn load(weights: &Weights, stem: &str, inputs: usize) -> Self {
        Self {
            weight: weights.values(&format!("{stem}.weight")).into(),
            bias: weights.values(&format!("{stem}.bias")).into(),
            inputs,
        }
    }

    /// Width of an output.
    pub fn outputs(&self) -> usize {
        self.weight.len() / self.inputs
    }

    /// `x`: [n, inputs]. Result: [n, outputs].
    pub fn apply(&self, x: &[f32]) -> Vec<f32> {
        let mut y = Vec::with_capacity(x.len() / self.inputs * self.outputs());
        for row in x.chunks_exact(self.inputs) {
            for (output, w) in self.weight.chunks_exact(self.inputs).enumerate() {
                let dot: f32 = w.iter().zip(row).map(|(w, x)| w * x).sum();
                y.push(dot + self.bias.get(output).copied().unwrap_or(0.0));
            }
        }
        y
    }
}
