//! Scaled dot-product attention among the vectors of one sequence.

use super::activation::softmax;

/// Multi-head self-attention without the output map.
///
/// `qkv`: [n, 3 d], per vector the query, the key and the value; head `i` uses the `i`-th slice of width `d / heads` of each.
/// Result: [n, d], the heads' values side by side, `softmax(Q K^T / sqrt(d / heads)) V`.
pub fn self_attention(qkv: &[f32], d: usize, heads: usize) -> Vec<f32> {
    let n = qkv.len() / (3 * d);
    let width = d / heads;
    let scale = 1.0 / (width as f32).sqrt();
    let part = |token: usize, which: usize, head: usize| {
        let from = token * 3 * d + which * d + head * width;
        &qkv[from..from + width]
    };
    let mut out = vec![0.0; n * d];
    let mut scores = vec![0.0; n];
    for head in 0..heads {
        for token in 0..n {
            let q = part(token, 0, head);
            for (other, score) in scores.iter_mut().enumerate() {
                let k = part(other, 1, head);
                *score = q.iter().zip(k).map(|(q, k)| q * k).sum::<f32>() * scale;
            }
            softmax(&mut scores);
            let o = &mut out[token * d + head * width..][..width];
            for (other, weight) in scores.iter().enumerate() {
                for (o, v) in o.iter_mut().zip(part(other, 2, head)) {
                    *o += weight * v;
                }
            }
        }
    }
    out
}
