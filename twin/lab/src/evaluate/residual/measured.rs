//! Flies the flights of one variant, and measures their residual.

use rustfft::FftPlanner;
use serde::Serialize;

use super::super::series::{EvaluateError, ReplayTick};
use super::bands::{BANDS, Split};
use super::foresight::{Foresight, foresee};
use super::variant::{Flown, Variant, fly_variant};
use twin_core::elementary::squared;
use twin_core::notation::{Coords, N};
use twin_input::interruption::{self, Interrupted};
use twin_scenario::{BuildError, Scenario};

/// The flights of every variant.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Flights that the models are fitted to.
    pub training: Vec<Scenario>,
    /// Flights that score the models; their seeds are none of those of the training.
    pub test: Vec<Scenario>,
}

impl Plan {
    /// Number of steps that [`measure`] reports for one variant: each flight, and the fit.
    pub fn steps(&self) -> usize {
        self.training.len() + self.test.len() + 1
    }
}

/// The measured residual of one variant.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Which effects were on.
    pub variant: Variant,
    /// The flights, those of the training first.
    pub flights: Vec<Flown>,
    /// Mean and variance by band of each coordinate, for each flight, N and N m and their squares.
    pub splits: Vec<[Split; N]>,
    /// Standard deviation of the residual over the training flights together, N and N m: the unit of z-scores.
    pub std: Coords,
    /// Errors of the forecasts.
    pub foresight: Foresight,
}

impl Measured {
    /// Variance by band of a coordinate, mean over the ticks of all flights; each flight has its own mean.
    pub fn variance(&self, row: usize) -> [f64; BANDS] {
        std::array::from_fn(|band| self.over_ticks(|split| split[row].variance[band]))
    }

    /// Root mean square over the flights of the mean of a coordinate, N or N m.
    pub fn mean(&self, row: usize) -> f64 {
        self.over_ticks(|split| squared(split[row].mean)).sqrt()
    }

    fn over_ticks(&self, value: impl Fn(&[Split; N]) -> f64) -> f64 {
        let ticks = |flown: &Flown| flown.ticks as f64;
        let sum = self.flights.iter().zip(&self.splits).map(|(f, split)| value(split) * ticks(f));
        sum.sum::<f64>() / self.flights.iter().map(ticks).sum::<f64>()
    }
}

/// Flies `plan` with the effects of `variant`, one flight after the other, and measures the residual. `step` is called after every step.
///
/// # Errors
/// [`EvaluateError`] if a flight cannot be built, or a signal asked the program to end.
pub fn measure(plan: &Plan, variant: Variant, step: &dyn Fn()) -> Result<Measured, EvaluateError> {
    let (mut flights, mut ticks) = (Vec::new(), Vec::new());
    for scenario in plan.training.iter().chain(&plan.test) {
        interruption::check().map_err(interrupted)?;
        let (flown, flown_ticks) = fly_variant(scenario, variant)?;
        flights.push(flown);
        ticks.push(flown_ticks);
        step();
    }
    let mut planner = FftPlanner::new();
    let mut split = |ticks: &Vec<ReplayTick>| -> [Split; N] {
        let row = |row: usize| ticks.iter().map(move |tick| tick.residual[row]);
        std::array::from_fn(|i| Split::of(row(i), &mut planner))
    };
    let splits = ticks.iter().map(&mut split).collect();
    let parts: Vec<&[ReplayTick]> = ticks.iter().map(Vec::as_slice).collect();
    let (training, test) = parts.split_at(plan.training.len());
    interruption::check().map_err(interrupted)?;
    let foresight = foresee(training, test);
    let std = std(training);
    step();
    Ok(Measured { variant, flights, splits, std, foresight })
}

fn interrupted(signal: Interrupted) -> EvaluateError {
    BuildError::from(signal).into()
}

fn std(flights: &[&[ReplayTick]]) -> Coords {
    let residuals = || flights.iter().flat_map(|ticks| ticks.iter()).map(|tick| tick.residual);
    let n = residuals().count().max(1) as f64;
    let mean = residuals().sum::<Coords>() / n;
    let squares = residuals().map(|r| (r - mean).component_mul(&(r - mean))).sum::<Coords>();
    (squares / n).map(f64::sqrt)
}
