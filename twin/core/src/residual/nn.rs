//! Building blocks of the networks, f32, row-major: a sequence of `n` vectors of width `d` is a slice of `n * d` numbers.
//!
//! In: slices and weights. Out: new slices. No state. These blocks follow their formulas literally; the kernels are faster.

mod product;
mod norm;
mod elementwise;
pub mod kernels;
pub(super) mod packed;
mod linear;
pub mod activation;
pub mod attention;
pub(super) mod mixer;

pub use linear::Linear;
pub use norm::LayerNorm;
pub use packed::Precision;

/// `a += b`, element by element.
pub fn add(a: &mut [f32], b: &[f32]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += b;
    }
}

/// `max(x, 0)` on each number.
pub fn relu_all(x: &mut [f32]) {
    for v in x {
        *v = v.max(0.0);
    }
}

/// The mean of the vectors of width `d` in `x`; zeros if there are none.
pub fn mean(x: &[f32], d: usize) -> Vec<f32> {
    let mut sum = vec![0.0; d];
    x.chunks_exact(d).for_each(|row| add(&mut sum, row));
    let n = (x.len() / d).max(1) as f32;
    for v in &mut sum {
        *v /= n;
    }
    sum
}
