//! The elementwise and row-wise loops of the networks, written once; [`super::kernels`] compiles them for each instruction set.
//!
//! In: f32 rows. Out: f32 rows. No state.
#![allow(
    clippy::inline_always,
    reason = "a loop left uninlined is not compiled for the instruction set"
)]
#![allow(clippy::needless_range_loop, reason = "indices name lanes of registers")]

use super::kernels::{LANES, Lanes};

#[inline(always)]
fn fused<V: Lanes>(a: f32, b: f32, c: f32) -> f32 {
    // Without the instruction, `mul_add` calls the C library.
    if V::FUSED { a.mul_add(b, c) } else { a * b + c }
}

#[inline(always)]
pub(super) fn gelu_body<V: Lanes>(x: &mut [f32]) {
    let (chunks, rest) = x.as_chunks_mut::<LANES>();
    for chunk in chunks {
        for v in chunk.iter_mut() {
            *v = gelu_one::<V>(*v);
        }
    }
    for v in rest {
        *v = gelu_one::<V>(*v);
    }
}

#[inline(always)]
fn gelu_one<V: Lanes>(x: f32) -> f32 {
    0.5 * x * (1.0 + erf::<V>(x * std::f32::consts::FRAC_1_SQRT_2))
}

/// The error function as an odd rational function, with an error of at most 4e-7. Beyond 4 it equals one in single precision.
/// Source: the coefficients XLA and Eigen use for single precision.
#[inline(always)]
fn erf<V: Lanes>(x: f32) -> f32 {
    const P: [f32; 7] = [
        -2.726_142_3e-10,
        2.770_681_4e-8,
        -2.101_024e-6,
        -5.692_506_4e-5,
        -7.349_906_3e-4,
        -2.954_598e-3,
        -1.609_603_3e-2,
    ];
    const Q: [f32; 5] =
        [-1.456_607_2e-5, -2.133_740_5e-4, -1.682_827e-3, -7.373_329e-3, -1.426_474e-2];
    let x = x.clamp(-4.0, 4.0);
    let squared = x * x;
    x * polynomial::<V, 7>(&P, squared) / polynomial::<V, 5>(&Q, squared)
}

/// `exp(x)` for `x <= 0`: `2^n` times a polynomial of the rest, with a relative error of at most 2e-7.
/// Source: the coefficients of the Cephes library's `expf`.
#[inline(always)]
fn exp<V: Lanes>(x: f32) -> f32 {
    const P: [f32; 6] =
        [1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 0.166_666_65, 0.5];
    // ln 2 in two parts. The first has few digits, so that the rest is exact.
    const LN2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
    // Adding this number drops the digits behind the point.
    const ROUNDS: f32 = 12_582_912.0;
    let x = x.max(-87.0);
    let shifted = fused::<V>(x, std::f32::consts::LOG2_E, ROUNDS);
    let n = shifted - ROUNDS;
    let rest = fused::<V>(n, -LN2[1], fused::<V>(n, -LN2[0], x));
    let value = fused::<V>(polynomial::<V, 6>(&P, rest), rest * rest, rest + 1.0);
    let power = shifted.to_bits().wrapping_sub(ROUNDS.to_bits()).wrapping_add(127) << 23;
    value * f32::from_bits(power)
}

/// Horner's rule, highest power first.
#[inline(always)]
fn polynomial<V: Lanes, const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    let mut value = coefficients[0];
    for c in &coefficients[1..] {
        value = fused::<V>(value, x, *c);
    }
    value
}

#[inline(always)]
pub(super) fn softmax_body<V: Lanes>(x: &mut [f32], stride: usize, n: usize, scale: f32) {
    for row in x.chunks_mut(stride) {
        let row = &mut row[..n];
        let most = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        for v in row.iter_mut() {
            *v = exp::<V>((*v - most) * scale);
        }
        let sum: f32 = row.iter().sum();
        let share = sum.recip();
        for v in row.iter_mut() {
            *v *= share;
        }
    }
}

#[inline(always)]
pub(super) fn norm_body<V: Lanes>(x: &[f32], weight: &[f32], bias: &[f32], y: &mut [f32]) {
    let d = weight.len();
    for (x, y) in x.chunks_exact(d).zip(y.chunks_exact_mut(d)) {
        let (mean, scale) = moments(x);
        for (((y, x), w), b) in y.iter_mut().zip(x).zip(weight).zip(bias) {
            *y = fused::<V>((x - mean) * scale, *w, *b);
        }
    }
}

#[inline(always)]
pub(super) fn spread_body<V: Lanes>(x: &[f32], out: &mut [f32; 1]) {
    out[0] = moments(x).1;
}

#[inline(always)]
pub(super) fn dot_body<V: Lanes>(a: &[f32], b: &[f32], out: &mut [f32; 1]) {
    let mut sums = [0.0; LANES];
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] = fused::<V>(a[lane], b[lane], sums[lane]);
        }
    }
    let rest: f32 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    out[0] = sums.iter().sum::<f32>() + rest;
}

/// Mean and reciprocal standard deviation, as layer normalisation defines them.
#[inline(always)]
fn moments(x: &[f32]) -> (f32, f32) {
    let mean = total(x, |v| v) / x.len() as f32;
    let variance = total(x, |v| (v - mean) * (v - mean)) / x.len() as f32;
    (mean, 1.0 / (variance + super::norm::EPSILON).sqrt())
}

/// Sum of `f` over the numbers, computed as `LANES` parallel sums.
#[inline(always)]
fn total(x: &[f32], f: impl Fn(f32) -> f32) -> f32 {
    let mut sums = [0.0; LANES];
    let (chunks, rest) = x.as_chunks::<LANES>();
    for chunk in chunks {
        for lane in 0..LANES {
            sums[lane] += f(chunk[lane]);
        }
    }
    sums.iter().sum::<f32>() + rest.iter().map(|v| f(*v)).sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::super::activation;
    use super::super::kernels::{Kernel, gelu, softmax};
    use crate::elementary::sin;

    /// Largest error of both approximations of the error function, times half of 4.
    const GELU_TOLERANCE: f32 = 2e-6;

    #[test]
    fn every_kernel_of_this_processor_has_its_own_name_and_the_first_is_scalar() {
        let names: Vec<_> = Kernel::available().into_iter().map(Kernel::name).collect();
        assert_eq!(names[0], "scalar");
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
        assert_eq!(Kernel::named("abacus"), None);
        assert_eq!(Kernel::named("scalar"), Some(Kernel::SCALAR));
    }

    #[test]
    fn gelu_is_the_exact_one_everywhere() {
        for kernel in Kernel::available() {
            let mut x: Vec<f32> = (-3000..=3000).map(|i| i as f32 * 3e-3).collect();
            let wanted: Vec<f32> = x.iter().map(|x| activation::gelu(*x)).collect();
            gelu(kernel, &mut x);
            for (found, wanted) in x.iter().zip(&wanted) {
                assert!((found - wanted).abs() < GELU_TOLERANCE, "{kernel:?}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn softmax_is_the_plain_one_for_any_spread_of_scores() {
        for kernel in Kernel::available() {
            for (n, spread) in [(1, 1.0), (5, 0.1), (16, 3.0), (25, 40.0), (33, 1e4)] {
                let mut wanted: Vec<f32> = (0..n).map(|i| sin(i as f32 * 1.7) * spread).collect();
                let mut found = wanted.clone();
                for v in &mut wanted {
                    *v *= 0.25;
                }
                activation::softmax(&mut wanted);
                softmax(kernel, &mut found, n, n, 0.25);
                for (found, wanted) in found.iter().zip(&wanted) {
                    // Numbers up to one; the exponential has a relative error of 2e-7, and the scores add their rounding times
                    // their size.
                    let tolerance = 1e-6 + 1e-7 * spread * wanted;
                    assert!((found - wanted).abs() < tolerance, "{kernel:?}: {found} {wanted}");
                }
            }
        }
    }
}
