//! Cuts series into z-scored windows, and collects windows into batches for training and validation.
//!
//! In: [`Dataset`]. Out: [`Batch`]es of `x` `[batch, channels, t_long]` (oldest first) and `y` `[batch, horizon + 1, outputs]`.
//! Windows never cross flights. The last part of each flight is for validation; a gap of `t_long` ticks before it is used by neither.

use rand::seq::SliceRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::LearnError;
use super::config::TrainConfig;
use super::dataset::{Dataset, FlightSeries};
use twin_core::elementary::squared;
use twin_core::normal::StandardNormal;
use twin_core::notation::TICK_S;
use twin_core::residual::weights;

/// A channel with a smaller standard deviation is constant, and its deviation counts as 1.
const LEAST_STD: f64 = 1e-6;

/// Stride of the validation windows, because neighbours are nearly equal.
const VALIDATION_STRIDE: usize = 4;

/// Means and standard deviations over the training part; physical units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Normalisation {
    /// Mean of each input channel.
    pub input_mean: Vec<f32>,
    /// Standard deviation of each input channel.
    pub input_std: Vec<f32>,
    /// Mean of each output.
    pub output_mean: Vec<f32>,
    /// Standard deviation of each output.
    pub output_std: Vec<f32>,
}

/// The end of a window: its flight and its newest tick `t`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WindowEnd {
    /// Number of the flight.
    pub flight: usize,
    /// The newest tick of the window.
    pub tick: usize,
}

/// One batch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// `[size, channels, t_long]`, z-scored, masked channels zero.
    pub x: Vec<f32>,
    /// `[size, horizon + 1, outputs]`, z-scored.
    pub y: Vec<f32>,
    /// Flight of each window.
    pub flights: Vec<usize>,
}

impl Batch {
    /// Number of windows.
    pub fn size(&self) -> usize {
        self.flights.len()
    }
}

/// All windows of a data set.
#[derive(Clone, Debug)]
pub struct Windows {
    /// Means and standard deviations of the z-scores.
    pub normalisation: Normalisation,
    /// Number of input channels.
    pub channels: usize,
    /// Number of outputs.
    pub outputs: usize,
    t_long: usize,
    horizon: usize,
    /// The flights, z-scored.
    flights: Vec<FlightSeries>,
    train: Vec<WindowEnd>,
    validation: Vec<WindowEnd>,
    /// For each channel, whether it gets noise; the applied forces do.
    noisy: Vec<bool>,
    noise: f32,
}

impl Windows {
    /// Splits `data` into training and validation, normalises it and sets masked channels to zero.
    ///
    /// # Errors
    /// [`LearnError::TooShort`] if training or validation has no window.
    pub fn new(data: &Dataset, config: &TrainConfig) -> Result<Self, LearnError> {
        let (t_long, horizon) = (config.t_long, config.horizon);
        let places = |part: &dyn Fn(&FlightSeries) -> std::ops::Range<usize>| {
            let of = |(flight, series): (usize, &FlightSeries)| {
                let ends = part(series).filter(|t| learnable(series, *t, horizon));
                ends.map(|tick| WindowEnd { flight, tick }).collect::<Vec<_>>()
            };
            data.flights.iter().enumerate().flat_map(of).collect::<Vec<WindowEnd>>()
        };
        let split = |s: &FlightSeries| (s.ticks() as f64 * (1.0 - config.validation)) as usize;
        let train = places(&|s| 0..split(s).saturating_sub(horizon));
        let mut validation = places(&|s| split(s) + t_long..s.ticks());
        validation.retain(|place| place.tick % VALIDATION_STRIDE == 0);
        if train.is_empty() || validation.is_empty() {
            let needed = (t_long + horizon) as f64 / config.validation.max(0.01);
            return Err(LearnError::TooShort {
                windows: train.len(),
                validation: validation.len(),
                ticks: data.usable_ticks(),
                needed_s: needed * TICK_S,
            });
        }
        let normalisation = Normalisation::of(data, &split);
        let masked: Vec<bool> =
            data.channel_names.iter().map(|name| config.masked.contains(name)).collect();
        Ok(Self {
            flights: data.flights.iter().map(|s| normalisation.apply(s, &masked)).collect(),
            normalisation,
            channels: data.channel_names.len(),
            outputs: data.output_names.len(),
            t_long,
            horizon,
            train,
            validation,
            noisy: data.channel_names.iter().map(|name| name.starts_with("tau.")).collect(),
            noise: config.tau_noise,
        })
    }

    /// Number of windows for training, before any stride.
    pub fn training_windows(&self) -> usize {
        self.train.len()
    }

    /// The windows for training, in order, before any stride.
    pub fn training(&self) -> &[WindowEnd] {
        &self.train
    }

    /// Variance of the white noise on `channel`, z-scored.
    pub fn noise_variance(&self, channel: usize) -> f64 {
        if self.noisy[channel] { squared(f64::from(self.noise)) } else { 0.0 }
    }

    /// Number of values that a forecast has: `(horizon + 1) * outputs`.
    pub fn targets(&self) -> usize {
        (self.horizon + 1) * self.outputs
    }

    /// Number of flights.
    pub fn flights(&self) -> usize {
        self.flights.len()
    }

    /// Every `stride`-th training window from an offset that is drawn for this epoch, shuffled. It depends on `seed` and `epoch` only.
    pub fn epoch(&self, seed: u64, epoch: usize, stride: usize) -> Vec<WindowEnd> {
        let mut random = generator(seed, epoch, 1);
        let offset = random.random_range(0..stride.max(1));
        let due = |place: &&WindowEnd| place.tick % stride.max(1) == offset;
        let mut places: Vec<WindowEnd> = self.train.iter().filter(due).copied().collect();
        places.shuffle(&mut random);
        places
    }

    /// The windows for validation, in order.
    pub fn validation(&self) -> &[WindowEnd] {
        &self.validation
    }

    /// The windows in `places`. With `noise`, the applied forces get white noise, so that the model does not rely on `tau_{t-1}` alone:
    /// at rest `r = tau`, and a loop that is closed over this leak has a limit cycle.
    pub fn batch(&self, places: &[WindowEnd], noise: Option<&mut Pcg64Mcg>) -> Batch {
        let mut batch = Batch::default();
        batch.x.reserve(places.len() * self.channels * self.t_long);
        for place in places {
            let series = &self.flights[place.flight];
            for channel in &series.inputs {
                // Ticks before the first repeat the oldest tick, as in flight.
                let missing = self.t_long.saturating_sub(place.tick + 1);
                batch.x.extend(std::iter::repeat_n(channel[0], missing));
                batch.x.extend_from_slice(
                    &channel[place.tick + 1 - (self.t_long - missing)..=place.tick],
                );
            }
            for ahead in 0..=self.horizon {
                batch.y.extend(series.outputs.iter().map(|row| row[place.tick + ahead]));
            }
            batch.flights.push(place.flight);
        }
        if let Some(random) = noise.filter(|_| self.noise > 0.0) {
            self.disturb(&mut batch.x, random);
        }
        batch
    }

    fn disturb(&self, x: &mut [f32], random: &mut impl Rng) {
        for (index, row) in x.chunks_exact_mut(self.t_long).enumerate() {
            if self.noisy[index % self.channels] {
                for value in row {
                    let normal: f32 = random.sample(StandardNormal);
                    *value += self.noise * normal;
                }
            }
        }
    }
}

/// The random generator of one purpose (`stream`) in one epoch. Its state need not be stored, because the arguments determine it.
pub fn generator(seed: u64, epoch: usize, stream: u64) -> Pcg64Mcg {
    let mixed = seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add((epoch as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9))
        .wrapping_add(stream.wrapping_mul(0x94d0_49bb_1331_11eb));
    Pcg64Mcg::seed_from_u64(mixed)
}

/// Whether the residual is usable at all ticks `t..=t + horizon`.
fn learnable(series: &FlightSeries, t: usize, horizon: usize) -> bool {
    series.usable.get(t..=t + horizon).is_some_and(|ticks| ticks.iter().all(|usable| *usable))
}

impl Normalisation {
    /// Statistics over the usable ticks before `split` of each flight.
    fn of(data: &Dataset, split: &dyn Fn(&FlightSeries) -> usize) -> Self {
        let statistics = |of: &dyn Fn(&FlightSeries) -> &[f32]| {
            let values = || {
                data.flights.iter().flat_map(|series| {
                    let ticks = (0..split(series)).filter(move |t| series.usable[*t]);
                    ticks.map(move |t| f64::from(of(series)[t]))
                })
            };
            let count = values().count().max(1) as f64;
            let mean = values().sum::<f64>() / count;
            let variance = values().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
            let std = variance.sqrt();
            (mean as f32, if std < LEAST_STD { 1.0 } else { std as f32 })
        };
        let inputs = 0..data.channel_names.len();
        let outputs = 0..data.output_names.len();
        let (input_mean, input_std) = inputs.map(|i| statistics(&|s| &s.inputs[i])).unzip();
        let (output_mean, output_std) = outputs.map(|i| statistics(&|s| &s.outputs[i])).unzip();
        Self { input_mean, input_std, output_mean, output_std }
    }

    /// The statistics as a file of weights holds them; `masked` and `regime_scale` are fields of that form.
    pub fn written(&self, masked: Vec<String>, regime_scale: f64) -> weights::Normalisation {
        let wide = |values: &[f32]| values.iter().map(|v| f64::from(*v)).collect::<Vec<f64>>();
        weights::Normalisation {
            masked,
            input_mean: wide(&self.input_mean),
            input_std: wide(&self.input_std),
            output_mean: wide(&self.output_mean),
            output_std: wide(&self.output_std),
            regime_scale,
        }
    }

    fn apply(&self, series: &FlightSeries, masked: &[bool]) -> FlightSeries {
        let z = |values: &[f32], mean: f32, std: f32| -> Vec<f32> {
            values.iter().map(|v| (v - mean) / std).collect()
        };
        let input = |(i, values): (usize, &Vec<f32>)| {
            if masked[i] {
                vec![0.0; values.len()]
            } else {
                z(values, self.input_mean[i], self.input_std[i])
            }
        };
        let output = |(i, v): (usize, &Vec<f32>)| z(v, self.output_mean[i], self.output_std[i]);
        FlightSeries {
            name: series.name.clone(),
            inputs: series.inputs.iter().enumerate().map(input).collect(),
            outputs: series.outputs.iter().enumerate().map(output).collect(),
            usable: series.usable.clone(),
        }
    }
}
