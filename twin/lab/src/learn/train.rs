//! The training: epochs of steps, validation, checkpoint, early stop, and in the end one file of weights.
//!
//! In: [`Dataset`], [`Request`]. Out: the file `out` and its [`Outcome`]. Batches and noise are functions of seed and epoch, so the
//! same request gives the same bits on one machine with one number of threads, also if the training was stopped and resumed.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use burn_tensor::{Tensor, TensorData};
use nalgebra::DMatrix;

use super::LearnError;
use super::adam::{Adam, learning_rate};
use super::baselines;
use super::checkpoint::{self, Checkpoint, EpochRecord, TrainState};
use super::config::TrainConfig;
use super::dataset::Dataset;
use super::device::device;
use super::fdt::Fdt;
use super::graph::{Inputs, Leaves, Network, exclusive, mean_square, values};
use super::parameters::Parameters;
use super::regime::{Basis, second_moment};
use super::windows::{Batch, WindowEnd, Windows, generator};
use twin_core::notation::TICK_S;
use twin_core::residual::weights::{self, Acceptance, FORMAT, Head, ModelKind, Weights};
use twin_record::Outputs;

/// Stride of the training windows whose regime determines the basis.
const REGIME_STRIDE: usize = 32;

/// A request for a training.
pub struct Request<'a> {
    /// Model and settings.
    pub config: &'a TrainConfig,
    /// Seed of initialisation, order of the windows, offsets and noise.
    pub seed: u64,
    /// Whether to resume from the checkpoint beside `out`.
    pub resume: bool,
    /// Path of the file of weights.
    pub out: &'a Path,
    /// The outputs of this run, which `out` and the first checkpoint belong to; later checkpoints replace it.
    pub outputs: &'a Outputs,
    /// Commit of the program, for the head of the file.
    pub git: &'a str,
}

/// Progress that the observer gets after every step and every epoch.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// The epoch, from 1.
    pub epoch: usize,
    /// Number of steps that are done in the epoch, and number of all its steps.
    pub steps: (usize, usize),
    /// Mean loss of the epoch so far.
    pub loss: f64,
    /// The record of the epoch; set after the last step, when the checkpoint was written.
    pub finished: Option<EpochRecord>,
}

impl Progress {
    /// The progress after an epoch.
    fn finished(record: EpochRecord) -> Self {
        let finished = Some(record);
        Self { epoch: record.epoch, steps: (1, 1), loss: record.train_loss, finished }
    }
}

/// The result of a training.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Head of the file of weights.
    pub head: Head,
    /// The curve.
    pub curve: Vec<EpochRecord>,
    /// Number of scalars of the model.
    pub parameters: usize,
    /// Number of windows for training, before the stride, and for validation.
    pub windows: (usize, usize),
    /// Validation loss of a forecast that is always the mean, which is the variance of the validation windows.
    pub validation_variance: f64,
    /// Whether the training finished; `false` if the observer stopped it, and then only the checkpoint was written.
    pub finished: bool,
}

/// The network that `config` names.
pub fn network(config: &TrainConfig, windows: &Windows) -> Box<dyn Network> {
    let (channels, outputs) = (windows.channels, windows.outputs);
    match config.model {
        ModelKind::Fdt => Box::new(Fdt::new(config, channels, outputs)),
        _ => baselines::network(config, channels, outputs, windows.flights()),
    }
}

/// Trains a model. `observe` gets the progress, and may stop the training between two steps.
///
/// # Errors
/// [`LearnError`] if the data, the checkpoint or the disk do not allow the training, or the loss diverges.
pub fn train(
    data: &Dataset,
    request: &Request<'_>,
    observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Outcome, LearnError> {
    let windows = Windows::new(data, request.config)?;
    let _one_thread = exclusive();
    let network = network(request.config, &windows);
    let mut training = Trainer::new(data, request, &windows, network.as_ref())?;
    let finished = training.start(observe)? && training.run(observe)?;
    training.finish(data, finished)
}

struct Trainer<'a> {
    request: &'a Request<'a>,
    windows: &'a Windows,
    network: &'a dyn Network,
    now: Checkpoint,
}

impl<'a> Trainer<'a> {
    fn new(
        data: &Dataset,
        request: &'a Request<'a>,
        windows: &'a Windows,
        network: &'a dyn Network,
    ) -> Result<Self, LearnError> {
        let tensors: Vec<_> = network.tensors().into_iter().chain(network.helpers()).collect();
        let mut weights = Parameters::initial(&tensors, &mut generator(request.seed, 0, 0));
        network.constrain(&mut weights);
        let data_hash = data.hash();
        let path = checkpoint::path_for(request.out);
        let now = if request.resume {
            let found = Checkpoint::read(&path, &weights)?;
            found.check_same(&path, request.config, request.seed, &data_hash)?;
            found
        } else {
            let state = TrainState {
                config: request.config.clone(),
                seed: request.seed,
                data_hash,
                steps: 0,
                curve: Vec::new(),
                best_epoch: 0,
                ridge_penalty: None,
            };
            Checkpoint { state, best: weights.clone(), adam: Adam::new(&weights), weights }
        };
        Ok(Self { request, windows, network, now })
    }

    /// Runs all epochs; returns whether the training finished.
    fn run(
        &mut self,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<bool, LearnError> {
        let epochs = if self.network.descends() { self.request.config.epochs } else { 0 };
        while self.now.state.epochs() < epochs && !self.out_of_patience() {
            let Some(record) = self.epoch(observe)? else { return Ok(false) };
            self.keep()?;
            if observe(Progress::finished(record)).is_break() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Sets the tensors that have a solution in closed form, and validates them as epoch 0; returns whether the training goes on.
    #[expect(
        clippy::disallowed_methods,
        reason = "people read the time of an epoch; nothing depends on it"
    )]
    fn start(
        &mut self,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<bool, LearnError> {
        let began = Instant::now();
        if !self.now.state.curve.is_empty() {
            return Ok(true);
        }
        let Some(line) = self.network.solve(self.windows, &mut self.now.weights)? else {
            return Ok(true);
        };
        self.now.state.ridge_penalty = Some(line.penalty);
        let validation_loss = self.validate();
        let record = EpochRecord {
            epoch: 0,
            train_loss: line.train_loss,
            validation_loss,
            learning_rate: 0.0,
            wall_s: began.elapsed().as_secs_f64(),
        };
        self.add(record)?;
        self.keep()?;
        Ok(observe(Progress::finished(record)).is_continue())
    }

    /// Adds an epoch to the curve, and keeps its weights if they are the best.
    fn add(&mut self, record: EpochRecord) -> Result<(), LearnError> {
        let (loss, epoch) = (record.validation_loss, record.epoch);
        if !loss.is_finite() {
            return Err(LearnError::Diverged { loss, epoch, learning_rate: record.learning_rate });
        }
        let best = self.now.state.curve.iter().map(|r| r.validation_loss).fold(f64::MAX, f64::min);
        self.now.state.curve.push(record);
        if loss < best {
            self.now.state.best_epoch = epoch;
            self.now.best = self.now.weights.clone();
        }
        self.now.state.steps = self.now.adam.steps;
        Ok(())
    }

    /// Writes the checkpoint. The first one of a training that does not resume is a new file.
    fn keep(&self) -> Result<(), LearnError> {
        let path = checkpoint::path_for(self.request.out);
        if self.request.resume || self.now.state.curve.len() > 1 {
            return self.now.write(&path);
        }
        let output = self.request.outputs.reserve_with_folder(&path, "--out")?;
        Ok(output.write(&self.now.to_bytes(&path)?)?)
    }

    fn out_of_patience(&self) -> bool {
        let state = &self.now.state;
        state.epochs() >= state.best_epoch + self.request.config.patience
    }

    /// Runs one epoch; `None` if the observer stopped it.
    #[expect(
        clippy::disallowed_methods,
        reason = "people read the time of an epoch; nothing depends on it"
    )]
    fn epoch(
        &mut self,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Option<EpochRecord>, LearnError> {
        let (config, seed, began) = (self.request.config, self.request.seed, Instant::now());
        let epoch = self.now.state.epochs();
        let places = self.windows.epoch(seed, epoch, config.stride);
        let mut noise = generator(seed, epoch, 2);
        let steps = places.len().div_ceil(config.batch).max(1);
        let (mut sum, mut rate) = (0.0, 0.0);
        for (step, part) in places.chunks(config.batch).enumerate() {
            let progress = epoch as f64 + step as f64 / steps as f64;
            rate = learning_rate(
                config.learning_rate,
                config.warm_up_epochs,
                config.epochs as f64,
                progress,
            );
            let batch = self.windows.batch(part, Some(&mut noise));
            let loss = self.step(&batch, rate, progress / config.epochs as f64);
            if !loss.is_finite() {
                let epoch = epoch + 1;
                return Err(LearnError::Diverged { loss, epoch, learning_rate: rate });
            }
            sum += loss;
            let loss = sum / (step + 1) as f64;
            let steps = (step + 1, steps);
            let told = Progress { epoch: epoch + 1, steps, loss, finished: None };
            if observe(told).is_break() {
                return Ok(None);
            }
        }
        let record = EpochRecord {
            epoch: epoch + 1,
            train_loss: sum / steps as f64,
            validation_loss: self.validate(),
            learning_rate: rate,
            wall_s: began.elapsed().as_secs_f64(),
        };
        self.add(record)?;
        Ok(Some(record))
    }

    /// Makes one step of the optimiser, and returns the loss before it.
    fn step(&mut self, batch: &Batch, rate: f64, progress: f64) -> f64 {
        let leaves = Leaves::new(&self.now.weights, true);
        let loss = self.network.loss(&leaves, self.inputs(batch, true, progress));
        let gradients = leaves.gradients(loss.backward());
        let clip = self.request.config.gradient_clip;
        self.now.adam.step(&mut self.now.weights, &gradients, rate, clip);
        self.network.constrain(&mut self.now.weights);
        values(loss.inner()).first().copied().map_or(f64::NAN, f64::from)
    }

    fn inputs(&self, batch: &Batch, tracked: bool, progress: f64) -> Inputs {
        let (device, config) = (device(tracked), self.request.config);
        let tensor = |values: &[f32], shape: [usize; 3]| -> Tensor<3> {
            Tensor::from_data(TensorData::new(values.to_vec(), shape), &device)
        };
        let size = batch.size();
        Inputs {
            x: tensor(&batch.x, [size, self.windows.channels, config.t_long]),
            y: tensor(&batch.y, [size, config.horizon + 1, self.windows.outputs]),
            flights: batch.flights.clone(),
            progress,
        }
    }

    /// Mean squared error over the validation windows, without noise.
    fn validate(&self) -> f64 {
        let leaves = Leaves::new(&self.now.weights, false);
        self.over(self.windows.validation(), |inputs| {
            let error = self.network.forward(&leaves, inputs.x).forecast - inputs.y;
            f64::from(values(mean_square(error))[0])
        })
    }

    /// The mean of `of` over the windows in `places`; each window has the same weight.
    fn over(&self, places: &[WindowEnd], of: impl Fn(Inputs) -> f64) -> f64 {
        let part = |part: &[WindowEnd]| {
            let batch = self.windows.batch(part, None);
            of(self.inputs(&batch, false, 1.0)) * part.len() as f64
        };
        places.chunks(self.request.config.batch).map(part).sum::<f64>() / places.len() as f64
    }

    fn finish(mut self, data: &Dataset, finished: bool) -> Result<Outcome, LearnError> {
        let mut scale = 1.0;
        if finished {
            let basis = self.basis();
            basis.turn(&mut self.now.best);
            scale = basis.scale;
        }
        let outcome = Outcome {
            head: self.head(data, scale),
            curve: self.now.state.curve.clone(),
            parameters: self
                .network
                .tensors()
                .iter()
                .map(|(_, s)| s.iter().product::<usize>())
                .sum(),
            windows: (self.windows.training_windows(), self.windows.validation().len()),
            validation_variance: self.over(self.windows.validation(), |inputs| {
                f64::from(values(mean_square(inputs.y))[0])
            }),
            finished,
        };
        if finished {
            let names = self.network.tensors();
            let tensors: BTreeMap<String, weights::Tensor> = names
                .into_iter()
                .filter_map(|(name, shape)| {
                    let values = self.now.best.get(&name)?.values.clone();
                    Some((name, weights::Tensor { shape, values }))
                })
                .collect();
            let file = Weights { head: outcome.head.clone(), tensors };
            let out = self.request.out;
            let bytes = file.to_bytes().map_err(|why| LearnError::write(out, why))?;
            self.request.outputs.reserve_with_folder(out, "--out")?.write(&bytes)?;
        }
        Ok(outcome)
    }

    fn head(&self, data: &Dataset, regime_scale: f64) -> Head {
        let state = &self.now.state;
        let masked = &self.request.config.masked;
        let masked = data.channel_names.iter().filter(|n| masked.contains(n)).cloned().collect();
        Head {
            format: FORMAT,
            model: self.request.config.model.name().to_owned(),
            config: self.network.config(),
            channel_names: data.channel_names.clone(),
            output_names: data.output_names.clone(),
            normalisation: self.windows.normalisation.written(masked, regime_scale),
            rate_hz: 1.0 / TICK_S,
            m_bar: data.nominal_inertia.clone(),
            data_hash: state.data_hash.clone(),
            git: self.request.git.to_owned(),
            seed: state.seed,
            training: state.training(),
            acceptance: Acceptance::default(),
        }
    }

    /// The basis of the regime, from its second moment over the training windows.
    fn basis(&self) -> Basis {
        let leaves = Leaves::new(&self.now.best, false);
        let places = self.windows.epoch(self.request.seed, 0, REGIME_STRIDE);
        let d_k = self.request.config.d_k;
        let parts = places.chunks(self.request.config.batch).map(|part| {
            let inputs = self.inputs(&self.windows.batch(part, None), false, 1.0);
            let regimes = values(self.network.forward(&leaves, inputs.x).regime);
            second_moment(&regimes, d_k, places.len())
        });
        let moment = parts.fold(DMatrix::zeros(d_k, d_k), |sum, part| sum + part);
        match self.request.config.model {
            ModelKind::Fdt => Basis::of(&moment),
            _ => Basis::unturned(&moment),
        }
    }
}
