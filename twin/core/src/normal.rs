//! Draws from the normal distribution that have the same bits on every platform.
//!
//! `rand_distr` takes the exponential function and the logarithm from the system as soon as any crate of a build asks
//! `num-traits` for its feature `std`, and nalgebra does. This module uses the same method with the functions of
//! [`elementary`](crate::elementary). Its draws equal those of `rand_distr`, except for the last digit of a rare draw.
//!
//! In: a generator. Out: f64 or f32. No state except a table that is computed once.
//!
//! Source: Doornik, An Improved Ziggurat Method to Generate Normal Random Samples, 2005 (ZIGNOR).

use std::sync::LazyLock;

use rand::distr::{Distribution, Open01};
use rand::{Rng, RngExt};

use crate::elementary::{exp, ln, squared};

/// Layers of equal area under the bell curve.
const LAYERS: usize = 256;

/// Start of the tail: the right edge of the lowest layer's rectangle.
const TAIL: f64 = 3.654_152_885_361_009;

/// Area of a layer, with the digits from which `rand_distr` computed its table.
const AREA: f64 = 0.004_928_673_233_99;

/// Right edges of the layers, from the lowest to the top, which is zero. The width of the lowest is its area (tail included) over
/// its height.
static EDGES: LazyLock<[f64; LAYERS + 1]> = LazyLock::new(|| {
    let mut edges = [0.0; LAYERS + 1];
    edges[0] = AREA / density(TAIL);
    edges[1] = TAIL;
    for i in 2..LAYERS {
        let below = edges[i - 1];
        edges[i] = (-2.0 * ln(density(below) + AREA / below)).sqrt();
    }
    edges
});

/// The normal distribution of mean 0 and standard deviation 1.
#[derive(Clone, Copy, Debug)]
pub struct StandardNormal;

impl Distribution<f64> for StandardNormal {
    fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        let edges = &*EDGES;
        loop {
            let bits = rng.next_u64();
            let layer = (bits % LAYERS as u64) as usize;
            let side = two_to_four(bits) - 3.0;
            let x = side * edges[layer];
            if x.abs() < edges[layer + 1] {
                return x;
            }
            if layer == 0 {
                return tail(rng).copysign(side);
            }
            let (low, high) = (density(edges[layer]), density(edges[layer + 1]));
            if high + (low - high) * rng.random::<f64>() < density(x) {
                return x;
            }
        }
    }
}

impl Distribution<f32> for StandardNormal {
    fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f32 {
        let x: f64 = self.sample(rng);
        x as f32
    }
}

/// The bell curve, scaled to one at its top.
fn density(x: f64) -> f64 {
    exp(-0.5 * squared(x))
}

/// A number in [2, 4) whose fraction is the upper 52 bits of `bits`.
fn two_to_four(bits: u64) -> f64 {
    f64::from_bits(2.0_f64.to_bits() | (bits >> 12))
}

/// A draw beyond [`TAIL`]. Source: Marsaglia, Generating a Variable from the Tail of the Normal Distribution, 1964.
fn tail<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    loop {
        let beyond = -ln(rng.sample::<f64, _>(Open01)) / TAIL;
        let chance = -ln(rng.sample::<f64, _>(Open01));
        if 2.0 * chance >= squared(beyond) {
            return TAIL + beyond;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64;

    #[test]
    fn draws_are_those_of_rand_distr() {
        // Logarithms of two libraries differ by one unit in the last place, and a draw of the tail adds one logarithm to TAIL.
        const TOLERANCE: f64 = 4.0 * f64::EPSILON;
        let (mut ours, mut theirs) = (Pcg64::seed_from_u64(7), Pcg64::seed_from_u64(7));
        let mut beyond = 0;
        for _ in 0..200_000 {
            let x: f64 = StandardNormal.sample(&mut ours);
            let y: f64 = rand_distr::StandardNormal.sample(&mut theirs);
            assert!((x - y).abs() <= TOLERANCE, "{x} {y}");
            beyond += u32::from(x.abs() > TAIL);
        }
        // 52 of them (2.6e-4) are expected beyond TAIL.
        assert!(beyond > 20, "the tail was drawn {beyond} times");
    }
}
