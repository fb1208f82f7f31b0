//! What a file of weights says about itself: the JSON under its metadata key `twin`.

use serde::{Deserialize, Serialize};

use super::WeightsError;
use crate::notation::{Coords, N, ROWS};

/// Format of the head this program reads and writes.
pub const FORMAT: u32 = 1;

/// Two nominal inertias count as one up to this relative difference: both are decimal numbers of a table.
const INERTIA_TOLERANCE: f64 = 1e-6;

/// Two rates count as one up to this difference, Hz.
const RATE_TOLERANCE_HZ: f64 = 1e-6;

/// What a file of weights says about itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// [`FORMAT`].
    pub format: u32,
    /// A [`super::ModelKind`], or `sindy` or `gp`.
    pub model: String,
    /// Sizes and flags of the model; of `fdt` an [`super::FdtConfig`].
    pub config: serde_json::Value,
    /// Input channels in order, [`channel_names`].
    pub channel_names: Vec<String>,
    /// Rows of the residual in order, [`output_names`].
    pub output_names: Vec<String>,
    /// Statistics of the training data.
    #[serde(flatten)]
    pub normalisation: Normalisation,
    /// Rate of the history, Hz.
    pub rate_hz: f64,
    /// Nominal inertia `M_bar` that is part of every residual trained on, diagonal.
    pub m_bar: Vec<f64>,
    /// SHA-256 of the training data, hexadecimal.
    pub data_hash: String,
    /// Version of the program that trained.
    pub git: String,
    /// Seed of the training.
    pub seed: u64,
    /// How the training went.
    pub training: Training,
    /// How the weights fly.
    pub acceptance: Acceptance,
}

/// Statistics of the training data: what turns physical units into z-scores and back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Normalisation {
    /// Channels whose z-score is set to zero.
    pub masked: Vec<String>,
    /// Mean of each input channel, in its unit.
    pub input_mean: Vec<f64>,
    /// Standard deviation of each input channel, in its unit.
    pub input_std: Vec<f64>,
    /// Mean of each row of the residual, N and N m.
    pub output_mean: Vec<f64>,
    /// Standard deviation of each row of the residual, N and N m.
    pub output_std: Vec<f64>,
    /// The adapter sees `g'` times this: its squared norm is then 8 on average over the training windows.
    pub regime_scale: f64,
}

/// How the training went.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Training {
    /// Epochs trained.
    pub epochs: u64,
    /// Optimiser steps.
    pub steps: u64,
    /// Windows per step.
    pub batch: u64,
    /// Epoch whose weights these are.
    pub best_epoch: u64,
    /// Mean squared z-score over the training windows.
    pub train_loss: Option<f64>,
    /// The same over windows held back.
    pub validation_loss: Option<f64>,
    /// Duration, s.
    pub wall_s: f64,
}

/// Coefficient of determination of the base forecast, flown in closed loop without the adapter; `None` if nobody flew it yet.
///
/// What decides is the figure over both flights together: in a hover alone the residual varies by little more than the noise of
/// its measurement, and R² divides by just that.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Acceptance {
    /// Over the ticks of both flights.
    pub r2: Option<f64>,
    /// In the hover alone.
    pub hover_r2: Option<f64>,
    /// On the figure-8 alone.
    pub figure_eight_r2: Option<f64>,
}

impl Acceptance {
    /// The figure over both flights must be above this.
    pub const LEAST_R2: f64 = 0.8;

    /// The weights were flown, completed both flights and are above [`Acceptance::LEAST_R2`].
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

/// The input channels of a predictor, oldest reading to newest: `chi`, `chi_dot` and the force of the previous tick.
pub fn channel_names() -> Vec<String> {
    ["chi", "chi_dot", "tau"]
        .iter()
        .flat_map(|stem| ROWS.iter().map(move |row| format!("{stem}.{row}")))
        .collect()
}

/// The rows of the residual.
pub fn output_names() -> Vec<String> {
    ROWS.iter().map(|row| (*row).to_owned()).collect()
}

impl Head {
    /// What can be said without the model: format, lengths and numbers.
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

    /// The weights are of `model`.
    ///
    /// # Errors
    /// [`WeightsError::Model`] if they are of another one.
    pub fn check_model(&self, model: &'static str) -> Result<(), WeightsError> {
        if self.model == model {
            return Ok(());
        }
        Err(WeightsError::Model { found: self.model.clone(), expected: model })
    }

    /// The weights see this vehicle's channels and forecast its residual.
    ///
    /// # Errors
    /// [`WeightsError::Channel`] or [`WeightsError::Length`] for those of another vehicle.
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

    /// The weights were trained on residuals of this `M_bar` at this rate, Hz.
    ///
    /// # Errors
    /// [`WeightsError::Inertia`] or [`WeightsError::Rate`] if not.
    pub fn check_loop(&self, m_bar: &Coords, rate_hz: f64) -> Result<(), WeightsError> {
        for row in 0..N.min(self.m_bar.len()) {
            let (found, expected) = (self.m_bar[row], m_bar[row]);
            if (found - expected).abs() > INERTIA_TOLERANCE * expected.abs() {
                return Err(WeightsError::Inertia { row: ROWS[row], found, expected });
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
