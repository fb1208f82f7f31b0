//! Causal Transformer over time. Vaswani et al., Attention Is All You Need, Advances in Neural Information Processing Systems 30,
//! 2017. It has one token per tick, sinusoidal positions, layer normalisation after each sum, and rectified feed-forward layers.
//! The last token is the regime, and the readout uses it.

use super::super::nn::activation::softmax;
use super::super::nn::{LayerNorm, Linear, add, relu_all};
use super::super::weights::Weights;
use super::{Network, Shapes, Sizes, by_tick, linear, norm};
use crate::elementary::{cos, powf, sin};

/// Longest wavelength of the positions divided by 2 pi, ticks.
const LONGEST: f64 = 10_000.0;

/// Name and shape of every tensor.
pub fn tensors(sizes: &Sizes) -> Shapes {
    let mut all = linear("embed", sizes.d_model, sizes.channels);
    all.extend((0..sizes.layers).flat_map(|layer| block_tensors(layer, sizes)));
    all.extend(linear("readout", sizes.readout(), sizes.d_model));
    all
}

/// Tensors of one layer.
pub(super) fn block_tensors(layer: usize, sizes: &Sizes) -> Shapes {
    let (d, f) = (sizes.d_model, sizes.d_ff);
    let name = |part: &str| format!("layer.{layer}.{part}");
    let mut all = vec![(name("qkv.weight"), vec![3 * d, d])];
    all.extend(linear(&name("out"), d, d));
    all.extend(norm(&name("attention_norm"), d));
    all.extend(linear(&name("ffn.hidden"), f, d));
    all.extend(linear(&name("ffn.out"), d, f));
    all.extend(norm(&name("ffn_norm"), d));
    all
}

/// Sinusoidal positions `[t, d]`: sine at even, cosine at odd indices.
pub fn positions(t: usize, d: usize) -> Vec<f32> {
    let one = |i: usize| {
        let (tick, k) = (i / d, i % d);
        let angle = tick as f64 / powf(LONGEST, (k - k % 2) as f64 / d as f64);
        (if k.is_multiple_of(2) { sin(angle) } else { cos(angle) }) as f32
    };
    (0..t * d).map(one).collect()
}

/// The maps of one layer.
#[derive(Clone)]
pub(super) struct Block {
    pub(super) qkv: Linear,
    pub(super) out: Linear,
    pub(super) attention_norm: LayerNorm,
    pub(super) ffn_hidden: Linear,
    pub(super) ffn_out: Linear,
    pub(super) ffn_norm: LayerNorm,
}

impl Block {
    pub(super) fn load(weights: &Weights, layer: usize, sizes: &Sizes) -> Self {
        let name = |part: &str| format!("layer.{layer}.{part}");
        let (d, f) = (sizes.d_model, sizes.d_ff);
        Self {
            qkv: Linear::load(weights, &name("qkv"), d),
            out: Linear::load(weights, &name("out"), d),
            attention_norm: LayerNorm::load(weights, &name("attention_norm")),
            ffn_hidden: Linear::load(weights, &name("ffn.hidden"), d),
            ffn_out: Linear::load(weights, &name("ffn.out"), f),
            ffn_norm: LayerNorm::load(weights, &name("ffn_norm")),
        }
    }

    /// Causal self-attention of the tokens `[n, d]` (each to itself and to earlier tokens) with the output map: `[n, d]`.
    pub(super) fn attend(&self, tokens: &[f32], heads: usize) -> Vec<f32> {
        let (d, qkv) = (self.qkv.inputs, self.qkv.apply(tokens));
        let (n, width) = (tokens.len() / d, d / heads);
        let scale = 1.0 / (width as f32).sqrt();
        let part = |token: usize, which: usize, head: usize| {
            &qkv[token * 3 * d + which * d + head * width..][..width]
        };
        let mut mixed = vec![0.0; n * d];
        for (head, token) in (0..heads).flat_map(|head| (0..n).map(move |token| (head, token))) {
            let q = part(token, 0, head);
            let dot = |k: &[f32]| q.iter().zip(k).map(|(q, k)| q * k).sum::<f32>() * scale;
            let mut alpha: Vec<f32> = (0..=token).map(|other| dot(part(other, 1, head))).collect();
            softmax(&mut alpha);
            let o = &mut mixed[token * d + head * width..][..width];
            for (other, weight) in alpha.iter().enumerate() {
                o.iter_mut().zip(part(other, 2, head)).for_each(|(o, v)| *o += weight * v);
            }
        }
        self.out.apply(&mixed)
    }
}

/// The network.
#[derive(Clone)]
pub struct Transformer {
    embed: Linear,
    positions: Vec<f32>,
    blocks: Vec<Block>,
    readout: Linear,
    sizes: Sizes,
}

impl Transformer {
    pub(super) fn new(weights: &Weights, sizes: &Sizes) -> Self {
        Self {
            embed: Linear::load(weights, "embed", sizes.channels),
            positions: positions(sizes.t_long, sizes.d_model),
            blocks: (0..sizes.layers).map(|layer| Block::load(weights, layer, sizes)).collect(),
            readout: Linear::load(weights, "readout", sizes.d_model),
            sizes: *sizes,
        }
    }
}

impl Network for Transformer {
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let mut tokens = self.embed.apply(&by_tick(x, self.sizes.t_long));
        add(&mut tokens, &self.positions);
        for block in &self.blocks {
            let mixed = block.attend(&tokens, self.sizes.heads);
            add(&mut tokens, &mixed);
            let mut sum = block.attention_norm.apply(&tokens);
            let mut hidden = block.ffn_hidden.apply(&sum);
            relu_all(&mut hidden);
            add(&mut sum, &block.ffn_out.apply(&hidden));
            tokens = block.ffn_norm.apply(&sum);
        }
        let last = tokens.split_off(tokens.len() - self.sizes.d_model);
        (self.readout.apply(&last), last)
    }
}
