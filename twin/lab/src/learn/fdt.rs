//! Factorized Dynamics Transformer for training: the equations of `residual::fdt`, with the two folds that do not change its result.
//!
//! First, the position-wise network is pooled before its second matrix, because the readout uses only the mean over the channels and
//! the last token. Second, one query asks the memory, so the keys and values of 24 channels are never formed:
//! `q . W_K (H_2 u + p) = (H_2^T W_K^T q) . u + (W_K^T q) . p`, and the values are summed before `W_V H_2`.

use burn_tensor::Tensor;
use burn_tensor::activation::{gelu, softmax};

use super::LearnError;
use super::config::TrainConfig;
use super::graph::{Leaves, Network, Output};
use super::line::Line;
use super::parameters::Parameters;
use super::windows::Windows;
use twin_core::residual::weights::FdtConfig;

/// The network.
pub struct Fdt {
    /// Sizes and flags.
    pub config: FdtConfig,
}

impl Fdt {
    /// A network with the sizes in `config`, for `channels` input channels and `outputs` coordinates of the residual.
    pub fn new(config: &TrainConfig, channels: usize, outputs: usize) -> Self {
        let config = FdtConfig {
            channels,
            outputs,
            t_short: config.t_short,
            t_long: config.t_long,
            d_model: config.d_model,
            heads: config.heads,
            d_ff: config.d_ff,
            d_k: config.d_k,
            layers: config.layers,
            horizon: config.horizon,
            global_token: config.global_token,
            short_horizon: config.short_horizon,
            long_memory: config.long_memory,
            t_skip: config.ticks_of_skip(),
        };
        Self { config }
    }

    /// Short-horizon context, `[batch, channels (+ 1), d]`: the tokens of the channels, then the global token.
    fn context(&self, w: &Leaves, x: Tensor<3>) -> Tensor<3> {
        let FdtConfig { t_short, t_long, d_model: d, heads, .. } = self.config;
        let [batch, channels, _] = x.dims();
        let z = x.narrow(2, t_long - t_short, t_short).reshape([batch * channels, t_short]);
        let e: Tensor<3> = w.linear("short.embed", z).reshape([batch, channels, d]);
        let mut tokens = e + w.matrix("short.identity").unsqueeze::<3>();
        if self.config.global_token {
            let global = w.vector("short.global").reshape([1, 1, d]).repeat_dim(0, batch);
            tokens = Tensor::cat(vec![tokens, global], 1);
        }
        for layer in 0..self.config.layers {
            let name = |part: &str| format!("short.layer.{layer}.{part}");
            let (norm, qkv, out) = (name("norm"), name("qkv"), name("out"));
            tokens = tokens.clone() + w.attention([&norm, &qkv, &out], heads, tokens, None);
        }
        tokens
    }

    /// Long-horizon memory retrieval: `g'`, `[batch, d_k]`, for the queries `asks`, `[batch, d]`.
    fn recall(&self, w: &Leaves, x: Tensor<3>, asks: Tensor<2>) -> Tensor<2> {
        let FdtConfig { t_long, d_model: d, d_k, .. } = self.config;
        let [batch, channels, _] = x.dims();
        let u = gelu(w.linear("long.hidden", x.reshape([batch * channels, t_long])));
        let u: Tensor<3> = u.reshape([batch, channels, d]);
        let identity = w.matrix("long.identity");
        let out = w.matrix("long.out.weight");
        let per_memory = w.linear("cross.query", asks).matmul(w.matrix("cross.key.weight"));
        let per_hidden: Tensor<3> = per_memory.clone().matmul(out.clone()).reshape([batch, d, 1]);
        let scores: Tensor<2> = u.clone().matmul(per_hidden).reshape::<2, _>([batch, channels])
            + per_memory.matmul(identity.clone().transpose());
        let alpha: Tensor<2> = softmax(scores / (d_k as f32).sqrt(), 1);
        let hidden: Tensor<2> =
            alpha.clone().reshape([batch, 1, channels]).matmul(u).reshape([batch, d]);
        let memory = hidden.matmul(out.transpose()) + alpha.matmul(identity);
        w.linear("cross.value", memory)
    }

    /// The linear path from the last ticks of `x` to the forecasts, `[batch, horizon + 1, outputs]`, if the network has one.
    fn skip(&self, w: &Leaves, x: Tensor<3>) -> Option<Tensor<3>> {
        let FdtConfig { t_skip, t_long, horizon, outputs, .. } = self.config;
        if t_skip == 0 {
            return None;
        }
        let batch = x.dims()[0];
        let window = x.narrow(2, t_long - t_skip, t_skip);
        let line = w.linear("skip", window.reshape([batch, self.config.skip_inputs()]));
        Some(line.reshape([batch, horizon + 1, outputs]))
    }

    /// Decoder on the tokens of the channels, `[batch, channels, d]`, and the lifted regime, `[batch, d]`.
    fn decode(&self, w: &Leaves, tokens: Option<Tensor<3>>, lifted: &Tensor<2>) -> Tensor<3> {
        let FdtConfig { d_model: d, d_ff, horizon, outputs, .. } = self.config;
        let [batch, _] = lifted.dims();
        let hidden = |x: Tensor<2>| gelu(w.linear("decoder.ffn.hidden", w.norm("decoder.norm", x)));
        let out = |x: Tensor<2>| w.linear("decoder.ffn.out", x);
        let last = lifted.clone() + out(hidden(lifted.clone()));
        let mean: Tensor<2> = match tokens {
            Some(tokens) => {
                let channels = tokens.dims()[1];
                let pooled: Tensor<3> = hidden(tokens.clone().reshape([batch * channels, d]))
                    .reshape([batch, channels, d_ff])
                    .mean_dim(1);
                tokens.mean_dim(1).reshape::<2, _>([batch, d]) + out(pooled.reshape([batch, d_ff]))
            }
            None => last.zeros_like(),
        };
        let both = Tensor::cat(vec![mean, last], 1);
        w.mlp(["decoder.readout.hidden", "decoder.readout.out"], both).reshape([
            batch,
            horizon + 1,
            outputs,
        ])
    }
}

impl Network for Fdt {
    fn config(&self) -> serde_json::Value {
        serde_json::to_value(self.config).unwrap_or_default()
    }

    fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        self.config.tensors()
    }

    fn forward(&self, w: &Leaves, x: Tensor<3>) -> Output {
        let FdtConfig { channels, d_model: d, global_token, .. } = self.config;
        let batch = x.dims()[0];
        let tokens = self.config.short_horizon.then(|| self.context(w, x.clone()));
        let asks: Tensor<2> = match &tokens {
            Some(tokens) if global_token => {
                tokens.clone().narrow(1, channels, 1).reshape([batch, d])
            }
            Some(tokens) => tokens.clone().mean_dim(1).reshape([batch, d]),
            None => w.vector("short.global").reshape([1, d]).repeat_dim(0, batch),
        };
        let asks = w.norm("cross.norm", asks);
        let regime = if self.config.long_memory {
            self.recall(w, x.clone(), asks)
        } else {
            w.linear("cross.value", asks)
        };
        let tokens = tokens.map(|tokens| tokens.narrow(1, 0, channels));
        let decoded = self.decode(w, tokens, &w.linear("cross.lift", regime.clone()));
        let forecast = match self.skip(w, x) {
            Some(line) => decoded + line,
            None => decoded,
        };
        Output { forecast, regime }
    }

    /// The linear path starts at the line of best fit, and the last layer of the decoder at zero, so the network starts as that line.
    fn solve(
        &self,
        windows: &Windows,
        parameters: &mut Parameters,
    ) -> Result<Option<Line>, LearnError> {
        if self.config.t_skip == 0 {
            return Ok(None);
        }
        let line = Line::of(windows, self.config.t_skip)?;
        line.write(parameters, "skip");
        parameters
            .0
            .iter_mut()
            .filter(|p| p.name.starts_with("decoder.readout.out."))
            .for_each(|parameter| parameter.values.fill(0.0));
        Ok(Some(line))
    }
}
