//! Builds the predictor of any model from a file of weights.

use super::baselines::{Gp, Sindy, gp, sindy};
use super::nn::Precision;
use super::nn::kernels::Kernel;
use super::weights::{ModelKind, Weights, WeightsError};
use super::{Fdt, Predictor, learned};

/// Names of the models that fly from a file, as in its head.
pub const MODELS: &str = "fdt, lstm, transformer, gpt2, neural_fly, mlp, ridge, sindy or gp";

/// A predictor and its number of learned parameters.
pub struct Trained {
    /// The predictor.
    pub predictor: Box<dyn Predictor>,
    /// Number of learned parameters, without those that the method sets to zero.
    pub parameters: usize,
}

/// The predictor for `weights`. `kernel` and `precision` apply to the FDT; the other models are small and use the plain form.
///
/// # Errors
/// [`WeightsError`] if the weights belong to an unknown model or another vehicle, or if a tensor is wrong.
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
