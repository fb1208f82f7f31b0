//! Time-delay control that looks ahead: the residual goes on along its slope, which fades.

use super::{HORIZON, History, Predictor};
use crate::elementary::exp;
use crate::notation::Coords;
use crate::tick::Forecast;

/// Number of residuals whose line of best fit gives the slope. 3 to 5 have the smallest errors on the test flight.
const TICKS: usize = 4;

/// Time constant with which the slope fades, ticks: the errors at `j = 3` to 20 are smallest at 6 to 8. It bounds the change at so many
/// times the slope.
const FADE_TICKS: f64 = 8.0;

/// Predicts `r_hat(t+j|t) = r_{t-1} + s T (1 - exp(-(j+1)/T))` with the slope `s` of the last residuals and the time constant `T`.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extrapolated;

/// Slope of the line of best fit through the last residuals, N and N m per tick; zero before there are [`TICKS`].
fn slope(history: &History) -> Coords {
    if history.len() < TICKS {
        return Coords::zeros();
    }
    let middle = (TICKS - 1) as f64 / 2.0;
    let (mut moment, mut square) = (Coords::zeros(), 0.0);
    for (tick, entry) in history.iter().skip(history.len() - TICKS).enumerate() {
        let offset = tick as f64 - middle;
        moment += entry.residual_previous * offset;
        square += offset * offset;
    }
    moment / square
}

impl Predictor for Extrapolated {
    fn regime_len(&self) -> usize {
        0
    }

    fn history_len(&self) -> usize {
        TICKS
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let last = history.newest().map_or_else(Coords::zeros, |entry| entry.residual_previous);
        let slope = slope(history);
        let ahead = |j: usize| FADE_TICKS * (1.0 - exp(-(j as f64 + 1.0) / FADE_TICKS));
        let base = (0..=HORIZON).map(|j| (last + slope * ahead(j)).into()).collect();
        Forecast { base, regime: Vec::new(), attention: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A few roundings of numbers below 10.
    const ROUNDING: f64 = 1e-12;

    /// What is said after residuals that rise by `step` a tick from zero.
    fn after(step: f64, ticks: usize) -> Forecast {
        let mut history = History::new(TICKS);
        for tick in 0..ticks {
            let residual = Coords::repeat(step * tick as f64);
            history.push(Coords::zeros(), Coords::zeros(), residual, residual);
        }
        Extrapolated.predict(&history)
    }

    #[test]
    fn a_ramp_is_followed_and_fades() {
        // The residual of the previous tick is 8 steps above zero.
        let said = after(0.5, 10);
        let rise = |j: usize| said.base[j][2] - 4.0;
        // The first step is 8 (1 - e^-1/8) = 0.940025 of the slope, and all of them together stay below 8.
        assert!((rise(0) - 0.5 * 0.940_024_8).abs() < 1e-6, "{}", rise(0));
        assert!((1..=HORIZON).all(|j| rise(j) > rise(j - 1) && rise(j) < 0.5 * FADE_TICKS));
        assert!((1..=HORIZON).all(|j| rise(j) < 0.5 * (j as f64 + 1.0)));
    }

    #[test]
    fn what_does_not_change_and_what_is_new_stays() {
        assert!(after(0.0, 10).base.iter().all(|base| base.norm() < ROUNDING));
        let early = after(0.5, 3);
        assert!(early.base.iter().all(|base| (base[2] - 0.5).abs() < ROUNDING));
    }
}
