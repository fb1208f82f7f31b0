//! The entrants of the prediction table: a predictor with its adapter, by name as a scenario would configure it, or from weights.

use std::path::{Path, PathBuf};

use super::replay::Entrant;
use super::series::EvaluateError;
use twin_core::residual::lra;
use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::trained::{MODELS, Trained, predictor};
use twin_core::residual::weights::{Weights, WeightsError};
use twin_core::tuning::Tuning;
use twin_scenario::Scenario;

/// Entrants without weights: name, label, `predictor.kind`, whether the adapter is on.
const UNTRAINED: [(&str, &str, &str, bool); 7] = [
    ("persistence", "persistence r_{t-1} (TDC)", "persistence", false),
    ("tdc_extrapolated", "TDC along its fading slope", "tdc_extrapolated", false),
    ("arx_rls", "ARX, learned in flight by RLS", "arx_rls", false),
    ("gravity", "gravity of the empty vehicle", "gravity", false),
    ("bias", "gravity + adapted bias", "bias", true),
    ("random_features", "random features + LRA", "random_features", true),
    ("zero", "zero", "none", false),
];

/// Entrants with weights: model, name, label, whether the adapter is on, and RMSE, R² and ms of the paper.
const TRAINED: [(&str, &str, &str, bool, Paper); 10] = [
    ("ridge", "ridge", "ridge regression", false, None),
    ("sindy", "sindy", "SINDy (SysID)", false, Some([1.363, 0.207, 0.01])),
    ("gp", "gp", "GP", false, Some([0.84, 0.493, 17.20])),
    ("lstm", "lstm", "LSTM", false, Some([0.76, 0.576, 1.20])),
    ("transformer", "transformer", "Transformer (causal)", false, Some([0.67, 0.623, 4.10])),
    ("gpt2", "gpt2", "GPT-2 style", false, None),
    ("neural_fly", "neural_fly", "Neural-Fly", false, Some([0.48, 0.761, 9.50])),
    ("mlp", "mlp", "MLP (last layer)", false, Some([0.41, 0.802, 4.50])),
    ("fdt", "fdt", "FDT", false, Some([0.29, 0.912, 1.86])),
    ("fdt", "fdt_lra", "FDT + LRA", true, Some([0.21, 0.972, 3.02])),
];

/// RMSE, R² and inference in ms of `tab:prediction_results`.
pub type Paper = Option<[f64; 3]>;

/// The lines of the paper's table that `rows` do not contain, in its order: label and figures.
pub fn unfilled(rows: &[String]) -> Vec<(&'static str, [f64; 3])> {
    let missing = TRAINED.iter().filter(|(_, row, ..)| !rows.iter().any(|filled| filled == row));
    missing.filter_map(|(_, _, label, _, paper)| Some((*label, (*paper)?))).collect()
}

/// An entrant before its replay.
pub struct Candidate {
    /// Name for `--models` and for JSON.
    pub name: String,
    /// Label that people read.
    pub label: String,
    /// Number of learned parameters; `None` if nothing was learned.
    pub parameters: Option<usize>,
    /// Hash of the training data, from the file of weights.
    pub trained_on: Option<String>,
    /// The file of weights.
    pub weights: Option<PathBuf>,
    /// Figures of the paper.
    pub paper: Paper,
    /// The predictor with its adapter.
    pub entrant: Entrant,
}

/// Names of the entrants without weights.
pub fn untrained_names() -> Vec<&'static str> {
    UNTRAINED.iter().map(|(name, ..)| *name).collect()
}

/// The entrant without weights called `name`, for the vehicle of `scenario` with `overrides` of its keys.
///
/// # Errors
/// [`EvaluateError`] for an unknown name or a vehicle that cannot be built.
pub fn untrained(
    name: &str,
    scenario: &Path,
    overrides: &[String],
) -> Result<Candidate, EvaluateError> {
    let found = UNTRAINED.iter().find(|(known, ..)| *known == name);
    let Some((_, label, kind, adapted)) = found else {
        let known = untrained_names().join(", ");
        return Err(EvaluateError::UnknownRow { name: name.to_owned(), known });
    };
    let keys = [overrides, &[format!("predictor.kind={kind}")]].concat();
    let scenario = Scenario::load(scenario, &keys)?;
    let parts = scenario.parts()?;
    let settings = lra::Settings { enabled: *adapted, ..parts.tuning.adapter };
    Ok(Candidate {
        name: name.to_owned(),
        label: (*label).to_owned(),
        parameters: None,
        trained_on: None,
        weights: None,
        paper: None,
        entrant: Entrant {
            predictor: parts.predictor,
            adapter: parts.adapter,
            settings,
            history_len: parts.history_len,
        },
    })
}

/// The entrants of the weights in `file`; `tuning` sets their adapter.
///
/// # Errors
/// [`EvaluateError`] if the model has no forward pass here, or the weights cannot be used.
pub fn trained(
    weights: &Weights,
    file: &Path,
    tuning: &Tuning,
) -> Result<Vec<Candidate>, EvaluateError> {
    let failed = |why| EvaluateError::Weights { path: file.to_owned(), why };
    let rows: Vec<_> = TRAINED.iter().filter(|(model, ..)| *model == weights.head.model).collect();
    if rows.is_empty() {
        return Err(failed(WeightsError::Model {
            found: weights.head.model.clone(),
            expected: MODELS,
        }));
    }
    rows.into_iter()
        .map(|(_, name, label, adapted, paper)| {
            let Trained { predictor, parameters } =
                predictor(weights, Kernel::best(), Precision::F32).map_err(failed)?;
            let adapter =
                lra::Adapter::new(predictor.regime_len(), predictor.info().scale, &tuning.adapter);
            Ok(Candidate {
                name: (*name).to_owned(),
                label: (*label).to_owned(),
                parameters: Some(parameters),
                trained_on: Some(weights.head.data_hash.clone()),
                weights: Some(file.to_owned()),
                paper: *paper,
                entrant: Entrant {
                    history_len: predictor.history_len(),
                    predictor,
                    adapter,
                    settings: lra::Settings { enabled: *adapted, ..tuning.adapter },
                },
            })
        })
        .collect()
}
