//! LSTM over the last ticks. Hochreiter and Schmidhuber, Long Short-Term Memory, Neural Computation 9(8), 1997; with the forget
//! gate of Gers, Schmidhuber and Cummins, 2000. The last hidden state is the regime.

use super::super::nn::Linear;
use super::super::weights::Weights;
use super::{Network, Shapes, Sizes, by_tick, linear};
use crate::elementary::{exp, tanh};

/// Name and shape of every tensor; the order of the gates is input, forget, cell, output.
pub fn tensors(sizes: &Sizes) -> Shapes {
    let Sizes { channels, d_model: d, .. } = *sizes;
    let mut all = linear("lstm.input", 4 * d, channels);
    all.push(("lstm.hidden.weight".to_owned(), vec![4 * d, d]));
    all.extend(linear("readout", sizes.readout(), d));
    all
}

/// The network.
#[derive(Clone)]
pub struct Lstm {
    input: Linear,
    hidden: Linear,
    readout: Linear,
    t_long: usize,
}

impl Lstm {
    pub(super) fn new(weights: &Weights, sizes: &Sizes) -> Self {
        Self {
            input: Linear::load(weights, "lstm.input", sizes.channels),
            hidden: Linear::load(weights, "lstm.hidden", sizes.d_model),
            readout: Linear::load(weights, "readout", sizes.d_model),
            t_long: sizes.t_long,
        }
    }
}

fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

impl Network for Lstm {
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let d = self.hidden.inputs;
        let (mut h, mut c) = (vec![0.0; d], vec![0.0; d]);
        for input in self.input.apply(&by_tick(x, self.t_long)).chunks_exact(4 * d) {
            let recurrent = self.hidden.apply(&h);
            let gate = |index: usize, i: usize| input[index * d + i] + recurrent[index * d + i];
            for i in 0..d {
                c[i] = sigmoid(gate(1, i)) * c[i] + sigmoid(gate(0, i)) * tanh(gate(2, i));
                h[i] = sigmoid(gate(3, i)) * tanh(c[i]);
            }
        }
        (self.readout.apply(&h), h)
    }
}
