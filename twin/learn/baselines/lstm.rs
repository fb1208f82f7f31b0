//! LSTM over the last ticks. Hochreiter and Schmidhuber, Long Short-Term Memory, Neural Computation 9(8), 1997; with the forget
//! gate of Gers, Schmidhuber and Cummins, 2000. Its last hidden state is the regime that the adapter corrects on.

use burn_tensor::Tensor;
use burn_tensor::activation::sigmoid;

use super::{head, readout, ticks};
use crate::learn::graph::{Leaves, Network, Output};
use crate::residual::learned::{Sizes, lstm};

/// The network.
pub(super) struct Lstm(pub(super) Sizes);

impl Network for Lstm {
    fn name(&self) -> &'static str {
        lstm::NAME
    }

    fn config(&self) -> serde_json::Value {
        head(&self.0)
    }

    fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        lstm::tensors(&self.0)
    }

    fn forward(&self, w: &Leaves, x: Tensor<3>) -> Output {
        let (d, [batch, _, t]) = (self.0.d_model, x.dims());
        let inputs: Tensor<3> = w.linear("lstm.input", ticks(x)).reshape([batch, t, 4 * d]);
        let recurrent = w.matrix("lstm.hidden.weight").transpose();
        let zeros: Tensor<2> = Tensor::zeros([batch, d], &w.device());
        let (mut h, mut c) = (zeros.clone(), zeros);
        for tick in 0..t {
            let input: Tensor<2> = inputs.clone().narrow(1, tick, 1).reshape([batch, 4 * d]);
            let gates = input + h.matmul(recurrent.clone());
            let gate = |index: usize| gates.clone().narrow(1, index * d, d);
            c = sigmoid(gate(1)) * c + sigmoid(gate(0)) * gate(2).tanh();
            h = sigmoid(gate(3)) * c.clone().tanh();
        }
        Output { forecast: readout(w, &self.0, h.clone()), regime: h }
    }
}
