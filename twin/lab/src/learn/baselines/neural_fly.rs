//! Neural-Fly's DAIML. O'Connell, Shi, Shi, Azizzadenesheli, Anandkumar, Yue and Chung, Neural-Fly Enables Rapid Learning for
//! Agile Flight in Strong Winds, Science Robotics 7(66), 2022, algorithm 1.
//!
//! The features `phi(x)` depend on the present tick. For each flight ("domain") of a batch, the last layer `a*` is the ridge least
//! squares solution on one half of the windows, and its loss is taken on the other half; the gradient passes through the solution.
//! A discriminator guesses the flight from `phi`, and `phi` is trained against it. The spectral norm of every layer is at most
//! [`SPECTRAL_NORM`]. `readout` is trained together with them on fixed `phi`; in flight the last layer starts from it.

use burn_tensor::Tensor;
use burn_tensor::activation::{log_softmax, relu};

use super::{head, readout};
use crate::learn::graph::{Inputs, Leaves, Network, Output, mean_square, vector};
use crate::learn::parameters::Parameters;
use twin_core::residual::learned::{Sizes, neural_fly};

/// Largest spectral norm of a layer (2 in the paper).
const SPECTRAL_NORM: f64 = 2.0;

/// Weight of the adversarial term (0.1 in the paper).
const ADVERSARIAL: f64 = 0.1;

/// Ridge of the least squares solution, for each window.
const RIDGE: f64 = 1e-2;

/// Steps of the power iteration.
const POWER_STEPS: usize = 8;

/// Hidden width of the discriminator.
const DISCRIMINATOR: usize = 64;

/// The network.
pub(super) struct NeuralFly {
    pub(super) sizes: Sizes,
    pub(super) flights: usize,
}

/// `phi`, `[batch, d_k]`.
fn features(w: &Leaves, x: Tensor<3>) -> Tensor<2> {
    let [batch, channels, t] = x.dims();
    let mut hidden: Tensor<2> = x.reshape([batch, channels * t]);
    for layer in 0..neural_fly::HIDDEN {
        hidden = relu(w.linear(&format!("hidden.{layer}"), hidden));
    }
    w.linear("features", hidden)
}

impl NeuralFly {
    /// Mean squared error of one flight: `a*` is solved on the first half of its windows, and the error is taken on the second.
    fn adapted_loss(&self, phi: &Tensor<2>, y: &Tensor<2>, rows: &[usize]) -> Option<Tensor<1>> {
        let (fit, judge) = rows.split_at(rows.len() / 2);
        if fit.is_empty() || judge.is_empty() {
            return None;
        }
        let device = phi.device();
        let take = |from: &Tensor<2>, rows: &[usize]| -> Tensor<2> {
            // A matrix of ones and zeros picks the windows; its gradient is exact, and it is cheap at this size.
            let n = from.dims()[0];
            let mut pick = vec![0.0; rows.len() * n];
            for (at, row) in rows.iter().enumerate() {
                pick[at * n + row] = 1.0;
            }
            vector(pick, &device).reshape([rows.len(), n]).matmul(from.clone())
        };
        let (phi_fit, y_fit) = (take(phi, fit), take(y, fit));
        let h = self.sizes.d_k;
        let mut identity = vec![0.0; h * h];
        (0..h).for_each(|i| identity[i * h + i] = (RIDGE * fit.len() as f64) as f32);
        let gram = phi_fit.clone().transpose().matmul(phi_fit.clone())
            + vector(identity, &device).reshape::<2, _>([h, h]);
        let a = solve(gram, phi_fit.transpose().matmul(y_fit));
        let error = take(phi, judge).matmul(a) - take(y, judge);
        Some(error.square().mean())
    }

    /// Cross entropy of the discriminator's guess of the flight.
    fn guess_loss(&self, w: &Leaves, phi: Tensor<2>, flights: &[usize]) -> Tensor<1> {
        let guessed = w.linear("guess.out", relu(w.linear("guess.hidden", phi)));
        let mut truth = vec![0.0; flights.len() * self.flights];
        for (at, flight) in flights.iter().enumerate() {
            truth[at * self.flights + flight] = 1.0;
        }
        let truth: Tensor<2> = vector(truth, &w.device()).reshape([flights.len(), self.flights]);
        (log_softmax(guessed, 1) * truth).sum().neg() / flights.len() as f64
    }
}

/// `A^-1 B` for a symmetric positive definite `A` `[h, h]`, by elimination without pivots, which such a matrix does not need.
fn solve(a: Tensor<2>, b: Tensor<2>) -> Tensor<2> {
    let (h, columns) = (a.dims()[0], b.dims()[1]);
    let mut rows = Tensor::cat(vec![a, b], 1);
    for pivot in 0..h {
        let row = rows.clone().narrow(0, pivot, 1);
        let row = row.clone() / row.narrow(1, pivot, 1);
        let cleared = rows.clone() - rows.clone().narrow(1, pivot, 1).matmul(row.clone());
        let mut parts = Vec::new();
        if pivot > 0 {
            parts.push(cleared.clone().narrow(0, 0, pivot));
        }
        parts.push(row);
        if pivot + 1 < h {
            parts.push(cleared.narrow(0, pivot + 1, h - pivot - 1));
        }
        rows = Tensor::cat(parts, 0);
    }
    rows.narrow(1, h, columns)
}

impl Network for NeuralFly {
    fn config(&self) -> serde_json::Value {
        head(&self.sizes)
    }

    fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        neural_fly::tensors(&self.sizes)
    }

    fn helpers(&self) -> Vec<(String, Vec<usize>)> {
        let shape = |name: &str, shape: &[usize]| (name.to_owned(), shape.to_vec());
        vec![
            shape("guess.hidden.weight", &[DISCRIMINATOR, self.sizes.d_k]),
            shape("guess.hidden.bias", &[DISCRIMINATOR]),
            shape("guess.out.weight", &[self.flights, DISCRIMINATOR]),
            shape("guess.out.bias", &[self.flights]),
        ]
    }

    fn forward(&self, w: &Leaves, x: Tensor<3>) -> Output {
        let regime = features(w, x);
        Output { forecast: readout(w, &self.sizes, regime.clone()), regime }
    }

    fn loss(&self, w: &Leaves, inputs: Inputs) -> Tensor<1> {
        let Inputs { x, y, flights, .. } = inputs;
        let phi = features(w, x);
        let [batch, steps, outputs] = y.dims();
        let flat: Tensor<2> = y.clone().reshape([batch, steps * outputs]);
        let rows = |flight: usize| -> Vec<usize> {
            (0..batch).filter(|row| flights[*row] == flight).collect()
        };
        let adapted: Vec<Tensor<1>> = (0..self.flights)
            .filter_map(|flight| self.adapted_loss(&phi, &flat, &rows(flight)))
            .collect();
        // The last layer of the file and the discriminator learn from fixed features.
        let still = phi.clone().detach();
        let start = mean_square(readout(w, &self.sizes, still.clone()) - y);
        let guess = self.guess_loss(w, still, &flights);
        let fool = self.guess_loss(&w.detached("guess."), phi, &flights) * ADVERSARIAL;
        let count = adapted.len().max(1) as f64;
        let adapted = adapted.into_iter().reduce(|a, b| a + b);
        let all = start + guess - fool;
        match adapted {
            Some(adapted) => adapted / count + all,
            None => all,
        }
    }

    fn constrain(&self, parameters: &mut Parameters) {
        for parameter in &mut parameters.0 {
            let of_features =
                ["hidden.", "features."].iter().any(|s| parameter.name.starts_with(s));
            if let (true, [_, inputs]) = (of_features, parameter.shape.as_slice()) {
                let largest = spectral_norm(&parameter.values, *inputs);
                if largest > SPECTRAL_NORM {
                    let scale = (SPECTRAL_NORM / largest) as f32;
                    parameter.values.iter_mut().for_each(|v| *v *= scale);
                }
            }
        }
    }
}

/// Largest singular value of `[out, inputs]` by power iteration from the sum of its rows.
fn spectral_norm(values: &[f32], inputs: usize) -> f64 {
    let mut v: Vec<f64> = (0..inputs).map(|i| 1.0 + 0.1 * (i % 7) as f64).collect();
    let mut norm = 0.0;
    for _ in 0..POWER_STEPS {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-30);
        let mut next = vec![0.0; inputs];
        let mut square = 0.0;
        for row in values.chunks_exact(inputs) {
            let u: f64 = row.iter().zip(&v).map(|(w, x)| f64::from(*w) * x / length).sum();
            square += u * u;
            next.iter_mut().zip(row).for_each(|(n, w)| *n += u * f64::from(*w));
        }
        norm = square.sqrt();
        v = next;
    }
    norm
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::device::device;
    use crate::learn::graph::{exclusive, values};

    #[test]
    fn the_solution_of_a_known_system_is_known() {
        let _one_thread = exclusive();
        // A = [[4, 1], [1, 3]], x = [1, 2]: A x = [6, 7].
        let a = vector(vec![4.0, 1.0, 1.0, 3.0], &device(false)).reshape([2, 2]);
        let b = vector(vec![6.0, 7.0], &device(false)).reshape([2, 1]);
        let x = values(solve(a, b));
        // The error is a few roundings of f32, for numbers below 10.
        assert!((x[0] - 1.0).abs() < 1e-5 && (x[1] - 2.0).abs() < 1e-5, "{x:?}");
    }

    #[test]
    fn the_largest_singular_value_of_a_diagonal_is_its_largest_entry() {
        // The ratio of the singular values is 3, so eight steps leave 3^-16 of the initial error.
        let found = spectral_norm(&[3.0, 0.0, 0.0, -1.0], 2);
        assert!((found - 3.0).abs() < 1e-6, "{found}");
    }
}
