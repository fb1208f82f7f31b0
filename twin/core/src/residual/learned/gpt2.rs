//! GPT-2-style decoder over time. Radford et al., Language Models are Unsupervised Multitask Learners, 2019. It has one token per
//! tick, learned positions, GELU, and layer normalisation before attention, before the feed-forward part and at the end. The last
//! token is the regime, and the readout uses it.

use super::super::nn::activation::gelu_all;
use super::super::nn::{LayerNorm, Linear, add};
use super::super::weights::Weights;
use super::transformer::{Block, block_tensors};
use super::{Network, Shapes, Sizes, by_tick, linear, norm};

/// Name and shape of every tensor.
pub fn tensors(sizes: &Sizes) -> Shapes {
    let mut all = linear("embed", sizes.d_model, sizes.channels);
    all.push(("positions".to_owned(), vec![sizes.t_long, sizes.d_model]));
    all.extend((0..sizes.layers).flat_map(|layer| block_tensors(layer, sizes)));
    all.extend(norm("final_norm", sizes.d_model));
    all.extend(linear("readout", sizes.readout(), sizes.d_model));
    all
}

/// The network.
#[derive(Clone)]
pub struct Gpt2 {
    embed: Linear,
    positions: Vec<f32>,
    blocks: Vec<Block>,
    final_norm: LayerNorm,
    readout: Linear,
    sizes: Sizes,
}

impl Gpt2 {
    pub(super) fn new(weights: &Weights, sizes: &Sizes) -> Self {
        Self {
            embed: Linear::load(weights, "embed", sizes.channels),
            positions: weights.values("positions"),
            blocks: (0..sizes.layers).map(|layer| Block::load(weights, layer, sizes)).collect(),
            final_norm: LayerNorm::load(weights, "final_norm"),
            readout: Linear::load(weights, "readout", sizes.d_model),
            sizes: *sizes,
        }
    }
}

impl Network for Gpt2 {
    fn forward(&self, x: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let mut tokens = self.embed.apply(&by_tick(x, self.sizes.t_long));
        add(&mut tokens, &self.positions);
        for block in &self.blocks {
            let mixed = block.attend(&block.attention_norm.apply(&tokens), self.sizes.heads);
            add(&mut tokens, &mixed);
            let mut hidden = block.ffn_hidden.apply(&block.ffn_norm.apply(&tokens));
            gelu_all(&mut hidden);
            add(&mut tokens, &block.ffn_out.apply(&hidden));
        }
        let last = self.final_norm.apply(&tokens[tokens.len() - self.sizes.d_model..]);
        (self.readout.apply(&last), last)
    }
}
