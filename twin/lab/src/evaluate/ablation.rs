//! The ablation table: the accuracy of the network without one of its parts, on the paper's flights: scenario B, 500 g, 1 m/s.
//!
//! One flight per seed is flown with the full model. All variants are replayed on its ticks from lift-off to touchdown, a priori.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::entrants::{Candidate, trained};
use super::pictures::{Picture, horizon_curve};
use super::replay::replay;
use super::series::{EvaluateError, ReplayTick, Series, Statistics};
use super::sheet::{Sheet, figure};
use twin_core::notation::Coords;
use twin_core::residual::REPORTED;
use twin_core::residual::weights::Weights;
use twin_scenario::{Report, Scenario, fly};

/// The variants: name, and RMSE of the paper, whose network has no linear path to leave out.
pub const VARIANTS: [(&str, Option<f64>); 6] = [
    ("full", Some(0.283)),
    ("without_lra", Some(0.37)),
    ("without_global_token", Some(0.692)),
    ("without_short_horizon", Some(0.778)),
    ("without_long_memory", Some(0.782)),
    ("without_skip", None),
];

/// A line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Variant {
    /// Name of the missing part.
    pub name: String,
    /// File of weights.
    pub weights: PathBuf,
    /// z-scored a-priori RMSE at `j = 0`: root of the mean of the squares over the seeds.
    pub rmse_z: f64,
    /// z-scored a-priori RMSE at every horizon.
    pub rmse_z_by_horizon: Vec<f64>,
    /// R², mean over the seeds.
    pub r2: f64,
    /// Change of the RMSE against the full model, %.
    pub delta_percent: f64,
    /// RMSE of the paper, and its change in %.
    pub paper: Option<[f64; 2]>,
}

/// Flies `scenario` and collects the inputs of a predictor. Ticks without the payload in the gripper are not scored.
///
/// # Errors
/// [`EvaluateError`] if the flight cannot be built.
pub fn flown(scenario: &Scenario) -> Result<(Series, Report), EvaluateError> {
    let mut samples = Vec::new();
    let report = fly(scenario, &mut |tick| {
        let sample = ReplayTick::from(tick);
        samples.push(ReplayTick { usable: sample.usable && tick.reference.transporting, ..sample });
    })?;
    let tuning = scenario.tuning().map_err(twin_scenario::BuildError::from)?;
    let series = Series {
        file: scenario.file.clone(),
        sha256: report.state_hash.clone(),
        seed: scenario.settings.seed.to_string(),
        m_bar: tuning.gains.nominal_inertia,
        samples,
    };
    Ok((series, report))
}

/// The statistics of the training data that a file of weights holds.
pub fn statistics(weights: &Weights) -> Statistics {
    let n = &weights.head.normalisation;
    Statistics {
        input_mean: n.input_mean.clone(),
        input_std: n.input_std.clone(),
        output_mean: Coords::from_column_slice(&n.output_mean),
        output_std: Coords::from_column_slice(&n.output_std),
    }
}

/// Replays the variant `name` with `weights` over all `flights`. Returns the RMSE at every horizon, and R² at `j = 0`.
///
/// # Errors
/// [`EvaluateError`] if the weights cannot be used.
pub fn measure(
    name: &str,
    (weights, file): (&Weights, &Path),
    scenario: &Scenario,
    flights: &[Series],
    statistics: &Statistics,
) -> Result<(Vec<f64>, f64), EvaluateError> {
    let tuning = scenario.tuning().map_err(twin_scenario::BuildError::from)?;
    let wanted = if name == "without_lra" { "fdt" } else { "fdt_lra" };
    let (mut squares, mut r2) = (Vec::new(), 0.0);
    for flight in flights {
        let candidates = trained(weights, file, &tuning)?;
        let Some(Candidate { mut entrant, .. }) = candidates.into_iter().find(|c| c.name == wanted)
        else {
            continue;
        };
        let horizons = replay(&mut entrant, flight, statistics).horizons;
        squares.resize(horizons.len(), 0.0);
        for (sum, horizon) in squares.iter_mut().zip(&horizons) {
            *sum += horizon.rmse_z * horizon.rmse_z;
        }
        r2 += horizons.first().map_or(f64::NAN, |now| now.r2);
    }
    let n = flights.len().max(1) as f64;
    Ok((squares.into_iter().map(|sum| (sum / n).sqrt()).collect(), r2 / n))
}

/// The table as plain cells.
pub fn sheet(rows: &[Variant]) -> Sheet {
    let horizons = REPORTED.map(|j| format!("RMSE z, j = {j}"));
    let head = ["variant", "R²", "Δ %", "paper RMSE", "paper Δ %"].map(str::to_owned);
    let mut sheet = Sheet::new(head.into_iter().chain(horizons));
    sheet.rows.extend(rows.iter().map(|row| {
        let paper = [0, 1].map(|at| row.paper.map(|paper| paper[at]));
        let own = [row.r2, row.delta_percent].map(Some);
        let figures = own.into_iter().chain(paper).map(|v| figure(v, 3));
        let by_horizon = REPORTED.map(|j| figure(row.rmse_z_by_horizon.get(j).copied(), 4));
        std::iter::once(row.name.clone()).chain(figures).chain(by_horizon).collect()
    }));
    sheet
}

/// A picture of the error over the horizon.
pub fn over_horizon(rows: &[Variant]) -> Picture {
    let curve = |row: &Variant| horizon_curve(&row.name, row.rmse_z_by_horizon.iter().copied());
    Picture::over_horizon("RMSE, z-scored, a priori", rows.iter().map(curve))
}
