//! The forward pass that flies: the equations of [`super::model`] with all constant products precomputed.
//!
//! In: z-scored histories. Out: [`Output`]. State: packed weights, which never change, and buffers for intermediate results.

use super::super::nn::kernels::{self, Kernel};
use super::super::nn::mixer::Mixer;
use super::super::nn::packed::{Packed, Precision};
use super::super::nn::{LayerNorm, Linear, add, mean};
use super::super::weights::FdtConfig;
use super::fold::{FirstLayer, Memory};
use super::model::{Long, Model, Output, Short, newest};

/// A network prepared for one processor.
#[derive(Clone)]
pub struct Fast {
    kernel: Kernel,
    precision: Precision,
    config: FdtConfig,
    global: Vec<f32>,
    short: Option<FastShort>,
    long: Option<FastLong>,
    cross_norm: LayerNorm,
    value: Packed,
    lift: Packed,
    decoder: Decoder,
    skip: Option<Packed>,
    mixer: Mixer,
}

#[derive(Clone)]
struct FastShort {
    embed: Packed,
    /// The constant part of each token (identity and global token), [tokens, d].
    constant: Vec<f32>,
    first: Packed,
    first_constant: Vec<f32>,
    first_offset: Vec<f32>,
    first_out: Packed,
    layers: Vec<(LayerNorm, Packed, Packed)>,
}

#[derive(Clone)]
struct FastLong {
    hidden: Packed,
    query: Packed,
    key: Packed,
    key_identity: Vec<f32>,
    value: Packed,
    value_identity: Vec<f32>,
}

#[derive(Clone)]
struct Decoder {
    norm: LayerNorm,
    ffn_hidden: Packed,
    ffn_out: Packed,
    readout_hidden: Packed,
    readout_out: Packed,
}

/// Packs a linear map without folding.
fn packed(linear: &Linear, precision: Precision) -> Packed {
    Packed::new(&linear.weight, &linear.bias, linear.inputs, precision)
}

impl Fast {
    /// Prepares `model` for `kernel`. With [`Precision::Bf16`] the large products read rounded weights. The path from the memory
    /// to `g'` stays f32, because the adapter regresses on `g'`, and so does the linear path, whose large weights of opposite signs cancel.
    pub fn new(model: &Model, kernel: Kernel, precision: Precision) -> Self {
        Self {
            kernel,
            precision,
            config: model.config,
            global: model.global.clone(),
            short: model.short.as_ref().map(|short| FastShort::new(model, short, precision)),
            long: model.long.as_ref().map(|long| FastLong::new(model, long)),
            cross_norm: model.cross_norm.clone(),
            value: packed(&model.value, Precision::F32),
            lift: packed(&model.lift, Precision::F32),
            decoder: Decoder {
                norm: model.decoder_norm.clone(),
                ffn_hidden: packed(&model.ffn_hidden, precision),
                ffn_out: packed(&model.ffn_out, precision),
                readout_hidden: packed(&model.readout_hidden, precision),
                readout_out: packed(&model.readout_out, precision),
            },
            skip: model.skip.as_ref().map(|skip| packed(skip, Precision::F32)),
            mixer: Mixer::default(),
        }
    }

    /// Sizes and flags.
    pub fn config(&self) -> &FdtConfig {
        &self.config
    }

    /// Name of the arithmetic in scenarios and reports.
    pub fn arithmetic(&self) -> String {
        match self.precision {
            Precision::F32 => self.kernel.name().to_owned(),
            Precision::Bf16 => format!("{}_bf16", self.kernel.name()),
        }
    }

    /// Forward pass of `x`: `[channels, t_long]`, z-scored, oldest first; masked channels are zero.
    ///
    /// # Panics
    /// If `x` has another length.
    pub fn forward(&mut self, x: &[f32]) -> Output {
        let FdtConfig { channels, t_long, d_model: d, d_k, .. } = self.config;
        assert_eq!(x.len(), channels * t_long, "one history per channel");
        let kernel = self.kernel;
        let mut tokens = match &self.short {
            Some(short) => short.context(kernel, &self.config, &mut self.mixer, x),
            None => Vec::new(),
        };
        let asks = match (&self.short, self.config.global_token) {
            (Some(_), true) => tokens.split_off(channels * d),
            (Some(_), false) => mean(&tokens, d),
            (None, _) => self.global.clone(),
        };
        let asks = normed(kernel, &self.cross_norm, &asks);
        let (regime, attention) = match &self.long {
            Some(long) => long.recall(kernel, &self.config, x, &asks),
            None => (applied(kernel, &self.value, &asks, d_k), Vec::new()),
        };
        tokens.extend(applied(kernel, &self.lift, &regime, d));
        let mut residual = self.decoder.decode(kernel, &self.config, &tokens);
        if let Some(skip) = &self.skip {
            let window = newest(x, t_long, self.config.t_skip);
            add(&mut residual, &applied(kernel, skip, &window, self.config.readout()));
        }
        Output { residual, regime, attention }
    }
}

fn applied(kernel: Kernel, map: &Packed, x: &[f32], n: usize) -> Vec<f32> {
    let mut y = vec![0.0; n];
    map.rows(kernel, x, &mut y);
    y
}

fn normed(kernel: Kernel, norm: &LayerNorm, x: &[f32]) -> Vec<f32> {
    let mut y = vec![0.0; x.len()];
    kernels::norm(kernel, x, &norm.weight, &norm.bias, &mut y);
    y
}

impl FastShort {
    fn new(model: &Model, short: &Short, precision: Precision) -> Self {
        let constant = [&short.identity[..], &model.global].concat();
        let first = FirstLayer::new(short, &constant);
        let t_short = short.embed.inputs;
        Self {
            embed: packed(&short.embed, Precision::F32),
            constant,
            first: Packed::new(&first.window, &[], t_short, Precision::F32),
            first_constant: first.constant,
            first_offset: first.offset,
            first_out: packed(&short.layers[0].out, precision),
            layers: short.layers[1..]
                .iter()
                .map(|layer| {
                    let [qkv, out] = [&layer.qkv, &layer.out].map(|map| packed(map, precision));
                    (layer.norm.clone(), qkv, out)
                })
                .collect(),
        }
    }

    /// The tokens of the channels, then the global token if the model has one; `[tokens, d]`.
    fn context(
        &self,
        kernel: Kernel,
        config: &FdtConfig,
        mixer: &mut Mixer,
        x: &[f32],
    ) -> Vec<f32> {
        let FdtConfig { channels, t_short, t_long, d_model: d, heads, .. } = *config;
        let windows = &x[t_long - t_short..];
        let mut tokens = vec![0.0; self.constant.len()];
        self.embed.apply(kernel, windows, t_long, &mut tokens[..channels * d]);
        add(&mut tokens, &self.constant);
        let mut qkv = vec![0.0; 3 * tokens.len()];
        self.first.apply(kernel, windows, t_long, &mut qkv[..channels * 3 * d]);
        add(&mut qkv, &self.first_constant);
        for (row, token) in qkv.chunks_exact_mut(3 * d).zip(tokens.chunks_exact(d)) {
            let scale = kernels::spread(kernel, token);
            for (v, offset) in row.iter_mut().zip(&self.first_offset) {
                *v = *v * scale + offset;
            }
        }
        let mut mixed = vec![0.0; tokens.len()];
        let mut change = vec![0.0; tokens.len()];
        mixer.attend(kernel, &qkv, d, heads, &mut mixed);
        self.first_out.rows(kernel, &mixed, &mut change);
        add(&mut tokens, &change);
        for (norm, to_qkv, out) in &self.layers {
            kernels::norm(kernel, &tokens, &norm.weight, &norm.bias, &mut change);
            to_qkv.rows(kernel, &change, &mut qkv);
            mixer.attend(kernel, &qkv, d, heads, &mut mixed);
            out.rows(kernel, &mixed, &mut change);
            add(&mut tokens, &change);
        }
        tokens
    }
}

impl FastLong {
    fn new(model: &Model, long: &Long) -> Self {
        let FdtConfig { d_model: d, d_k, .. } = model.config;
        let memory = Memory::new(model, long);
        Self {
            hidden: packed(&long.hidden, Precision::F32),
            query: packed(&long.query, Precision::F32),
            key: Packed::new(&memory.key, &[], d_k, Precision::F32),
            key_identity: memory.key_identity,
            value: Packed::new(&memory.value, &[], d, Precision::F32),
            value_identity: memory.value_identity,
        }
    }

    /// The regime `g'`, `[d_k]`, and the attention over the channels, `[channels]`.
    fn recall(
        &self,
        kernel: Kernel,
        config: &FdtConfig,
        x: &[f32],
        asks: &[f32],
    ) -> (Vec<f32>, Vec<f32>) {
        let FdtConfig { channels, d_model: d, d_k, .. } = *config;
        let mut hidden = applied(kernel, &self.hidden, x, channels * d);
        kernels::gelu(kernel, &mut hidden);
        let q = applied(kernel, &self.query, asks, d_k);
        let key = applied(kernel, &self.key, &q, d);
        let mut alpha: Vec<f32> = hidden
            .chunks_exact(d)
            .zip(self.key_identity.chunks_exact(d_k))
            .map(|(u, p)| kernels::dot(kernel, u, &key) + kernels::dot(kernel, &q, p))
            .collect();
        let scale = 1.0 / (d_k as f32).sqrt();
        kernels::softmax(kernel, &mut alpha, channels, channels, scale);
        let mut weighted = vec![0.0; d];
        let mut regime = vec![0.0; d_k];
        for ((u, p), weight) in
            hidden.chunks_exact(d).zip(self.value_identity.chunks_exact(d_k)).zip(&alpha)
        {
            weighted.iter_mut().zip(u).for_each(|(sum, u)| *sum += weight * u);
            regime.iter_mut().zip(p).for_each(|(sum, p)| *sum += weight * p);
        }
        add(&mut regime, &applied(kernel, &self.value, &weighted, d_k));
        (regime, alpha)
    }
}

impl Decoder {
    /// The second map of the FFN is linear. Only the mean over the channels passes it, which gives the same result as every
    /// channel.
    fn decode(&self, kernel: Kernel, config: &FdtConfig, encoded: &[f32]) -> Vec<f32> {
        let FdtConfig { d_model: d, d_ff: f, .. } = *config;
        let pooled = |x: &[f32], width: usize| {
            let (channels, last) = x.split_at(x.len() - width);
            [&mean(channels, width), last].concat()
        };
        let rows = encoded.len() / d;
        let mut hidden =
            applied(kernel, &self.ffn_hidden, &normed(kernel, &self.norm, encoded), rows * f);
        kernels::gelu(kernel, &mut hidden);
        let mut y = applied(kernel, &self.ffn_out, &pooled(&hidden, f), 2 * d);
        add(&mut y, &pooled(encoded, d));
        if rows == 1 {
            // Without channels their mean is zero, and not the network's output for zero.
            y[..d].fill(0.0);
        }
        let mut hidden = applied(kernel, &self.readout_hidden, &y, f);
        kernels::gelu(kernel, &mut hidden);
        applied(kernel, &self.readout_out, &hidden, config.readout())
    }
}
