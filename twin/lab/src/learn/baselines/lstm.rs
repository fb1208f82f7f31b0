//! LSTM over the last ticks. Hochreiter and Schmidhuber, Long Short-Term Memory, Neural Computation 9(8), 1997; with the forget
//! gate of Gers, Schmidhuber and Cummins, 2000. Its last hidden state is the regime that the adapter uses.

use burn_tensor::Tensor;
use burn_tensor::activation::sigmoid;

use super::{readout, ticks};
use crate::learn::graph::{Leaves, Output};
use twin_core::residual::learned::Sizes;

/// Forecast and last hidden vector of `x`, `[batch, channels, t]`.
pub(super) fn forward(sizes: &Sizes, w: &Leaves, x: Tensor<3>) -> Output {
    let (d, [batch, _, t]) = (sizes.d_model, x.dims());
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
    Output { forecast: readout(w, sizes, h.clone()), regime: h }
}
