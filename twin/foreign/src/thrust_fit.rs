//! Fits the force per kilogram of a normalised thrust to a flight: `z_body . (a + g) = k u(t - lag)`.
//!
//! Both sides pass the same filter `H`. The uncertainty is a jackknife over blocks of 2 s, because neighbouring ticks are
//! correlated.

use nalgebra::Vector1;
use serde::Serialize;

use super::grid::{Ticks, filtered_times};
use super::series::Series;
use twin_core::elementary::squared;
use twin_core::notation::TICK_S;

/// Longest lag that the fit tries, ticks.
pub(super) const LONGEST_LAG_TICKS: usize = 25;

/// Smallest meaningful difference between the errors of two lags, as a share of the squared force. A constant thrust fits at any
/// lag. Among equal lags the fit takes the shortest, so that a part of a flight gives the same lag as the whole.
const SAME_SHARE: f64 = 1e-7;

/// Length of a jackknife block, ticks.
pub(super) const BLOCK_TICKS: usize = 200;

/// Fewest airborne ticks for a fit.
const FEWEST_TICKS: usize = 200;

/// The vehicle may fly where the thrust exceeds this share of its 90 % quantile.
pub(super) const AIRBORNE_SHARE: f64 = 0.5;

/// The gain of the thrust, fitted to one flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ThrustFit {
    /// Specific force per unit of thrust, m/s² per unit.
    pub gain: f64,
    /// Standard error of the gain, in the unit of the gain.
    pub standard_error: f64,
    /// Gain of the first half of the flight.
    pub gain_first_half: f64,
    /// Gain of the second half; it differs where the battery voltage falls.
    pub gain_second_half: f64,
    /// Time by which the thrust leads the acceleration, s.
    pub lag_s: f64,
    /// Share of the variance of the specific force that the fit explains.
    pub r2: f64,
    /// Mean thrust in the air, in its unit.
    pub mean_input: f64,
    /// Number of ticks used.
    pub ticks: usize,
}

/// Share of the variance above which a fit is good: then most of the motion follows from the thrust.
const GOOD_R2: f64 = 0.5;

/// Share of the variance above which a fit explains the motion at all: a mean without any thrust has 0.
const LEAST_R2: f64 = 0.1;

impl ThrustFit {
    /// Whether the thrust explains the motion. If not, the gain only says which mean thrust carries the weight.
    pub fn explains(&self) -> bool {
        self.gain > 0.0 && self.r2 >= LEAST_R2
    }

    /// What the fit is worth, in words.
    pub fn verdict(&self) -> &'static str {
        match self.r2 {
            _ if !self.explains() => {
                "the thrust does not explain the motion; the gain is only that of the mean thrust"
            }
            r2 if r2 >= GOOD_R2 => "good",
            _ => "weak",
        }
    }

    /// Gain, uncertainty, lag and verdict in words.
    pub fn sentence(&self) -> String {
        format!(
            "{:.3} +- {:.3} m/s2 per unit ({:.3} then {:.3}), lag {:.2} s, R2 {:.3}, {} ticks: {}",
            self.gain,
            self.standard_error,
            self.gain_first_half,
            self.gain_second_half,
            self.lag_s,
            self.r2,
            self.ticks,
            self.verdict()
        )
    }
}

/// The thrust at every tick, delayed by `lag_s`.
pub(super) fn delayed(thrust: &Series<1>, times_s: &[f64], lag_s: f64) -> Ticks<1> {
    times_s.iter().map(|t_s| thrust.linear(t_s - lag_s)).collect()
}

/// The 90 % quantile of the thrust.
pub(super) fn high(thrust: &Series<1>) -> f64 {
    let mut sorted: Vec<f64> = thrust.values().iter().map(|v| v.x).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(0.0)
}

/// Fits `specific_force` (m/s² along the body's z axis, which has passed `H` `passes` times) to the thrust. A vehicle with less
/// thrust than `least` does not fly, and only ticks in the air count.
///
/// # Errors
/// A sentence that says why the fit is impossible.
pub(super) fn fit(
    thrust: &Series<1>,
    times_s: &[f64],
    specific_force: &[Option<f64>],
    passes: usize,
    (least, airborne): (f64, &[bool]),
) -> Result<ThrustFit, String> {
    let high = high(thrust);
    if high < least {
        return Err(format!(
            "the thrust stays below {high:.1e} of its range: the vehicle is not flying"
        ));
    }
    let candidates = (0..=LONGEST_LAG_TICKS).map(|lag| {
        let lag_s = lag as f64 * TICK_S;
        let input = filtered_times(&delayed(thrust, times_s, lag_s), passes);
        let pairs = pairs(&input, specific_force, airborne);
        (lag_s, pairs)
    });
    let scored: Vec<_> =
        candidates.map(|(lag_s, pairs)| (mean_square(&pairs), lag_s, pairs)).collect();
    let least = scored.iter().map(|(error, ..)| *error).fold(f64::MAX, f64::min);
    let forces: Vec<f64> = specific_force.iter().flatten().copied().collect();
    let square = forces.iter().map(|y| y * y).sum::<f64>() / forces.len().max(1) as f64;
    let (_, lag_s, pairs) = scored
        .into_iter()
        .find(|(error, ..)| *error <= least + SAME_SHARE * square)
        .ok_or("no lag to try")?;
    if pairs.len() < FEWEST_TICKS {
        return Err(format!("only {} ticks in the air with a known acceleration", pairs.len()));
    }
    let gain = gain(&pairs);
    let mean = pairs.iter().map(|(_, y)| y).sum::<f64>() / pairs.len() as f64;
    let spread = pairs.iter().map(|(_, y)| squared(y - mean)).sum::<f64>() / pairs.len() as f64;
    let (first, second) = pairs.split_at(pairs.len() / 2);
    Ok(ThrustFit {
        gain,
        standard_error: standard_error(&pairs),
        gain_first_half: self::gain(first),
        gain_second_half: self::gain(second),
        lag_s,
        r2: 1.0 - mean_square(&pairs) / spread.max(f64::MIN_POSITIVE),
        mean_input: pairs.iter().map(|(u, _)| u).sum::<f64>() / pairs.len() as f64,
        ticks: pairs.len(),
    })
}

fn pairs(
    input: &[Option<Vector1<f64>>],
    force: &[Option<f64>],
    airborne: &[bool],
) -> Vec<(f64, f64)> {
    let flown = input.iter().zip(force).zip(airborne).filter(|(_, flies)| **flies);
    flown.filter_map(|((u, y), _)| Some((u.as_ref()?.x, (*y)?))).collect()
}

fn gain(pairs: &[(f64, f64)]) -> f64 {
    let (uy, uu) = pairs.iter().fold((0.0, 0.0), |(uy, uu), (u, y)| (uy + u * y, uu + u * u));
    uy / f64::max(uu, f64::MIN_POSITIVE)
}

fn mean_square(pairs: &[(f64, f64)]) -> f64 {
    if pairs.is_empty() {
        return f64::MAX;
    }
    let k = gain(pairs);
    pairs.iter().map(|(u, y)| squared(y - k * u)).sum::<f64>() / pairs.len() as f64
}

/// Standard error by a jackknife over blocks.
fn standard_error(pairs: &[(f64, f64)]) -> f64 {
    let blocks: Vec<&[(f64, f64)]> = pairs.chunks(BLOCK_TICKS).collect();
    let n = blocks.len() as f64;
    if blocks.len() < 2 {
        return f64::INFINITY;
    }
    let without: Vec<f64> = (0..blocks.len())
        .map(|left_out| {
            let rest = blocks.iter().enumerate().filter(|(i, _)| *i != left_out);
            gain(&rest.flat_map(|(_, block)| block.iter().copied()).collect::<Vec<_>>())
        })
        .collect();
    let mean = without.iter().sum::<f64>() / n;
    ((n - 1.0) / n * without.iter().map(|k| squared(k - mean)).sum::<f64>()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::elementary::{cos, sin};

    /// A thrust that varies so slowly that `H` and interpolation do not change it.
    fn input(t_s: f64) -> f64 {
        0.5 + 0.05 * sin(2.0 * t_s) + 0.03 * cos(3.3 * t_s)
    }

    #[test]
    fn a_known_gain_and_lag_are_found_within_the_stated_uncertainty() {
        let (gain, lag_s) = (19.6, 0.07);
        let times: Vec<f64> = (0..3000).map(|i| f64::from(i) * TICK_S).collect();
        let thrust = Series::new(times.iter().map(|t| (*t, Vector1::new(input(*t)))));
        let raw: Ticks<1> = times
            .iter()
            .map(|t| Some(Vector1::new(gain * input(t - lag_s) + 0.3 * sin(40.0 * t))))
            .collect();
        let force: Vec<Option<f64>> =
            filtered_times(&raw, 1).into_iter().map(|v| v.map(|v| v.x)).collect();
        let found = fit(&thrust, &times, &force, 1, (0.05, &[true; 3000])).unwrap();
        assert!((found.lag_s - lag_s).abs() < 1e-9, "{found:?}");
        assert!((found.gain - gain).abs() < 4.0 * found.standard_error.max(0.005), "{found:?}");
        assert!(found.standard_error < 0.05 && found.r2 > 0.9, "{found:?}");
    }

    #[test]
    fn a_constant_thrust_that_any_lag_fits_has_none() {
        let times: Vec<f64> = (0..3000).map(|i| f64::from(i) * TICK_S).collect();
        let thrust = Series::new(times.iter().map(|t| (*t, Vector1::new(0.5))));
        // Rounding errors: their minimum lies at a meaningless lag.
        let force: Vec<Option<f64>> =
            times.iter().map(|t| Some(9.81 + 1e-5 * sin(7.0 * t))).collect();
        assert_eq!(
            fit(&thrust, &times, &force, 1, (0.05, &[true; 3000])).unwrap().lag_s.to_bits(),
            0
        );
    }

    #[test]
    fn a_vehicle_that_is_carried_around_has_no_gain() {
        let times: Vec<f64> = (0..3000).map(|i| f64::from(i) * TICK_S).collect();
        let thrust = Series::new(times.iter().map(|t| (*t, Vector1::new(0.002))));
        let force = vec![Some(9.81); 3000];
        let why = fit(&thrust, &times, &force, 1, (0.05, &[true; 3000])).unwrap_err();
        assert!(why.contains("not flying"), "{why}");
    }
}
