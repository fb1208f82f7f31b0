//! Sizes and flags of the Factorized Dynamics Transformer, and the tensors that they imply.

use serde::{Deserialize, Serialize};

use super::{Head, WeightsError, sizes};

/// Sizes and ablation flags. The letters are the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FdtConfig {
    /// Input channels `d_v`.
    pub channels: usize,
    /// Number of coordinates of the residual.
    pub outputs: usize,
    /// Short window `T_s`, ticks.
    pub t_short: usize,
    /// Long window `T_l`, ticks.
    pub t_long: usize,
    /// Width of a token, `d_model`.
    pub d_model: usize,
    /// Attention heads per layer.
    pub heads: usize,
    /// Hidden width of the decoder, `d_ff`.
    pub d_ff: usize,
    /// Width of the regime `g'`, `d_k`.
    pub d_k: usize,
    /// Number of attention layers.
    pub layers: usize,
    /// Horizon `k`, ticks; the network gives `k + 1` forecasts.
    pub horizon: usize,
    /// True if a learned global token joins the channels' tokens.
    pub global_token: bool,
    /// True if the network sees the short window.
    pub short_horizon: bool,
    /// True if the network sees the long window.
    pub long_memory: bool,
    /// Window of the linear path to the forecasts, ticks; 0 without such a path, which the paper does not have.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub t_skip: usize,
}

/// True for the value that a file does not write.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde calls it with a reference")]
fn is_zero(value: &usize) -> bool {
    *value == 0
}

impl FdtConfig {
    /// The default of `twin train`: a size for one core, with the linear path and a horizon of 250 ms.
    pub const SMALL: Self = Self {
        channels: 24,
        outputs: 8,
        t_short: 5,
        t_long: 120,
        d_model: 64,
        heads: 4,
        d_ff: 256,
        d_k: 32,
        layers: 2,
        horizon: 25,
        global_token: true,
        short_horizon: true,
        long_memory: true,
        t_skip: 10,
    };

    /// The paper's size and architecture, but with `d_k` = 32.
    pub const PAPER: Self =
        Self { d_model: 512, heads: 8, d_ff: 2048, horizon: 6, t_skip: 0, ..Self::SMALL };

    /// The configuration in `head`.
    ///
    /// # Errors
    /// [`WeightsError`] if the head has no such configuration, or if its sizes contradict each other or the head.
    pub fn of(head: &Head) -> Result<Self, WeightsError> {
        let config: Self = sizes::read(head)?;
        config.check()?;
        sizes::fit(head, config.channels, config.outputs)?;
        Ok(config)
    }

    /// Checks that the sizes fit into memory and are consistent.
    ///
    /// # Errors
    /// [`WeightsError::Config`] that names the first wrong size.
    pub fn check(&self) -> Result<(), WeightsError> {
        sizes::within(&[
            ("channels", self.channels, 256),
            ("outputs", self.outputs, 64),
            ("t_short", self.t_short, self.t_long.min(1024)),
            ("t_long", self.t_long, 1024),
            ("d_model", self.d_model, 4096),
            ("heads", self.heads, self.d_model),
            ("d_ff", self.d_ff, 16_384),
            ("d_k", self.d_k, 1024),
            ("layers", self.layers, 32),
            // At least one forecast.
            ("horizon", self.horizon + 1, 64),
        ])?;
        sizes::heads_divide(self.heads, self.d_model)?;
        if self.t_skip > self.t_long {
            return Err(WeightsError::Config {
                key: "t_skip",
                found: self.t_skip.to_string(),
                expected: format!("0..={}", self.t_long),
            });
        }
        if !self.short_horizon && !self.global_token {
            return Err(WeightsError::Config {
                key: "global_token",
                found: "false".to_owned(),
                expected: "true where short_horizon is false: a token must query the memory"
                    .to_owned(),
            });
        }
        Ok(())
    }

    /// Number of outputs of the decoder: `(k + 1)` forecasts of every coordinate.
    pub fn readout(&self) -> usize {
        (self.horizon + 1) * self.outputs
    }

    /// Width of the input of the linear path: its window of every channel.
    pub fn skip_inputs(&self) -> usize {
        self.channels * self.t_skip
    }

    /// Name and shape of every tensor.
    pub fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        let Self { channels, d_model: d, d_ff, d_k, .. } = *self;
        let mut all: Vec<(String, Vec<usize>)> = Vec::new();
        let mut add = |name: &str, shape: &[usize]| all.push((name.to_owned(), shape.to_vec()));
        if self.global_token {
            add("short.global", &[d]);
        }
        if self.short_horizon {
            add("short.embed.weight", &[d, self.t_short]);
            add("short.identity", &[channels, d]);
            for layer in 0..self.layers {
                let stem = format!("short.layer.{layer}");
                add(&format!("{stem}.norm.weight"), &[d]);
                add(&format!("{stem}.norm.bias"), &[d]);
                add(&format!("{stem}.qkv.weight"), &[3 * d, d]);
                add(&format!("{stem}.out.weight"), &[d, d]);
                add(&format!("{stem}.out.bias"), &[d]);
            }
        }
        if self.long_memory {
            add("long.hidden.weight", &[d, self.t_long]);
            add("long.hidden.bias", &[d]);
            add("long.out.weight", &[d, d]);
            add("long.identity", &[channels, d]);
            add("cross.query.weight", &[d_k, d]);
            add("cross.key.weight", &[d_k, d]);
        }
        add("cross.norm.weight", &[d]);
        add("cross.norm.bias", &[d]);
        add("cross.value.weight", &[d_k, d]);
        add("cross.lift.weight", &[d, d_k]);
        add("decoder.norm.weight", &[d]);
        add("decoder.norm.bias", &[d]);
        add("decoder.ffn.hidden.weight", &[d_ff, d]);
        add("decoder.ffn.hidden.bias", &[d_ff]);
        add("decoder.ffn.out.weight", &[d, d_ff]);
        add("decoder.ffn.out.bias", &[d]);
        add("decoder.readout.hidden.weight", &[d_ff, 2 * d]);
        add("decoder.readout.hidden.bias", &[d_ff]);
        add("decoder.readout.out.weight", &[self.readout(), d_ff]);
        add("decoder.readout.out.bias", &[self.readout()]);
        if self.t_skip > 0 {
            add("skip.weight", &[self.readout(), self.skip_inputs()]);
            add("skip.bias", &[self.readout()]);
        }
        all
    }
}
