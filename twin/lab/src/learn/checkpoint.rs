//! The state of a training after an epoch: weights, best weights so far, both moments of the optimiser, the curve.
//!
//! A checkpoint is one safetensors file, written whole or not at all. Random numbers are functions of seed and epoch, so the file
//! holds no generator. A training that resumes from a checkpoint gives the same bits as one that was never stopped, on the same
//! machine and with the same number of threads.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use safetensors::{Dtype, SafeTensors, View};
use serde::{Deserialize, Serialize};

use super::LearnError;
use super::adam::Adam;
use super::config::TrainConfig;
use super::file::write_whole;
use super::parameters::{Parameter, Parameters};
use twin_core::residual::weights::Training;
use twin_input::budget::CHECKPOINT_BYTES;

/// Key of the state in the file's metadata.
const KEY: &str = "twin.checkpoint";

/// Prefixes of the four sets of tensors.
const SETS: [&str; 4] = ["weights/", "best/", "first/", "second/"];

/// One epoch of the curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpochRecord {
    /// Number of the epoch, from 1; 0 is the solution in closed form, from which the epochs start.
    pub epoch: usize,
    /// Mean squared z-score over the training windows, with noise.
    pub train_loss: f64,
    /// Mean squared z-score over the validation windows, without noise.
    pub validation_loss: f64,
    /// Learning rate of the last step.
    pub learning_rate: f64,
    /// Time of the epoch, s.
    pub wall_s: f64,
}

/// The part of a checkpoint that is not tensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainState {
    /// Configuration of the training.
    pub config: TrainConfig,
    /// Seed.
    pub seed: u64,
    /// Hash of the data.
    pub data_hash: String,
    /// Steps of the optimiser.
    pub steps: u64,
    /// The curve so far.
    pub curve: Vec<EpochRecord>,
    /// Epoch of the best validation loss; 0 before the first, or if none was better than the solution in closed form.
    pub best_epoch: usize,
    /// Weight of the squared coefficients in the ridge regression that was solved; `None` if there was none.
    #[serde(default)]
    pub ridge_penalty: Option<f64>,
}

impl TrainState {
    /// Number of epochs that are done.
    pub fn epochs(&self) -> usize {
        self.curve.last().map_or(0, |record| record.epoch)
    }

    /// The record of the training for the head of a file.
    pub fn training(&self) -> Training {
        let best = self.curve.iter().find(|record| record.epoch == self.best_epoch);
        Training {
            epochs: self.epochs() as u64,
            steps: self.steps,
            batch: self.config.batch as u64,
            best_epoch: self.best_epoch as u64,
            train_loss: best.map(|record| record.train_loss),
            validation_loss: best.map(|record| record.validation_loss),
            wall_s: self.curve.iter().map(|record| record.wall_s).sum(),
            ridge_penalty: self.ridge_penalty,
        }
    }
}

/// A checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The part that is not tensors.
    pub state: TrainState,
    /// The weights after the last epoch.
    pub weights: Parameters,
    /// The weights of the best epoch.
    pub best: Parameters,
    /// The optimiser.
    pub adam: Adam,
}

/// Path of the checkpoint that belongs to the file of weights `out`: `W.checkpoint` for `W.safetensors`.
pub fn path_for(out: &Path) -> PathBuf {
    out.with_extension("checkpoint")
}

struct Raw(Vec<usize>, Vec<u8>);

impl View for Raw {
    fn dtype(&self) -> Dtype {
        Dtype::F32
    }
    fn shape(&self) -> &[usize] {
        &self.0
    }
    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(&self.1)
    }
    fn data_len(&self) -> usize {
        self.1.len()
    }
}

impl Checkpoint {
    /// Writes the checkpoint to `path` and replaces the one before.
    ///
    /// # Errors
    /// [`LearnError`] if the write fails; the checkpoint before it is then intact.
    pub fn write(&self, path: &Path) -> Result<(), LearnError> {
        write_whole(path, &self.to_bytes(path)?)
    }

    /// The checkpoint as the content of the file `path`.
    ///
    /// # Errors
    /// [`LearnError::File`] if it has no such form.
    pub fn to_bytes(&self, path: &Path) -> Result<Vec<u8>, LearnError> {
        let sets = [&self.weights, &self.best, &self.adam.first, &self.adam.second];
        let tensors = SETS.iter().zip(sets).flat_map(|(prefix, set)| {
            set.0.iter().map(move |p| {
                let bytes = p.values.iter().flat_map(|v| v.to_le_bytes()).collect();
                (format!("{prefix}{}", p.name), Raw(p.shape.clone(), bytes))
            })
        });
        let state =
            serde_json::to_string(&self.state).map_err(|why| LearnError::write(path, why))?;
        let metadata = HashMap::from([(KEY.to_owned(), state)]);
        safetensors::serialize(tensors, Some(metadata)).map_err(|why| LearnError::write(path, why))
    }

    /// Reads a checkpoint whose weights have the names and shapes of `like`.
    ///
    /// # Errors
    /// [`LearnError`] if the file is missing or damaged, or belongs to another model.
    pub fn read(path: &Path, like: &Parameters) -> Result<Self, LearnError> {
        let unusable = |why: &dyn std::fmt::Display| LearnError::read(path, why);
        let bytes = twin_input::file::read(path, CHECKPOINT_BYTES).map_err(|why| unusable(&why))?;
        let (_, metadata) = SafeTensors::read_metadata(&bytes).map_err(|why| unusable(&why))?;
        let text = metadata
            .metadata()
            .as_ref()
            .and_then(|pairs| pairs.get(KEY))
            .ok_or_else(|| unusable(&"not a checkpoint of `twin train`"))?;
        let state: TrainState = serde_json::from_str(text).map_err(|why| unusable(&why))?;
        let file = SafeTensors::deserialize(&bytes).map_err(|why| unusable(&why))?;
        let mut sets = Vec::new();
        for prefix in SETS {
            let one = |p: &Parameter| {
                let name = format!("{prefix}{}", p.name);
                let view = file.tensor(&name).map_err(|why| unusable(&why))?;
                if view.dtype() != Dtype::F32 || view.shape() != p.shape {
                    let found = format!("{name} is {:?} {:?}", view.dtype(), view.shape());
                    return Err(unusable(&format!("{found}, expected F32 {:?}", p.shape)));
                }
                let four = view.data().as_chunks::<4>().0.iter();
                let values = four.map(|bytes| f32::from_le_bytes(*bytes)).collect();
                Ok(Parameter { values, ..p.clone() })
            };
            sets.push(Parameters(like.0.iter().map(one).collect::<Result<_, _>>()?));
        }
        let [weights, best, first, second] =
            <[Parameters; 4]>::try_from(sets).map_err(|_| unusable(&"sets of tensors"))?;
        let adam = Adam { first, second, steps: state.steps };
        Ok(Self { state, weights, best, adam })
    }

    /// Refuses to resume a training with other settings, another seed or other data.
    ///
    /// # Errors
    /// [`LearnError::OtherTraining`], which names the difference.
    pub fn check_same(
        &self,
        path: &Path,
        config: &TrainConfig,
        seed: u64,
        data_hash: &str,
    ) -> Result<(), LearnError> {
        let differs = |what, found: String, expected: String| {
            if found == expected {
                return Ok(());
            }
            Err(LearnError::OtherTraining { path: path.to_owned(), what, found, expected })
        };
        let settings = |config: &TrainConfig| serde_json::to_string(config).unwrap_or_default();
        differs("the data hash", self.state.data_hash.clone(), data_hash.to_owned())?;
        differs("the seed", self.state.seed.to_string(), seed.to_string())?;
        differs("the configuration", settings(&self.state.config), settings(config))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::windows::generator;

    fn checkpoint() -> Checkpoint {
        let shapes = [("a.weight".to_owned(), vec![3, 2]), ("b.bias".to_owned(), vec![3])];
        let weights = Parameters::initial(&shapes, &mut generator(1, 0, 0));
        let record = EpochRecord {
            epoch: 1,
            train_loss: 0.1,
            validation_loss: 1.0 / 3.0,
            learning_rate: 1e-3,
            wall_s: 0.5,
        };
        let state = TrainState {
            config: TrainConfig::default(),
            seed: 3,
            data_hash: "ab".to_owned(),
            steps: 7,
            curve: vec![record],
            best_epoch: 1,
            ridge_penalty: Some(1e-9),
        };
        let mut adam = Adam::new(&weights);
        adam.step(&mut weights.clone(), &[vec![0.3; 6], vec![-0.1; 3]], 1e-3, 1.0);
        adam.steps = 7;
        Checkpoint { state, best: weights.clone(), weights, adam }
    }

    #[test]
    fn what_is_read_is_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let (written, path) = (checkpoint(), folder.path().join("w.checkpoint"));
        written.write(&path).unwrap();
        assert_eq!(Checkpoint::read(&path, &written.weights).unwrap(), written);
    }

    #[test]
    fn a_cut_or_foreign_file_and_another_training_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (one, path) = (checkpoint(), folder.path().join("w.checkpoint"));
        one.write(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in [0, 5, 40, whole.len() - 1] {
            std::fs::write(&path, &whole[..length]).unwrap();
            let error = Checkpoint::read(&path, &one.weights).unwrap_err().to_string();
            assert!(error.contains("w.checkpoint") && error.contains("read"), "{error}");
        }
        let same = |seed, hash| one.check_same(&path, &TrainConfig::default(), seed, hash);
        assert!(same(3, "ab").is_ok());
        assert!(same(4, "ab").unwrap_err().to_string().contains("the seed was 3, now it is 4"));
        assert!(same(3, "cd").unwrap_err().to_string().contains("the data hash"));
    }
}
