//! Activations.

use crate::elementary::{erf, exp};
use std::f32::consts::FRAC_1_SQRT_2;

/// `x Phi(x)` with the normal distribution `Phi`: the exact form by the error function, not the `tanh` approximation.
pub fn gelu(x: f32) -> f32 {
    0.5 * x * (1.0 + erf(x * FRAC_1_SQRT_2))
}

/// [`gelu`] on each number.
pub fn gelu_all(x: &mut [f32]) {
    for v in x {
        *v = gelu(*v);
    }
}

/// Softmax `exp(x_i) / sum_j exp(x_j)` in place, shifted by the largest value so that nothing overflows.
pub fn softmax(x: &mut [f32]) {
    let most = x.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut sum = 0.0;
    for v in x.iter_mut() {
        *v = exp(*v - most);
        sum += *v;
    }
    for v in x {
        *v /= sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gelu_has_its_known_values() {
        // Values of x Phi(x) from tables of the normal distribution.
        for (x, wanted) in
            [(0.0, 0.0), (1.0, 0.841_344_7), (-1.0, -0.158_655_25), (3.0, 2.995_950_2)]
        {
            // Rounding error of a few operations on numbers up to 3.
            assert!((gelu(x) - wanted).abs() < 1e-6, "gelu({x}) = {}", gelu(x));
        }
    }

    #[test]
    fn softmax_of_huge_scores_is_finite_and_sums_to_one() {
        let mut x = [1e30, 1e30, -1e30, 0.0];
        softmax(&mut x);
        assert_eq!(x.map(f32::to_bits), [0.5_f32, 0.5, 0.0, 0.0].map(f32::to_bits));
    }
}
