//! Products of weights that do not depend on the input. They are computed once in double precision to shorten the forward pass;
//! all are exact.
//!
//! - **First layer**: with `C` the subtraction of the mean, `LN(W_e z + p) = diag(w) C (W_e z + p) / s + b`, so
//!   `W_qkv LN = (A z + B) / s + c` with `A = W_qkv diag(w) C W_e`, `B = W_qkv diag(w) C p`, `c = W_qkv b`.
//! - **Memory**: with one query, `q . W_K (H u + p) = (H^T W_K^T q) . u + q . W_K p`, and
//!   `sum alpha W_V (H u + p) = W_V H (sum alpha u) + sum alpha W_V p`. The memory of a channel is therefore never computed.

use super::super::nn::LayerNorm;
use super::model::{Long, Model, Short};

/// The products `A`, `B` (per token) and `c` of the first layer.
pub(super) struct FirstLayer {
    /// `A`, `[3 d, t_short]`.
    pub(super) window: Vec<f32>,
    /// `B`, [tokens, 3 d].
    pub(super) constant: Vec<f32>,
    /// `c`, [3 d].
    pub(super) offset: Vec<f32>,
}

impl FirstLayer {
    /// Folds the first layer of `short`. `constant_tokens` are the `p` of every channel token and of the global token, [tokens,
    /// d].
    pub(super) fn new(short: &Short, constant_tokens: &[f32]) -> Self {
        let layer = &short.layers[0];
        let d = layer.norm.weight.len();
        let t_short = short.embed.inputs;
        let qkv = &layer.qkv.weight;
        // Columns of W_e as rows, each centred and scaled.
        let columns: Vec<f32> = (0..t_short)
            .flat_map(|t| (0..d).map(move |i| (i, t)))
            .map(|(i, t)| short.embed.weight[i * t_short + t])
            .collect();
        let by_time = times(&centred(&columns, &layer.norm), qkv, d);
        let window = transposed(&by_time, 3 * d);
        Self {
            window,
            constant: times(&centred(constant_tokens, &layer.norm), qkv, d)
                .iter()
                .map(|v| *v as f32)
                .collect(),
            offset: times(&doubles(&layer.norm.bias), qkv, d).iter().map(|v| *v as f32).collect(),
        }
    }
}

/// The products of the folded memory.
pub(super) struct Memory {
    /// `H^T W_K^T`, [d, d_k].
    pub(super) key: Vec<f32>,
    /// `W_K p`, [channels, d_k].
    pub(super) key_identity: Vec<f32>,
    /// `W_V H`, [d_k, d].
    pub(super) value: Vec<f32>,
    /// `W_V p`, [channels, d_k].
    pub(super) value_identity: Vec<f32>,
}

impl Memory {
    /// Folds the long memory of `model`.
    pub(super) fn new(model: &Model, long: &Long) -> Self {
        let d = model.config.d_model;
        let d_k = model.config.d_k;
        // Rows of H^T: a row times W is a column of W H.
        let h = doubles(&transposed(&doubles(&long.out.weight), d));
        let by_column = |w: &[f32]| times(&h, w, d);
        let identity = |w: &[f32]| -> Vec<f32> {
            times(&doubles(&long.identity), w, d).iter().map(|v| *v as f32).collect()
        };
        Self {
            key: by_column(&long.key.weight).iter().map(|v| *v as f32).collect(),
            key_identity: identity(&long.key.weight),
            value: transposed(&by_column(&model.value.weight), d_k),
            value_identity: identity(&model.value.weight),
        }
    }
}

fn doubles(x: &[f32]) -> Vec<f64> {
    x.iter().map(|v| f64::from(*v)).collect()
}

/// Each row of `x` ([n, d]) minus its mean, times the scale of `norm`.
fn centred(x: &[f32], norm: &LayerNorm) -> Vec<f64> {
    let d = norm.weight.len();
    x.chunks_exact(d)
        .flat_map(|row| {
            let mean = row.iter().map(|v| f64::from(*v)).sum::<f64>() / d as f64;
            row.iter().zip(&norm.weight).map(move |(v, w)| (f64::from(*v) - mean) * f64::from(*w))
        })
        .collect()
}

/// `x W^T`, x [n, d], W [m, d]. Result: [n, m].
fn times(x: &[f64], w: &[f32], d: usize) -> Vec<f64> {
    let w = doubles(w);
    let mut out = Vec::with_capacity(x.len() / d * (w.len() / d));
    for row in x.chunks_exact(d) {
        out.extend(w.chunks_exact(d).map(|w| dot(row, w)));
    }
    out
}

/// Computes eight sums in parallel, because these products dominate the loading of large weights.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum::<f64>()
}

/// Transposes `x` from [n, m] to [m, n].
fn transposed(x: &[f64], m: usize) -> Vec<f32> {
    (0..m).flat_map(|column| x.iter().skip(column).step_by(m)).map(|v| *v as f32).collect()
}
