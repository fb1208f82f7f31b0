//! The product of rows and packed weights, written once; [`super::kernels`] compiles it for each instruction set.
//!
//! In: f32 rows, weights in panels of [`LANES`] outputs. Out: f32 rows. No state.
#![allow(
    clippy::inline_always,
    reason = "a loop left uninlined is not compiled for the instruction set"
)]
#![allow(clippy::needless_range_loop, reason = "indices name rows and lanes of registers")]

use super::kernels::{LANES, Lanes};

/// The operands of `Y = X W^T + b`.
pub(crate) struct Product<'a, W> {
    /// Rows of `x`, `stride_x` apart; the first `inputs` numbers of each row are used.
    pub x: &'a [f32],
    pub stride_x: usize,
    pub rows: usize,
    pub inputs: usize,
    /// Panels of `LANES` outputs, each [inputs, LANES].
    pub w: &'a [W],
    pub outputs: usize,
    /// Bias, [outputs]; empty if there is none.
    pub bias: &'a [f32],
    /// Rows of the result, `stride_y` apart.
    pub y: &'a mut [f32],
    pub stride_y: usize,
}

#[inline(always)]
pub(super) fn product_body<V: Lanes, W: Weight>(p: Product<'_, W>) {
    let Product { x, stride_x, rows, inputs, w, outputs, bias, y, stride_y } = p;
    let all = w.as_chunks::<LANES>().0;
    for (panel, w) in all.chunks_exact(inputs).enumerate() {
        let first = panel * LANES;
        let width = LANES.min(outputs - first);
        let mut start = [0.0; LANES];
        if !bias.is_empty() {
            start[..width].copy_from_slice(&bias[first..first + width]);
        }
        // Wide panels come from memory. While the second block of rows reads this panel from the cache, the next panel is
        // fetched.
        let next = all.chunks_exact(inputs).nth(panel + 1).unwrap_or(w);
        let mut row = 0;
        while row < rows {
            let block = V::ROWS.min(rows - row);
            let x = &x[row * stride_x..];
            let y = &mut y[row * stride_y + first..];
            let at = Tile {
                x,
                stride_x,
                inputs,
                width,
                stride_y,
                start: &start,
                w,
                ahead: if row == V::ROWS { next } else { w },
            };
            match block {
                13 => tile::<13, 1, V, W>(&at, y),
                12 => tile::<12, 1, V, W>(&at, y),
                11 => tile::<11, 1, V, W>(&at, y),
                10 => tile::<10, 1, V, W>(&at, y),
                9 => tile::<9, 1, V, W>(&at, y),
                8 => tile::<8, 1, V, W>(&at, y),
                7 => tile::<7, 1, V, W>(&at, y),
                6 => tile::<6, 1, V, W>(&at, y),
                5 => tile::<5, 1, V, W>(&at, y),
                4 => tile::<4, 1, V, W>(&at, y),
                3 => tile::<3, 1, V, W>(&at, y),
                2 => tile::<2, 2, V, W>(&at, y),
                _ => tile::<1, 4, V, W>(&at, y),
            }
            row += block;
        }
    }
}

/// Position of a tile in a product.
struct Tile<'a, W> {
    x: &'a [f32],
    stride_x: usize,
    inputs: usize,
    width: usize,
    stride_y: usize,
    start: &'a [f32; LANES],
    w: &'a [[W; LANES]],
    /// Memory to prefetch meanwhile, as long as `w`.
    ahead: &'a [[W; LANES]],
}

/// A tile of `ROWS` rows and one panel, with the sums in registers. With few rows each number has `WAYS` partial sums, so that an
/// addition does not wait for the one before.
#[inline(always)]
fn tile<const ROWS: usize, const WAYS: usize, V: Lanes, W: Weight>(
    at: &Tile<'_, W>,
    y: &mut [f32],
) {
    let xs: [&[f32]; ROWS] = std::array::from_fn(|row| &at.x[row * at.stride_x..][..at.inputs]);
    let (w, ahead) = (&at.w[..at.inputs], &at.ahead[..at.inputs]);
    let mut sums = [[V::splat(0.0); WAYS]; ROWS];
    let whole = at.inputs / WAYS * WAYS;
    let mut k = 0;
    while k < whole {
        for way in 0..WAYS {
            V::fetch(&ahead[k + way]);
            let weights = W::lanes::<V>(&w[k + way]);
            for row in 0..ROWS {
                sums[row][way] = V::splat(xs[row][k + way]).times(weights, sums[row][way]);
            }
        }
        k += WAYS;
    }
    for row in 0..ROWS {
        let mut total = V::load(at.start);
        for way in 0..WAYS {
            total = total.plus(sums[row][way]);
        }
        for k in whole..at.inputs {
            total = V::splat(xs[row][k]).times(W::lanes::<V>(&w[k]), total);
        }
        let total = total.store();
        y[row * at.stride_y..][..at.width].copy_from_slice(&total[..at.width]);
    }
}

/// Weights of a panel: f32, or bf16 (the upper half of an f32).
pub(crate) trait Weight: Copy {
    fn lanes<V: Lanes>(weights: &[Self; LANES]) -> V;
}

impl Weight for f32 {
    #[inline(always)]
    fn lanes<V: Lanes>(weights: &[Self; LANES]) -> V {
        V::load(weights)
    }
}

impl Weight for u16 {
    #[inline(always)]
    fn lanes<V: Lanes>(weights: &[Self; LANES]) -> V {
        V::widen(weights)
    }
}

/// The registers for every processor, as the compiler chooses them.
#[derive(Clone, Copy)]
pub(super) struct Plain([f32; LANES]);

impl Lanes for Plain {
    const FUSED: bool = false;
    const ROWS: usize = 2;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn load(values: &[f32; LANES]) -> Self {
        Self(*values)
    }

    #[inline(always)]
    fn widen(values: &[u16; LANES]) -> Self {
        Self(values.map(|value| f32::from_bits(u32::from(value) << 16)))
    }

    #[inline(always)]
    fn times(self, factor: Self, sum: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane] * factor.0[lane] + sum.0[lane]))
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane] + other.0[lane]))
    }

    #[inline(always)]
    fn store(self) -> [f32; LANES] {
        self.0
    }
}
