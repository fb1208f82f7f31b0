//! Foresight: the residual at the end of the loop's delay, how far its forecast can be trusted, and how wide it spreads.
//!
//! In: forecast, adapted estimate, measured residual, lead. Out: [`Foreseen`]. State: the forecasts that wait for their residual, and the
//! errors of those that met it.
//!
//! The adapter corrects the forecast of now (`r_adapt`); the same correction belongs to every later time, because a payload stays.

use std::collections::VecDeque;

use super::horizon::at_step;
use crate::elementary::{exp, squared};
use crate::foreseen::Foreseen;
use crate::notation::{Coords, KnownCoords, N};
use crate::tick::{Adapted, Forecast};

/// Time constant over which errors are remembered, s: a few swings of the vehicle.
pub const MEMORY_S: f64 = 2.0;

/// A forecast is trusted in full up to the error of persistence, and not at all from this multiple of it on.
const DISTRUSTED_AT: f64 = 1.5;

/// Most forecasts that wait, outer periods: longer than any lead.
pub const MOST_WAITING: usize = 64;

/// Half width of a band that holds 90 % of a normal distribution, in standard deviations.
pub const BAND_90: f64 = 1.645;

/// Share of the errors that lie outside that band.
const OUTSIDE: f64 = 0.1;

/// Step with which the width of the bands follows the errors that they miss (adaptive conformal inference, Gibbs and Candès 2021).
const WIDTH_STEP: f64 = 0.02;

/// Narrowest and widest band, in units of the errors' root mean square.
const WIDTH_LIMITS: [f64; 2] = [0.3, 4.0];

/// A forecast that waits for the residual of its time.
#[derive(Clone, Debug)]
struct Waiting {
    /// Leads, outer periods.
    periods: [usize; N],
    /// Forecast at the lead.
    ahead: Coords,
    /// The residual measured when the forecast was made: what persistence forecasts.
    measured: KnownCoords,
}

/// Errors of one kind of forecast, per coordinate, and the width of the band that follows from them.
#[derive(Clone, Debug)]
pub struct Errors {
    /// Running mean square, N² and (N m)²; unknown before the first error.
    square: [Option<f64>; N],
    /// Width of the band in units of the root mean square.
    width: Coords,
}

impl Default for Errors {
    fn default() -> Self {
        Self::new()
    }
}

impl Errors {
    /// No errors so far.
    pub fn new() -> Self {
        Self { square: [None; N], width: Coords::repeat(1.0) }
    }

    /// Adds the error of coordinate `row`, N or N m; `forget` is the weight of the errors before it.
    pub fn add(&mut self, row: usize, error: f64, forget: f64) {
        if let Some(square) = self.square[row] {
            let missed = error.abs() > BAND_90 * self.width[row] * square.sqrt();
            let step = WIDTH_STEP * (f64::from(u8::from(missed)) - OUTSIDE);
            let [least, most] = WIDTH_LIMITS;
            self.width[row] = (self.width[row] + step).clamp(least, most);
        }
        let square = self.square[row].unwrap_or_else(|| squared(error));
        self.square[row] = Some(square * forget + squared(error) * (1.0 - forget));
    }

    /// Predictive standard deviation, N and N m: [`BAND_90`] of it hold 90 % of the errors so far.
    pub fn std(&self) -> KnownCoords {
        let rows = std::array::from_fn(|row| self.square[row].map(|s| s.sqrt() * self.width[row]));
        KnownCoords::from_rows(&rows)
    }
}

/// The state of the foresight.
#[derive(Clone, Debug, Default)]
pub struct Foresight {
    waiting: VecDeque<Waiting>,
    at_lead: Errors,
    now: Errors,
    /// Mean squares of persistence over the same lead.
    persistence: Errors,
}

impl Foresight {
    /// The residual at `lead_s` after this tick, from a `forecast` at steps of `dt_s`. While `learning` is false (contact, fault), nothing
    /// is judged, and the forecasts that wait are dropped.
    pub fn step(
        &mut self,
        forecast: &Forecast,
        adapted: &Adapted,
        residual: &KnownCoords,
        lead_s: &Coords,
        dt_s: f64,
        learning: bool,
    ) -> Foreseen {
        let base = forecast.base.first().map_or_else(Coords::zeros, |base| **base);
        let correction = *adapted.r_hat - base;
        let ahead =
            Coords::from_fn(|row, _| at(forecast, adapted, row, lead_s[row] / dt_s)) + correction;
        let periods = std::array::from_fn(|row| (lead_s[row] / dt_s).round() as usize);
        let error = if learning {
            self.judge(residual, adapted, exp(-dt_s / MEMORY_S))
        } else {
            self.waiting.clear();
            KnownCoords::unknown()
        };
        let trust = self.trust(&periods);
        if learning {
            self.waiting.push_front(Waiting { periods, ahead, measured: *residual });
            self.waiting.truncate(MOST_WAITING);
        }
        let now = *adapted.r_hat;
        let used = now + (ahead - now).component_mul(&trust);
        let known = adapted.r_hat.known();
        let said = |values: Coords| KnownCoords::from(values).only(known);
        Foreseen {
            lead_s: *lead_s,
            r_hat: said(ahead),
            trust,
            used: said(used),
            error,
            std: self.at_lead.std().only(known),
            std_now: self.now.std().only(known),
        }
    }

    /// Compares `residual` with the forecasts that were made for it; returns the errors at the lead.
    fn judge(&mut self, residual: &KnownCoords, adapted: &Adapted, forget: f64) -> KnownCoords {
        let mut found = [None; N];
        for (row, found) in found.iter_mut().enumerate() {
            let Some(r) = residual.get(row) else { continue };
            if let Some(prior) = adapted.r_hat_prior.get(row) {
                self.now.add(row, r - prior, forget);
            }
            // The forecast of a lead of n periods was made n periods ago; that of one period ago is the first in the queue.
            let made =
                self.waiting.iter().enumerate().find(|(age, made)| made.periods[row] == age + 1);
            let Some((_, made)) = made else { continue };
            let error = r - made.ahead[row];
            self.at_lead.add(row, error, forget);
            *found = Some(error);
            if let Some(before) = made.measured.get(row) {
                self.persistence.add(row, r - before, forget);
            }
        }
        KnownCoords::from_rows(&found)
    }

    /// 1 where the forecast at the lead errs no more than persistence, 0 where it errs by [`DISTRUSTED_AT`] times as much.
    fn trust(&self, periods: &[usize; N]) -> Coords {
        Coords::from_fn(|row, _| {
            let errors = self.at_lead.square[row].zip(self.persistence.square[row]);
            match errors {
                Some((forecast, persistence)) if periods[row] > 0 => {
                    let ratio = (forecast / persistence.max(f64::MIN_POSITIVE)).sqrt();
                    ((DISTRUSTED_AT - ratio) / (DISTRUSTED_AT - 1.0)).clamp(0.0, 1.0)
                }
                _ => 1.0,
            }
        })
    }
}

/// Forecasts for `j = 0..=k` that were made before the residual of their first tick was known, N and N m; a coordinate whose residual is
/// unknown has no meaningful number.
pub fn a_priori(forecast: &Forecast, adapted: &Adapted) -> Vec<Coords> {
    let first = forecast.base.first().map_or_else(Coords::zeros, |base| **base);
    let correction = *adapted.r_hat_prior - first;
    let at =
        |(step, base): (usize, &KnownCoords)| **base + correction + at_step(&adapted.horizon, step);
    forecast.base.iter().enumerate().map(at).collect()
}

/// Forecast `step` steps ahead, N and N m; `None` beyond the horizon. It has the correction of the first step, which the adapter adds to
/// every step (`r_adapt`), and the correction of the horizon.
pub fn corrected(forecast: &Forecast, adapted: &Adapted, step: usize) -> Option<KnownCoords> {
    let first = forecast.base.first()?;
    let ahead =
        **forecast.base.get(step)? + (*adapted.r_hat - **first) + at_step(&adapted.horizon, step);
    Some(KnownCoords::from(ahead).only(adapted.r_hat.known()))
}

/// Base forecast of coordinate `row` with the correction of the horizon at `periods` after now, between the steps of the horizon and not
/// beyond it.
fn at(forecast: &Forecast, adapted: &Adapted, row: usize, periods: f64) -> f64 {
    let last = forecast.base.len().saturating_sub(1);
    let within = periods.clamp(0.0, last as f64);
    let (before, share) = (within as usize, within.fract());
    let value = |step: usize| {
        let step = step.min(last);
        forecast.base.get(step).map_or(0.0, |base| base[row] + at_step(&adapted.horizon, step)[row])
    };
    value(before) + share * (value(before + 1) - value(before))
}

#[cfg(test)]
#[path = "foresight_tests.rs"]
mod tests;
