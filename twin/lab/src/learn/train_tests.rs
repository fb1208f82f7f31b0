//! Training reduces the loss, resumes where it stopped, and writes weights whose forecast in flight equals that of the training.

use std::ops::ControlFlow;

use burn_tensor::{Tensor, TensorData};
use tempfile::TempDir;

use super::checkpoint::{Checkpoint, path_for};
use super::config::{Architecture, TrainConfig};
use super::device::device;
use super::graph::{Leaves, exclusive, values};
use super::line::Line;
use super::made::{dataset, tiny};
use super::parameters::Parameters;
use super::train::{Outcome, Progress, Request, network, train};
use super::windows::{Windows, generator};
use super::{Dataset, LearnError};
use twin_core::elementary::squared;
use twin_core::residual::weights::{ModelKind, Weights};
use twin_core::residual::{fdt, learned};
use twin_record::Outputs;

/// Two orders of summation in f32, for numbers of order one.
const PARITY: f32 = 1e-5;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder for temporary files")
}

fn run(
    data: &Dataset,
    config: &TrainConfig,
    out: &std::path::Path,
    resume: bool,
    stop_after: usize,
) -> Result<Outcome, LearnError> {
    let outputs = Outputs::default();
    let request = Request { config, seed: 3, resume, out, outputs: &outputs, git: "test" };
    train(data, &request, &mut |progress: Progress| {
        if progress.finished.is_some() && progress.epoch >= stop_after {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    })
}

#[test]
fn a_small_training_learns_a_linear_system() {
    let (data, config) = (dataset(2, 1200), TrainConfig { epochs: 12, ..tiny() });
    let folder = folder();
    let out = folder.path().join("w.safetensors");
    let outcome = run(&data, &config, &out, false, usize::MAX).unwrap();
    let loss = outcome.head.training.validation_loss.unwrap();
    // A forecast of the mean has the variance as its loss. The inputs determine the residual, so the rest is what a dozen epochs leave.
    assert!(loss < 0.1 * outcome.validation_variance, "{loss} of {}", outcome.validation_variance);
    let read = Weights::from_bytes(&std::fs::read(&out).unwrap()).unwrap();
    assert_eq!(read.head, outcome.head);
    assert_eq!(read.head.normalisation.masked, ["chi.x"]);
    assert_eq!(read.head.data_hash, data.hash());
    // The regime has a mean squared norm of 8 over the training windows; here other windows of the same flights are used.
    let model = fdt::Model::new(&read).unwrap();
    let windows = Windows::new(&data, &config).unwrap();
    let places = windows.epoch(9, 1, 7);
    let power = places.iter().map(|place| {
        let regime = model.forward(&windows.batch(&[*place], None).x).regime;
        regime
            .iter()
            .map(|g| squared(f64::from(*g) * read.head.normalisation.regime_scale))
            .sum::<f64>()
    });
    let mean = power.sum::<f64>() / places.len() as f64;
    assert!((mean - 8.0).abs() < 0.8, "{mean}");
}

#[test]
fn a_training_that_was_stopped_goes_on_to_the_same_bits() {
    let (data, config, folder) = (dataset(2, 300), tiny(), folder());
    let [whole, halves] =
        ["whole", "halves"].map(|name| folder.path().join(format!("{name}.safetensors")));
    run(&data, &config, &whole, false, usize::MAX).unwrap();
    let stopped = run(&data, &config, &halves, false, 2).unwrap();
    assert!(!stopped.finished && !halves.exists() && stopped.curve.len() == 3);
    run(&data, &config, &halves, true, usize::MAX).unwrap();
    let read = |path| Weights::from_bytes(&std::fs::read(path).unwrap()).unwrap();
    let (a, b) = (read(&whole), read(&halves));
    assert_eq!(a.tensors, b.tensors);
    let losses = |w: &Weights| (w.head.training.train_loss, w.head.training.validation_loss);
    assert_eq!(losses(&a), losses(&b));
    let last = |path| {
        let windows = Windows::new(&data, &config).unwrap();
        let shapes = network(&config, &windows).tensors();
        let like = Parameters::initial(&shapes, &mut generator(0, 0, 0));
        Checkpoint::read(&path_for(path), &like).unwrap()
    };
    let (a, b) = (last(&whole), last(&halves));
    assert_eq!((a.weights, a.adam), (b.weights, b.adam));
    // Another seed, or other data, is another training.
    let other = run(&dataset(2, 301), &config, &halves, true, 9).unwrap_err().to_string();
    assert!(other.contains("another training: the data hash"), "{other}");
}

#[test]
fn a_loss_that_is_no_number_ends_the_training_and_leaves_the_checkpoint() {
    let (data, config) = (dataset(1, 300), tiny());
    let folder = folder();
    let out = folder.path().join("w.safetensors");
    run(&data, &config, &out, false, 1).unwrap();
    let windows = Windows::new(&data, &config).unwrap();
    let like = Parameters::initial(&network(&config, &windows).tensors(), &mut generator(0, 0, 0));
    let mut broken = Checkpoint::read(&path_for(&out), &like).unwrap();
    broken.weights.0[0].values.fill(f32::NAN);
    broken.write(&path_for(&out)).unwrap();
    let before = std::fs::read(path_for(&out)).unwrap();
    let error = run(&data, &config, &out, true, 9).unwrap_err().to_string();
    assert!(error.contains("epoch 2") && error.contains("learning_rate"), "{error}");
    assert!(!out.exists() && std::fs::read(path_for(&out)).unwrap() == before);
}

/// A file of weights after one epoch, and a batch of its windows with the forecast that burn gives.
fn untrained(config: &TrainConfig) -> (Weights, Windows, Vec<f32>, Vec<f32>) {
    let data = dataset(2, 300);
    let windows = Windows::new(&data, config).expect("flights long enough");
    let folder = folder();
    let out = folder.path().join("w.safetensors");
    // One epoch at a rate that changes every tensor.
    run(&data, &TrainConfig { epochs: 1, learning_rate: 1e-2, ..config.clone() }, &out, false, 9)
        .expect("a training of one epoch");
    let bytes = std::fs::read(&out).expect("the file that the training wrote");
    let read = Weights::from_bytes(&bytes).expect("weights as the training writes them");
    let parameters = Parameters(
        read.tensors
            .iter()
            .map(|(name, t)| super::parameters::Parameter {
                name: name.clone(),
                shape: t.shape.clone(),
                values: t.values.clone(),
            })
            .collect(),
    );
    let _one_thread = exclusive();
    let batch = windows.batch(&windows.epoch(1, 0, 20), None);
    let shape = [batch.size(), windows.channels, config.t_long];
    let x: Tensor<3> = Tensor::from_data(TensorData::new(batch.x, shape), &device(false));
    let said = network(config, &windows).forward(&Leaves::new(&parameters, false), x);
    (read, windows, values(said.forecast), values(said.regime))
}

fn same(ours: &[f32], theirs: &[f32], what: &str) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= PARITY * b.abs().max(1.0), "{what}: {a} and {b}");
    }
}

#[test]
fn the_fdt_and_its_ablations_fly_as_they_were_trained() {
    let parts = [(true, true, true), (false, true, true), (true, false, true), (true, true, false)];
    let both = [Architecture::Paper, Architecture::Skip];
    for ((global_token, short_horizon, long_memory), architecture) in
        parts.into_iter().flat_map(|parts| both.map(|one| (parts, one)))
    {
        let flags = TrainConfig { global_token, short_horizon, long_memory, ..tiny() };
        let config = TrainConfig { architecture, layers: 2, ..flags };
        let (weights, windows, forecast, regime) = untrained(&config);
        let model = fdt::Model::new(&weights).unwrap();
        let said: Vec<fdt::Output> = windows
            .epoch(1, 0, 20)
            .iter()
            .map(|place| model.forward(&windows.batch(&[*place], None).x))
            .collect();
        let ours: Vec<f32> = said.iter().flat_map(|s| s.residual.clone()).collect();
        let regimes: Vec<f32> = said.iter().flat_map(|s| s.regime.clone()).collect();
        let what = format!("{global_token} {short_horizon} {long_memory} {}", architecture.name());
        same(&ours, &forecast, &what);
        same(&regimes, &regime, "regime");
    }
}

#[test]
fn every_baseline_flies_as_it_was_trained() {
    for model in ModelKind::ALL.into_iter().filter(|model| *model != ModelKind::Fdt) {
        let config = TrainConfig { model, layers: 2, t_short: 1, t_long: 6, ..tiny() };
        let (weights, windows, forecast, regime) = untrained(&config);
        let (_, network) = learned::network(&weights).unwrap();
        let said: Vec<(Vec<f32>, Vec<f32>)> = windows
            .epoch(1, 0, 20)
            .iter()
            .map(|place| network.forward(&windows.batch(&[*place], None).x))
            .collect();
        let ours: Vec<f32> = said.iter().flat_map(|s| s.0.clone()).collect();
        let regimes: Vec<f32> = said.iter().flat_map(|s| s.1.clone()).collect();
        same(&ours, &forecast, model.name());
        same(&regimes, &regime, model.name());
    }
}

#[test]
fn every_baseline_learns_the_linear_system() {
    let data = dataset(2, 800);
    for model in ModelKind::ALL.into_iter().filter(|model| *model != ModelKind::Fdt) {
        let config = TrainConfig { model, epochs: 12, t_short: 1, t_long: 6, ..tiny() };
        let folder = folder();
        let out = folder.path().join("w.safetensors");
        let outcome = run(&data, &config, &out, false, usize::MAX).unwrap();
        let loss = outcome.head.training.validation_loss.unwrap();
        let most = 0.2 * outcome.validation_variance;
        assert!(loss < most, "{}: {loss}, at most {most}", model.name());
    }
}

#[test]
fn a_ridge_regression_is_solved_without_epochs_and_its_file_tells_how() {
    let (data, folder) = (dataset(2, 600), folder());
    let out = folder.path().join("w.safetensors");
    let config = TrainConfig { model: ModelKind::Ridge, t_short: 1, t_long: 6, ..tiny() };
    let outcome = run(&data, &config, &out, false, usize::MAX).unwrap();
    let line = Line::of(&Windows::new(&data, &config).unwrap(), config.t_long).unwrap();
    let training = &outcome.head.training;
    assert_eq!((training.epochs, training.steps, training.best_epoch), (0, 0, 0));
    assert_eq!(training.ridge_penalty, Some(line.penalty));
    assert_eq!(outcome.curve.len(), 1);
    let read = Weights::from_bytes(&std::fs::read(&out).unwrap()).unwrap();
    assert_eq!(read.tensors["readout.weight"].values, line.weight);
    assert_eq!(read.tensors["readout.bias"].values, line.bias);
    // A resumed training has nothing left to do, and gives the same file.
    let first = std::fs::read(&out).unwrap();
    std::fs::remove_file(&out).unwrap();
    run(&data, &config, &out, true, usize::MAX).unwrap();
    assert!(std::fs::read(&out).unwrap() == first);
}

#[test]
fn a_skip_that_learns_nothing_better_is_the_line_of_best_fit() {
    let (data, folder) = (dataset(2, 600), folder());
    let out = folder.path().join("w.safetensors");
    // At this rate one epoch spoils the weights.
    let config = TrainConfig { epochs: 1, learning_rate: 0.5, warm_up_epochs: 0.0, ..tiny() };
    let outcome = run(&data, &config, &out, false, usize::MAX).unwrap();
    let [start, spoiled] = [0, 1].map(|at| outcome.curve[at].validation_loss);
    assert!(start < spoiled, "{start} {spoiled}");
    assert_eq!(outcome.head.training.best_epoch, 0);
    let read = Weights::from_bytes(&std::fs::read(&out).unwrap()).unwrap();
    let windows = Windows::new(&data, &config).unwrap();
    let line = Line::of(&windows, config.t_skip).unwrap();
    assert_eq!(read.tensors["skip.weight"].values, line.weight);
    let model = fdt::Model::new(&read).unwrap();
    let batch = windows.batch(&windows.validation()[..1], None);
    let inputs = windows.channels * config.t_skip;
    let last =
        |channel: usize| &batch.x[(channel + 1) * config.t_long - config.t_skip..][..config.t_skip];
    let x: Vec<f32> = (0..windows.channels).flat_map(last).copied().collect();
    let rows = line.weight.chunks_exact(inputs).zip(&line.bias);
    let wanted: Vec<f32> = rows
        .map(|(row, bias)| row.iter().zip(&x).map(|(w, x)| w * x).sum::<f32>() + bias)
        .collect();
    same(&model.forward(&batch.x).residual, &wanted, "the line");
}
