//! Random weights and histories from a seed, of any size; no training made them.

use rand::SeedableRng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;
use twin_core::elementary::sin;
use twin_core::normal::StandardNormal;
use twin_core::residual::weights::{
    Acceptance, FORMAT, FdtConfig, Head, Normalisation, Tensor, Training, Weights, channel_names,
    output_names,
};

/// Seeded normal numbers.
pub(crate) struct Chance(Pcg64);

impl Chance {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    pub(crate) fn normal(&mut self) -> f32 {
        StandardNormal.sample(&mut self.0)
    }

    /// A whole number in `1..=most`.
    pub(crate) fn size(&mut self, most: usize) -> usize {
        let share = (f64::from(self.normal()) * 1e6).abs() as usize;
        1 + share % most
    }

    pub(crate) fn normals(&mut self, n: usize) -> Vec<f32> {
        (0..n).map(|_| self.normal()).collect()
    }
}

/// Weights for `config`. Every part affects the result: norms differ from one, biases from zero, and activations keep their size
/// from layer to layer.
pub(crate) fn weights(config: &FdtConfig, seed: u64) -> Weights {
    let mut chance = Chance::new(seed);
    let tensors = config
        .tensors()
        .into_iter()
        .map(|(name, shape)| {
            let count = shape.iter().product();
            let (centre, spread) = match (name.as_str(), shape.len()) {
                (name, _) if name.ends_with("norm.weight") => (1.0, 0.2),
                (name, 2) if name.ends_with("weight") => (0.0, (shape[1] as f32).sqrt().recip()),
                _ => (0.0, 0.3),
            };
            let values = chance.normals(count).iter().map(|v| centre + spread * v).collect();
            (name, Tensor { shape, values })
        })
        .collect();
    Weights { head: head(config), tensors }
}

/// A head that fits `config`; where the sizes are those of the vehicle, the names are too.
pub(crate) fn head(config: &FdtConfig) -> Head {
    let numbered = |n: usize| (0..n).map(|i| format!("c{i}")).collect::<Vec<_>>();
    let own = |names: Vec<String>, n: usize| if names.len() == n { names } else { numbered(n) };
    let channels = own(channel_names(), config.channels);
    let masked = ["chi.x", "chi.y", "chi.psi"]
        .iter()
        .map(|name| (*name).to_owned())
        .filter(|name| channels.contains(name))
        .collect();
    Head {
        format: FORMAT,
        model: "fdt".to_owned(),
        config: serde_json::to_value(config).expect("plain numbers"),
        normalisation: Normalisation {
            masked,
            input_mean: (0..config.channels).map(|i| 0.01 * i as f64).collect(),
            input_std: (0..config.channels).map(|i| 0.5 + 0.1 * i as f64).collect(),
            output_mean: (0..config.outputs).map(|i| 0.2 * i as f64).collect(),
            output_std: (0..config.outputs).map(|i| 0.3 + 0.1 * i as f64).collect(),
            regime_scale: 0.75,
        },
        channel_names: channels,
        output_names: own(output_names(), config.outputs),
        rate_hz: 100.0,
        m_bar: vec![1.0; config.outputs],
        data_hash: String::new(),
        git: String::new(),
        seed: 1,
        training: Training::default(),
        acceptance: Acceptance::default(),
    }
}

/// A z-scored history, `[channels, t_long]`, smooth in time like that of a vehicle.
pub(crate) fn history(config: &FdtConfig, seed: u64) -> Vec<f32> {
    let mut chance = Chance::new(seed);
    (0..config.channels)
        .flat_map(|_| {
            let (a, b, phase) = (chance.normal(), chance.normal(), chance.normal());
            (0..config.t_long).map(move |t| a + b * sin(0.05 * t as f32 + phase))
        })
        .collect()
}

/// The ablations that keep a part that queries the memory, and a part that answers.
pub(crate) fn ablations(config: FdtConfig) -> Vec<FdtConfig> {
    let mut all = Vec::new();
    for flags in 0..8_u8 {
        let ablated = FdtConfig {
            global_token: flags & 1 == 0,
            short_horizon: flags & 2 == 0,
            long_memory: flags & 4 == 0,
            ..config
        };
        all.extend(ablated.check().is_ok().then_some(ablated));
    }
    all
}

/// Sizes that are not multiples of the vector lengths of a processor.
pub(crate) fn odd(seed: u64) -> FdtConfig {
    let mut chance = Chance::new(seed);
    let heads = chance.size(5);
    let t_long = 1 + chance.size(150);
    FdtConfig {
        channels: chance.size(30),
        outputs: chance.size(9),
        t_short: chance.size(t_long),
        t_long,
        d_model: heads * chance.size(13),
        heads,
        d_ff: chance.size(70),
        d_k: chance.size(40),
        layers: chance.size(3),
        horizon: chance.size(7) - 1,
        t_skip: if seed.is_multiple_of(2) { 0 } else { chance.size(t_long) },
        ..FdtConfig::SMALL
    }
}
