//! Adam (Kingma and Ba, 2015) over plain arrays; the norm of the whole gradient is clipped. State: both moments and the number of
//! steps, so that a resumed training gives the same numbers as one that was never stopped.

use super::parameters::Parameters;
use twin_core::elementary::{cos, powi};

const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;
/// Keeps the division finite. A larger value would change the training.
const EPSILON: f64 = 1e-8;

/// The state of the optimiser.
#[derive(Clone, Debug, PartialEq)]
pub struct Adam {
    /// First moment: running mean of the gradient.
    pub first: Parameters,
    /// Second moment: running mean of its square.
    pub second: Parameters,
    /// Steps done.
    pub steps: u64,
}

impl Adam {
    /// The state before the first step.
    pub fn new(parameters: &Parameters) -> Self {
        Self { first: parameters.zeros_like(), second: parameters.zeros_like(), steps: 0 }
    }

    /// Makes one step along `gradients` (in the order of `parameters`), with their norm clipped to `clip`. Returns the norm before
    /// clipping.
    pub fn step(
        &mut self,
        parameters: &mut Parameters,
        gradients: &[Vec<f32>],
        learning_rate: f64,
        clip: f64,
    ) -> f64 {
        let squares = gradients.iter().flatten().map(|g| f64::from(*g) * f64::from(*g));
        let norm = squares.sum::<f64>().sqrt();
        let scale = if norm > clip { clip / norm } else { 1.0 } as f32;
        self.steps += 1;
        let power = i32::try_from(self.steps).unwrap_or(i32::MAX);
        let rate = (learning_rate / (1.0 - powi(BETA_1, power))) as f32;
        let correction = (1.0 / (1.0 - powi(BETA_2, power)).sqrt()) as f32;
        let (b1, b2, epsilon) = (BETA_1 as f32, BETA_2 as f32, EPSILON as f32);
        let moments = self.first.0.iter_mut().zip(&mut self.second.0);
        for ((parameter, (m, v)), gradient) in parameters.0.iter_mut().zip(moments).zip(gradients) {
            let values = parameter.values.iter_mut().zip(&mut m.values).zip(&mut v.values);
            for (((w, m), v), g) in values.zip(gradient) {
                let g = g * scale;
                *m = b1 * *m + (1.0 - b1) * g;
                *v = b2 * *v + (1.0 - b2) * g * g;
                *w -= rate * *m / (v.sqrt() * correction + epsilon);
            }
        }
        norm
    }
}

/// Learning rate at `progress` epochs of `epochs`: it rises linearly to `largest` over `warm_up` epochs, then falls by half a
/// cosine to a hundredth.
pub fn learning_rate(largest: f64, warm_up: f64, epochs: f64, progress: f64) -> f64 {
    if progress < warm_up {
        return largest * (progress / warm_up).max(1e-3);
    }
    let part = ((progress - warm_up) / (epochs - warm_up).max(1e-9)).min(1.0);
    largest * (0.01 + 0.99 * 0.5 * (1.0 + cos(std::f64::consts::PI * part)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::parameters::Parameter;

    fn one(value: f32) -> Parameters {
        Parameters(vec![Parameter { name: "w".to_owned(), shape: vec![1], values: vec![value] }])
    }

    #[test]
    fn the_first_step_is_the_learning_rate_whatever_the_gradient() {
        // m / (1 - b1) = g and sqrt(v / (1 - b2)) = |g|, so w moves by the learning rate times the sign of g.
        for g in [3.0_f32, -0.01] {
            let mut w = one(1.0);
            Adam::new(&w).step(&mut w, &[vec![g]], 0.1, 1e9);
            let wanted = 1.0 - 0.1 * g.signum();
            // Rounding of f32 for numbers near 1, and epsilon beside |g|.
            assert!((w.0[0].values[0] - wanted).abs() < 1e-5, "{}", w.0[0].values[0]);
        }
    }

    #[test]
    fn it_finds_the_minimum_of_a_parabola_and_clips_its_gradient() {
        let mut w = one(5.0);
        let mut adam = Adam::new(&w);
        let mut norms = Vec::new();
        for _ in 0..2000 {
            let g = 2.0 * (w.0[0].values[0] - 2.0);
            norms.push(adam.step(&mut w, &[vec![g]], 0.01, 1.0));
        }
        assert!((norms[0] - 6.0).abs() < 1e-6, "the norm before clipping: {}", norms[0]);
        // Adam with a constant rate stays within about that rate of the minimum.
        assert!((w.0[0].values[0] - 2.0).abs() < 0.01, "{}", w.0[0].values[0]);
    }

    #[test]
    fn the_rate_rises_then_falls_to_a_hundredth() {
        let at = |progress| learning_rate(1.0, 1.0, 11.0, progress);
        assert!(at(0.25) < at(0.5) && (at(1.0) - 1.0).abs() < 1e-12);
        // In the middle of the half cosine the rate is the mean of 1 and 0.01.
        assert!((at(6.0) - 0.505).abs() < 1e-12 && (at(11.0) - 0.01).abs() < 1e-12);
    }
}
