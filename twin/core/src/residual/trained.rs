//! From a file of weights to the predictor it is of, whichever model that is.

use super::baselines::{Gp, Sindy, gp, sindy};
use super::nn::Precision;
use super::nn::kernels::Kernel;
use super::weights::{ModelKind, Weights, WeightsError};
use super::{Fdt, Predictor, learned};

/// Models that fly from a file, as its head names them.
pub const MODELS: &str = "fdt, lstm, transformer, gpt2, neural_fly, mlp, sindy or gp";

/// A predictor and the count of its learned numbers.
pub struct Trained {
    /// What predicts.
    pub predictor: Box<dyn Predictor>,
    /// Learned numbers that are not zero by choice of the method.
    pub parameters: usize,
}

/// The predictor of `weights`; `kernel` and `precision` are those of the FDT, the others are small and computed as they are.
///
/// # Errors
/// [`WeightsError`] if they are of no known model or of another vehicle, or a tensor is not what it must be.
pub fn predictor(
    weights: &Weights,
    kernel: Kernel,
    precision: Precision,
) -> Result<Trained, WeightsError> {
    let all = weights.tensors.values().map(|tensor| tensor.values.len()).sum();
    let (predictor, parameters): (Box<dyn Predictor>, usize) = match weights.head.model.as_str() {
        sindy::NAME => {
            let model = Sindy::new(weights)?;
            let parameters = model.parameters();
            (Box::new(model), parameters)
        }
        gp::NAME => {
            let model = Gp::new(weights)?;
            let parameters = model.parameters();
            (Box::new(model), parameters)
        }
        word => match ModelKind::named(word) {
            Some(ModelKind::Fdt) => (Box::new(Fdt::new(weights, kernel, precision)?), all),
            Some(_) => (Box::new(learned::Baseline::new(weights)?), all),
            None => {
                return Err(WeightsError::Model { found: word.to_owned(), expected: MODELS });
            }
        },
    };
    Ok(Trained { predictor, parameters })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_of_models_names_every_one() {
        let words: Vec<&str> = MODELS.split(", ").flat_map(|part| part.split(" or ")).collect();
        let trained = ModelKind::ALL.map(ModelKind::name);
        assert_eq!(words, [&trained[..], &[sindy::NAME, gp::NAME]].concat());
    }
}
