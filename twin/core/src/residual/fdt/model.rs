//! The Factorized Dynamics Transformer, equation by equation in the order of the paper.
//!
//! In: z-scored histories of the channels. Out: [`Output`], z-scored too. State: the weights, which never change.

use super::super::nn::activation::{gelu_all, softmax};
use super::super::nn::attention::self_attention;
use super::super::nn::{LayerNorm, Linear, add, mean};
use super::super::weights::{FdtConfig, Weights, WeightsError};

/// The network.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Sizes and flags.
    pub config: FdtConfig,
    pub(super) global: Vec<f32>,
    pub(super) short: Option<Short>,
    pub(super) long: Option<Long>,
    pub(super) cross_norm: LayerNorm,
    pub(super) value: Linear,
    pub(super) lift: Linear,
    pub(super) decoder_norm: LayerNorm,
    pub(super) ffn_hidden: Linear,
    pub(super) ffn_out: Linear,
    pub(super) readout_hidden: Linear,
    pub(super) readout_out: Linear,
    /// The linear path to the forecasts, if the network has one.
    pub(super) skip: Option<Linear>,
}

/// Short-horizon context stream.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Short {
    pub(super) embed: Linear,
    pub(super) identity: Vec<f32>,
    pub(super) layers: Vec<Layer>,
}

/// One layer of self-attention.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    pub(super) norm: LayerNorm,
    pub(super) qkv: Linear,
    pub(super) out: Linear,
}

/// Long-horizon memory.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Long {
    pub(super) hidden: Linear,
    pub(super) out: Linear,
    pub(super) identity: Vec<f32>,
    pub(super) query: Linear,
    pub(super) key: Linear,
}

/// Output of the network for one history.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Output {
    /// Forecast of the residual, z-scored, [k + 1, outputs].
    pub residual: Vec<f32>,
    /// Regime latent `g'`, `[d_k]`.
    pub regime: Vec<f32>,
    /// Attention of the global token over the channels, `[channels]`; it sums to one and is empty without the long memory.
    pub attention: Vec<f32>,
}

/// The last `ticks` ticks of the histories `x`, `[channels, t_long]`: `[channels, ticks]`.
pub(super) fn newest(x: &[f32], t_long: usize, ticks: usize) -> Vec<f32> {
    x.chunks_exact(t_long).flat_map(|history| &history[t_long - ticks..]).copied().collect()
}

impl Model {
    /// Builds the network from `weights`.
    ///
    /// # Errors
    /// [`WeightsError`] if the weights belong to another model, or if the configuration or a tensor is wrong.
    pub fn new(weights: &Weights) -> Result<Self, WeightsError> {
        weights.head.check_model("fdt")?;
        let config = FdtConfig::of(&weights.head)?;
        weights.check_tensors(&config.tensors())?;
        let (d, f) = (config.d_model, config.d_ff);
        let linear = |stem: &str, inputs| Linear::load(weights, stem, inputs);
        let layer = |index: usize| Layer {
            norm: LayerNorm::load(weights, &format!("short.layer.{index}.norm")),
            qkv: linear(&format!("short.layer.{index}.qkv"), d),
            out: linear(&format!("short.layer.{index}.out"), d),
        };
        Ok(Self {
            config,
            global: weights.values("short.global"),
            short: config.short_horizon.then(|| Short {
                embed: linear("short.embed", config.t_short),
                identity: weights.values("short.identity"),
                layers: (0..config.layers).map(layer).collect(),
            }),
            long: config.long_memory.then(|| Long {
                hidden: linear("long.hidden", config.t_long),
                out: linear("long.out", d),
                identity: weights.values("long.identity"),
                query: linear("cross.query", d),
                key: linear("cross.key", d),
            }),
            cross_norm: LayerNorm::load(weights, "cross.norm"),
            value: linear("cross.value", d),
            lift: linear("cross.lift", config.d_k),
            decoder_norm: LayerNorm::load(weights, "decoder.norm"),
            ffn_hidden: linear("decoder.ffn.hidden", d),
            ffn_out: linear("decoder.ffn.out", f),
            readout_hidden: linear("decoder.readout.hidden", 2 * d),
            readout_out: linear("decoder.readout.out", f),
            skip: (config.t_skip > 0).then(|| linear("skip", config.skip_inputs())),
        })
    }

    /// Forward pass of `x`: `[channels, t_long]`, z-scored, oldest first; masked channels are zero.
    ///
    /// # Panics
    /// If `x` has another length.
    pub fn forward(&self, x: &[f32]) -> Output {
        let FdtConfig { channels, t_long, d_model: d, .. } = self.config;
        assert_eq!(x.len(), channels * t_long, "one history per channel");
        let tokens = self.short.as_ref().map_or_else(Vec::new, |short| self.context(short, x));
        let channel_tokens = &tokens[..tokens.len().min(channels * d)];
        // The global token queries the memory. A model without it uses the mean of the channels' tokens.
        let asks = match (&self.short, self.config.global_token) {
            (Some(_), true) => tokens[channels * d..].to_vec(),
            (Some(_), false) => mean(channel_tokens, d),
            (None, _) => self.global.clone(),
        };
        let asks = self.cross_norm.apply(&asks);
        let (regime, attention) = match &self.long {
            Some(long) => self.recall(long, x, &asks),
            None => (self.value.apply(&asks), Vec::new()),
        };
        let encoded = [channel_tokens, &self.lift.apply(&regime)].concat();
        let mut residual = self.decode(encoded);
        if let Some(skip) = &self.skip {
            add(&mut residual, &skip.apply(&newest(x, t_long, self.config.t_skip)));
        }
        Output { residual, regime, attention }
    }

    /// Short-horizon context: the tokens of the channels, then the global token; `[channels (+ 1), d]`.
    fn context(&self, short: &Short, x: &[f32]) -> Vec<f32> {
        let FdtConfig { t_short, t_long, d_model: d, heads, .. } = self.config;
        let mut tokens = Vec::new();
        for (history, identity) in x.chunks_exact(t_long).zip(short.identity.chunks_exact(d)) {
            let mut e = short.embed.apply(&history[t_long - t_short..]);
            add(&mut e, identity);
            tokens.extend(e);
        }
        tokens.extend(&self.global);
        for layer in &short.layers {
            let qkv = layer.qkv.apply(&layer.norm.apply(&tokens));
            add(&mut tokens, &layer.out.apply(&self_attention(&qkv, d, heads)));
        }
        tokens
    }

    /// Long-horizon memory retrieval: the regime `g'`, `[d_k]`, and the attention over the channels, `[channels]`.
    fn recall(&self, long: &Long, x: &[f32], asks: &[f32]) -> (Vec<f32>, Vec<f32>) {
        let mut hidden = long.hidden.apply(x);
        gelu_all(&mut hidden);
        let mut memory = long.out.apply(&hidden);
        add(&mut memory, &long.identity);
        let d_k = self.config.d_k;
        let q = long.query.apply(asks);
        let scale = 1.0 / (d_k as f32).sqrt();
        let keys = long.key.apply(&memory);
        let mut alpha: Vec<f32> = keys
            .chunks_exact(d_k)
            .map(|k| q.iter().zip(k).map(|(q, k)| q * k).sum::<f32>() * scale)
            .collect();
        softmax(&mut alpha);
        let mut regime = vec![0.0; d_k];
        for (value, weight) in self.value.apply(&memory).chunks_exact(d_k).zip(&alpha) {
            for (g, v) in regime.iter_mut().zip(value) {
                *g += weight * v;
            }
        }
        (regime, alpha)
    }

    /// Decoder: a position-wise FFN, then the readout from the channels' mean and the last token.
    fn decode(&self, encoded: Vec<f32>) -> Vec<f32> {
        let d = self.config.d_model;
        let mut hidden = self.ffn_hidden.apply(&self.decoder_norm.apply(&encoded));
        gelu_all(&mut hidden);
        let mut y = encoded;
        add(&mut y, &self.ffn_out.apply(&hidden));
        let (channels, last) = y.split_at(y.len() - d);
        let mut hidden = self.readout_hidden.apply(&[&mean(channels, d), last].concat());
        gelu_all(&mut hidden);
        self.readout_out.apply(&hidden)
    }
}
