//! Self-attention through the inner loops, see [`super::attention`] for its plain form.

use super::kernels::{self, Kernel, LANES};
use super::product::Product;

/// Buffers for the keys, values and scores of one head, reused between calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mixer {
    keys: Vec<f32>,
    values: Vec<f32>,
    scores: Vec<f32>,
}

impl Mixer {
    /// `qkv`: [n, 3 d]. `out`: [n, d].
    pub(crate) fn attend(
        &mut self,
        kernel: Kernel,
        qkv: &[f32],
        d: usize,
        heads: usize,
        out: &mut [f32],
    ) {
        let (n, width) = (out.len() / d, d / heads);
        let columns = n.div_ceil(LANES) * LANES;
        self.keys.resize(columns * width, 0.0);
        self.values.resize(width.div_ceil(LANES) * LANES * n, 0.0);
        self.scores.resize(n * columns, 0.0);
        let scale = 1.0 / (width as f32).sqrt();
        for head in 0..heads {
            self.pack(qkv, d, head * width, width);
            let scores = Product {
                x: &qkv[head * width..],
                stride_x: 3 * d,
                rows: n,
                inputs: width,
                w: &self.keys[..],
                outputs: n,
                bias: &[],
                y: &mut self.scores,
                stride_y: columns,
            };
            kernels::product(kernel, scores);
            kernels::softmax(kernel, &mut self.scores, columns, n, scale);
            let mixed = Product {
                x: &self.scores,
                stride_x: columns,
                rows: n,
                inputs: n,
                w: &self.values[..],
                outputs: width,
                bias: &[],
                y: &mut out[head * width..],
                stride_y: d,
            };
            kernels::product(kernel, mixed);
        }
    }

    /// Packs the keys and values of a head as weights: keys as outputs, values as inputs.
    fn pack(&mut self, qkv: &[f32], d: usize, from: usize, width: usize) {
        let n = qkv.len() / (3 * d);
        for (token, row) in qkv.chunks_exact(3 * d).enumerate() {
            let key = &row[d + from..][..width];
            let value = &row[2 * d + from..][..width];
            let first = token / LANES * LANES * width + token % LANES;
            for (k, v) in key.iter().enumerate() {
                self.keys[first + k * LANES] = *v;
            }
            for (panel, part) in value.chunks(LANES).enumerate() {
                self.values[(panel * n + token) * LANES..][..part.len()].copy_from_slice(part);
            }
        }
    }
}
