//! Weights packed for the inner loops: panels of [`LANES`] outputs, with one input after the other.

use std::sync::Arc;

use super::kernels::{self, Kernel, LANES};
use super::product::Product;

/// A linear map `y = W x + b`, packed. Copies share the numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Packed {
    panels: Panels,
    bias: Arc<[f32]>,
    inputs: usize,
    outputs: usize,
}

/// Storage format of a weight; sums are f32 in both cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// f32, as trained.
    #[default]
    F32,
    /// bf16, the upper half of an f32: half the memory, and a relative error of at most 0.4 %.
    Bf16,
}

#[derive(Clone, Debug, PartialEq)]
enum Panels {
    F32(Arc<[f32]>),
    Bf16(Arc<[u16]>),
}

impl Packed {
    /// `weight`: [outputs, inputs]; `bias`: [outputs] or empty.
    pub(crate) fn new(weight: &[f32], bias: &[f32], inputs: usize, precision: Precision) -> Self {
        let outputs = weight.len() / inputs;
        let mut panels = vec![0.0; outputs.div_ceil(LANES) * LANES * inputs];
        for (output, row) in weight.chunks_exact(inputs).enumerate() {
            let first = output / LANES * LANES * inputs + output % LANES;
            for (input, w) in row.iter().enumerate() {
                panels[first + input * LANES] = *w;
            }
        }
        let panels = match precision {
            Precision::F32 => Panels::F32(panels.into()),
            Precision::Bf16 => Panels::Bf16(panels.into_iter().map(bf16).collect()),
        };
        Self { panels, bias: bias.into(), inputs, outputs }
    }

    /// `x`: rows `stride_x` apart, of which the first `inputs` numbers are used. `y`: [rows, outputs], which gives the number of
    /// rows.
    pub(crate) fn apply(&self, kernel: Kernel, x: &[f32], stride_x: usize, y: &mut [f32]) {
        let (inputs, outputs) = (self.inputs, self.outputs);
        let (rows, bias, stride_y) = (y.len() / outputs, &self.bias[..], outputs);
        match &self.panels {
            Panels::F32(w) => kernels::product(
                kernel,
                Product { x, stride_x, rows, inputs, w, outputs, bias, y, stride_y },
            ),
            Panels::Bf16(w) => kernels::product(
                kernel,
                Product { x, stride_x, rows, inputs, w, outputs, bias, y, stride_y },
            ),
        }
    }

    /// Applies the map to contiguous rows.
    pub(crate) fn rows(&self, kernel: Kernel, x: &[f32], y: &mut [f32]) {
        self.apply(kernel, x, self.inputs, y);
    }
}

/// The nearest bf16, ties to even. A finite weight becomes infinite only within 0.4 % of the largest f32.
fn bf16(value: f32) -> u16 {
    let bits = value.to_bits();
    let odd = (bits >> 16) & 1;
    (bits.wrapping_add(0x7fff + odd) >> 16) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::sin;

    fn numbers(n: usize, seed: f32) -> Vec<f32> {
        (0..n).map(|i| sin(i as f32 * 0.7 + seed)).collect()
    }

    #[test]
    fn a_packed_product_is_the_plain_one_for_any_size_and_kernel() {
        for kernel in Kernel::available() {
            for (rows, inputs, outputs) in [
                (1, 1, 1),
                (1, 7, 17),
                (2, 9, 16),
                (3, 33, 31),
                (5, 64, 48),
                (14, 5, 3),
                (25, 40, 50),
                (31, 13, 20),
            ] {
                let (w, b) = (numbers(outputs * inputs, 1.0), numbers(outputs, 2.0));
                let x = numbers(rows * (inputs + 3), 3.0);
                let mut found = vec![f32::NAN; rows * outputs];
                let packed = Packed::new(&w, &b, inputs, Precision::F32);
                packed.apply(kernel, &x, inputs + 3, &mut found);
                for (row, found) in found.chunks_exact(outputs).enumerate() {
                    for (output, found) in found.iter().enumerate() {
                        let wanted: f64 = (0..inputs)
                            .map(|k| {
                                f64::from(w[output * inputs + k])
                                    * f64::from(x[row * (inputs + 3) + k])
                            })
                            .sum::<f64>()
                            + f64::from(b[output]);
                        // Up to 64 products of numbers up to one, in single precision.
                        assert!(
                            (f64::from(*found) - wanted).abs() < 1e-5,
                            "{kernel:?} {rows}x{inputs}x{outputs}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn bf16_is_the_nearest_number_with_eight_binary_digits() {
        let wide = |v: u16| f32::from_bits(u32::from(v) << 16);
        for value in [0.0, 1.0, -1.5, 0.1, 3.25, -1e-30, 65_504.0] {
            let rounded = wide(bf16(value));
            assert!((rounded - value).abs() <= value.abs() / 256.0, "{value} became {rounded}");
        }
        assert_eq!(bf16(f32::from_bits(0x3f80_8000)), 0x3f80, "a tie goes to even");
        assert_eq!(bf16(f32::from_bits(0x3f81_8000)), 0x3f82, "a tie goes to even");
    }
}
