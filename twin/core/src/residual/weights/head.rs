//! The head of a file of weights: the JSON under its metadata key `twin`.

use serde::{Deserialize, Serialize};

use super::WeightsError;
use crate::notation::{COORDINATE_NAMES, Coords, N};

/// Format of the head that this program reads and writes.
pub const FORMAT: u32 = 1;

/// Relative difference up to which two nominal inertias count as equal; both are decimal numbers from a table.
const INERTIA_TOLERANCE: f64 = 1e-6;

/// Difference up to which two rates count as equal, Hz.
const RATE_TOLERANCE_HZ: f64 = 1e-6;

/// The head of a file of weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// Format number, [`FORMAT`].
    pub format: u32,
    /// Name of the model: a [`super::ModelKind`], `sindy` or `gp`.
    pub model: String,
    /// Sizes and flags of the model; for `fdt` an [`super::FdtConfig`].
    pub config: serde_json::Value,
    /// Names of the input channels in order, see [`channel_names`].
    pub channel_names: Vec<String>,
    /// Names of the residual's coordinates in order, see [`output_names`].
    pub output_names: Vec<String>,
    /// Statistics of the training data.
    #[serde(flatten)]
    pub normalisation: Normalisation,
    /// Rate of the history, Hz.
    pub rate_hz: f64,
    /// Diagonal of the nominal inertia `M_bar` in every residual of the training data, kg and kg m².
    pub m_bar: Vec<f64>,
    /// SHA-256 of the training data, hexadecimal.
    pub data_hash: String,
    /// Version of the program that trained the weights.
    pub git: String,
    /// Seed of the training.
    pub seed: u64,
    /// Record of the training.
    pub training: Training,
    /// Scores of the weights in flight.
    pub acceptance: Acceptance,
}

/// Statistics of the training data, which convert physical units to z-scores and back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Normalisation {
    /// Names of the channels whose z-score is set to zero.
    pub masked: Vec<String>,
    /// Mean of each input channel, in its unit.
    pub input_mean: Vec<f64>,
    /// Standard deviation of each input channel, in its unit.
    pub input_std: Vec<f64>,
    /// Mean of each coordinate of the residual, N and N m.
    pub output_mean: Vec<f64>,
    /// Standard deviation of each coordinate of the residual, N and N m.
    pub output_std: Vec<f64>,
    /// Factor on the regime `g'` that the adapter receives: it makes the mean squared norm over the training windows 8.
    pub regime_scale: f64,
}

/// Record of a training.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Training {
    /// Number of epochs.
    pub epochs: u64,
    /// Number of optimiser steps.
    pub steps: u64,
    /// Windows per step.
    pub batch: u64,
    /// Epoch that gave these weights; 0 if the solution in closed form, from which the epochs start, was not improved.
    pub best_epoch: u64,
    /// Mean squared z-scored error over the training windows.
    pub train_loss: Option<f64>,
    /// Mean squared z-scored error over the validation windows.
    pub validation_loss: Option<f64>,
    /// Duration of the training, s of wall-clock time.
    pub wall_s: f64,
    /// Weight of the squared coefficients in the ridge regression that the training solved; `None` if it solved none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ridge_penalty: Option<f64>,
}

/// R² of the base forecast, flown in closed loop without the adapter; `None` if it was not flown.
///
/// The R² over both flights together decides. In a hover alone the residual varies little more than the noise of its measurement,
/// and R² divides by that variance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Acceptance {
    /// R² over the ticks of both flights.
    pub r2: Option<f64>,
    /// R² in the hover alone.
    pub hover_r2: Option<f64>,
    /// R² on the figure-8 alone.
    pub figure_eight_r2: Option<f64>,
}

impl Acceptance {
    /// The R² over both flights must exceed this value.
    pub const LEAST_R2: f64 = 0.8;

    /// True if the weights completed both flights and exceed [`Acceptance::LEAST_R2`].
    pub fn passed(&self) -> bool {
        self.r2.is_some_and(|r2| r2 > Self::LEAST_R2)
    }
}

impl std::fmt::Display for Acceptance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let words =
            |r2: Option<f64>| r2.map_or_else(|| "not flown".to_owned(), |r2| format!("{r2:.3}"));
        write!(
            f,
            "closed-loop R² {} (hover alone {}, figure-8 alone {})",
            words(self.r2),
            words(self.hover_r2),
            words(self.figure_eight_r2)
        )
    }
}

/// Names of a predictor's input channels: `chi`, `chi_dot` and the force of the previous tick.
pub fn channel_names() -> Vec<String> {
    ["chi", "chi_dot", "tau"]
        .iter()
        .flat_map(|stem| COORDINATE_NAMES.iter().map(move |row| format!("{stem}.{row}")))
        .collect()
}

/// Names of the residual's coordinates.
pub fn output_names() -> Vec<String> {
    COORDINATE_NAMES.iter().map(|row| (*row).to_owned()).collect()
}

impl Head {
    /// Checks format, lengths and numbers of the head, which do not depend on the model.
    pub(super) fn check(&self) -> Result<(), WeightsError> {
        if self.format != FORMAT {
            return Err(WeightsError::Format { found: self.format, expected: FORMAT });
        }
        let (inputs, outputs) = (self.channel_names.len(), self.output_names.len());
        let n = &self.normalisation;
        let lists = [
            ("input_mean", &n.input_mean, inputs),
            ("input_std", &n.input_std, inputs),
            ("output_mean", &n.output_mean, outputs),
            ("output_std", &n.output_std, outputs),
            ("m_bar", &self.m_bar, outputs),
        ];
        for (key, list, expected) in lists {
            if list.len() != expected {
                return Err(WeightsError::Length { key, found: list.len(), expected });
            }
            let positive = key.ends_with("std") || key == "m_bar";
            let wrong = |value: &f64| !value.is_finite() || (positive && *value <= 0.0);
            if let Some(index) = list.iter().position(wrong) {
                let expected = if positive { "a finite value above 0" } else { "a finite value" };
                return Err(WeightsError::Number { key, index, found: list[index], expected });
            }
        }
        for (key, found) in [("regime_scale", n.regime_scale), ("rate_hz", self.rate_hz)] {
            if !(found.is_finite() && found > 0.0) {
                let expected = "a finite value above 0";
                return Err(WeightsError::Number { key, index: 0, found, expected });
            }
        }
        Ok(())
    }

    /// Checks that the weights belong to `model`.
    ///
    /// # Errors
    /// [`WeightsError::Model`] if they belong to another model.
    pub fn check_model(&self, model: &'static str) -> Result<(), WeightsError> {
        if self.model == model {
            return Ok(());
        }
        Err(WeightsError::Model { found: self.model.clone(), expected: model })
    }

    /// Checks that the weights use this vehicle's channels and forecast its residual.
    ///
    /// # Errors
    /// [`WeightsError::Channel`] or [`WeightsError::Length`] if the weights belong to another vehicle.
    pub fn check_channels(&self) -> Result<(), WeightsError> {
        same_names("channel_names", &self.channel_names, &channel_names())?;
        same_names("output_names", &self.output_names, &output_names())?;
        let unknown = self
            .normalisation
            .masked
            .iter()
            .enumerate()
            .find(|(_, name)| !self.channel_names.contains(name));
        match unknown {
            Some((index, name)) => Err(WeightsError::Channel {
                key: "masked",
                index,
                found: name.clone(),
                expected: self.channel_names.join(", "),
            }),
            None => Ok(()),
        }
    }

    /// Checks that the weights were trained on residuals with this `M_bar` (kg and kg m²) at this rate, Hz.
    ///
    /// # Errors
    /// [`WeightsError::Inertia`] or [`WeightsError::Rate`] if they were not.
    pub fn check_loop(&self, m_bar: &Coords, rate_hz: f64) -> Result<(), WeightsError> {
        for row in 0..N.min(self.m_bar.len()) {
            let (found, expected) = (self.m_bar[row], m_bar[row]);
            if (found - expected).abs() > INERTIA_TOLERANCE * expected.abs() {
                return Err(WeightsError::Inertia { row: COORDINATE_NAMES[row], found, expected });
            }
        }
        if (self.rate_hz - rate_hz).abs() > RATE_TOLERANCE_HZ {
            return Err(WeightsError::Rate { found: self.rate_hz, expected: rate_hz });
        }
        Ok(())
    }
}

fn same_names(
    key: &'static str,
    found: &[String],
    expected: &[String],
) -> Result<(), WeightsError> {
    if found.len() != expected.len() {
        return Err(WeightsError::Length { key, found: found.len(), expected: expected.len() });
    }
    match found.iter().zip(expected).position(|(a, b)| a != b) {
        Some(index) => Err(WeightsError::Channel {
            key,
            index,
            found: found[index].clone(),
            expected: expected[index].clone(),
        }),
        None => Ok(()),
    }
}
