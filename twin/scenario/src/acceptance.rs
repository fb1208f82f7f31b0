//! Flies trained weights in closed loop: weights are flown by a scenario only with these figures.
//!
//! The adapter is off and the low-pass on the estimate is slow, so that the base forecast alone carries the vehicle. The score compares
//! that forecast with the residual of the same flight.

use std::path::Path;

use super::{BuildError, Judge, Scenario, ScenarioError, Verdict};
use twin_core::elementary::squared;
use twin_core::notation::{Coords, N};
use twin_core::residual::weights::WeightsError;
#[cfg(feature = "suite")]
use twin_core::residual::weights::{Acceptance, Weights};
use twin_core::tick::Tick;
use twin_input::interruption;

/// Corner of the low-pass on the estimate, Hz.
const BANDWIDTH_HZ: f64 = 2.0;

/// Ticks before this time belong to the start and are not scored, s.
const FROM_S: f64 = 2.0;

/// Reason why weights cannot be flown in closed loop.
#[derive(Debug, thiserror::Error)]
pub enum AcceptanceError {
    /// The file of weights cannot be used.
    #[error("{file}: {reason}")]
    File {
        /// File.
        file: String,
        /// Reason.
        reason: String,
    },
    /// The weights are not usable.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// The scenario is not usable.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The flight cannot be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The file cannot be written.
    #[cfg(feature = "suite")]
    #[error(transparent)]
    Output(#[from] twin_record::OutputError),
}

/// One flight of the acceptance.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct GateFlight {
    /// Scenario.
    pub scenario: String,
    /// R² of the base forecast, a priori, as the mean over the coordinates.
    pub r2: f64,
    /// R² of each coordinate, in coordinate order.
    pub r2_rows: [f64; N],
    /// How the flight ended.
    pub verdict: Verdict,
    /// Reason for the verdict.
    pub reason: String,
    #[serde(skip)]
    score: Score,
}

/// Flies `scenario` with the weights of `file`, overridden by `overrides`, and scores the base forecast.
///
/// # Errors
/// [`AcceptanceError`] if the scenario or the weights cannot be flown.
pub fn fly(
    scenario: &Path,
    file: &Path,
    overrides: &[String],
) -> Result<GateFlight, AcceptanceError> {
    // The path is relative to the working folder of the command, not to the scenario.
    let path = std::path::absolute(file).map_err(|error| unusable(file, &error))?;
    let mut all = vec![
        "predictor.kind=\"trained\"".to_owned(),
        format!("predictor.weights={:?}", path.display().to_string()),
        "predictor.force=true".to_owned(),
        "gains.adapter_on=0.0".to_owned(),
        "gains.residual_filter_on=1.0".to_owned(),
        format!("gains.residual_bandwidth_hz={BANDWIDTH_HZ:?}"),
    ];
    all.extend_from_slice(overrides);
    let scenario = Scenario::load(scenario, &all)?;
    let mut flight = scenario.build()?;
    let mut judge = Judge::new(&scenario.settings);
    let mut score = Score::default();
    loop {
        interruption::check().map_err(BuildError::from)?;
        let tick = flight.tick();
        score.add(&tick);
        if let Some((verdict, reason)) = judge.watch(&tick) {
            let (r2, r2_rows) = (score.mean(), score.rows());
            return Ok(GateFlight { scenario: scenario.name, r2, r2_rows, verdict, reason, score });
        }
    }
}

impl GateFlight {
    /// The figure for the head of the weights; `None` unless the flight was completed.
    pub fn figure(&self) -> Option<f64> {
        (self.verdict == Verdict::Completed && self.r2.is_finite()).then_some(self.r2)
    }
}

/// R² over all ticks of `flights`, as the mean over the coordinates and per coordinate; `None` unless every flight was completed.
pub fn together(flights: &[GateFlight]) -> Option<(f64, [f64; N])> {
    let complete = !flights.is_empty() && flights.iter().all(|flown| flown.figure().is_some());
    let score = flights.iter().fold(Score::default(), |sum, flown| sum.and(&flown.score));
    complete.then(|| (score.mean(), score.rows()))
}

/// Writes the figures into the head of `file`, which keeps its tensors: whole or not at all.
///
/// # Errors
/// [`AcceptanceError`] if the file cannot be read or written.
#[cfg(feature = "suite")]
pub fn write(file: &Path, acceptance: Acceptance) -> Result<(), AcceptanceError> {
    let bytes = twin_input::file::read(file, twin_input::budget::WEIGHTS_BYTES)
        .map_err(|error| unusable(file, &error))?;
    let mut weights = Weights::from_bytes(&bytes)?;
    weights.head.acceptance = acceptance;
    Ok(twin_record::output::replace(file, &weights.to_bytes()?)?)
}

fn unusable(file: &Path, error: &dyn std::fmt::Display) -> AcceptanceError {
    AcceptanceError::File { file: file.display().to_string(), reason: error.to_string() }
}

/// Sums for the coefficient of determination of each coordinate.
#[derive(Clone, Debug, Default, PartialEq)]
struct Score {
    count: f64,
    sum: Coords,
    squares: Coords,
    errors: Coords,
}

impl Score {
    fn add(&mut self, tick: &Tick) {
        let Some(base) = tick.forecast.base.first() else { return };
        if tick.measurement.t_s < FROM_S {
            return;
        }
        let error = *tick.residual - **base;
        self.count += 1.0;
        self.sum += *tick.residual;
        self.squares += tick.residual.component_mul(&tick.residual);
        self.errors += error.component_mul(&error);
    }

    fn and(self, other: &Self) -> Self {
        Self {
            count: self.count + other.count,
            sum: self.sum + other.sum,
            squares: self.squares + other.squares,
            errors: self.errors + other.errors,
        }
    }

    fn mean(&self) -> f64 {
        self.rows().iter().sum::<f64>() / N as f64
    }

    /// `1 - sum (r - base)^2 / sum (r - mean r)^2` per coordinate; NaN without ticks.
    fn rows(&self) -> [f64; N] {
        std::array::from_fn(|row| {
            let spread = self.squares[row] - squared(self.sum[row]) / self.count;
            1.0 - self.errors[row] / spread
        })
    }
}
