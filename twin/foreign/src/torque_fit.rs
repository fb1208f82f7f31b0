//! Fits the angular acceleration per unit of a normalised torque to a flight: `d omega / dt = k u(t - lag) + trim` per axis.
//!
//! In closed loop a torque also answers the noise of the gyroscope and the disturbances that it compensates. Ordinary least
//! squares therefore finds a gain that is far too small. The attitude set-point depends on neither noise nor disturbance. The fit
//! uses only the part of torque and acceleration that the last 0.6 s of the set-point predict (two-stage least squares;
//! Söderström and Stoica, *Instrumental Variable Methods*). The prediction of a block of 2 s is fitted to the other blocks alone,
//! because a block could otherwise predict its own noise. The fit removes slow changes, and skips blocks that fit far worse than
//! most: the vehicle touches something there. Both sides pass the same filter `H`. The uncertainty is a jackknife over the
//! blocks, because neighbouring ticks are correlated.

use nalgebra::{Cholesky, Const};
use serde::Serialize;

use super::thrust_fit::LONGEST_LAG_TICKS;
use super::torque_blocks::{Block, Column, Known, Lagged, Square, TAPS, blocks};
use twin_core::elementary::squared;
use twin_core::notation::TICK_S;

/// Fewest blocks for a fit: 20 s.
const FEWEST_BLOCKS: usize = 10;

/// Blocks whose error exceeds this multiple of the median block's error are skipped; the fit repeats at most so many times to
/// find them.
const OUTLIER: f64 = 4.0;
const ROUNDS: usize = 5;

/// Least share of the torque's variance that the set-point must predict. In 20 s of pure noise the share reaches 0.03 in one of
/// twenty flights.
const LEAST_SHARE: f64 = 0.05;

/// Least share that the torque must explain of the acceleration that the set-point predicts.
const LEAST_R2: f64 = 0.5;

/// Largest standard error of a usable gain, as a share of the gain.
const LARGEST_ERROR: f64 = 0.25;

/// Ridge on the diagonal of the normal equations, as a share of its mean: neighbouring taps are nearly equal.
const RIDGE: f64 = 1e-9;

/// The gain of one axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum TorqueAxis {
    /// The gain was fitted.
    Fitted(TorqueFit),
    /// The gain is unknown.
    Unknown {
        /// The reason.
        why: String,
    },
}

/// The gain of a torque, fitted to one flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TorqueFit {
    /// Angular acceleration per unit of torque, rad/s² per unit.
    pub gain: f64,
    /// Standard error of the gain, in the unit of the gain.
    pub standard_error: f64,
    /// Gain of the first half of the blocks.
    pub gain_first_half: f64,
    /// Gain of the second half.
    pub gain_second_half: f64,
    /// Constant angular acceleration without torque, rad/s², from an offset centre of mass or unequal rotors.
    pub trim: f64,
    /// Time by which the torque leads the acceleration, s.
    pub lag_s: f64,
    /// Share that the torque explains of the acceleration that the set-point predicts.
    pub r2: f64,
    /// Share of the torque's variance that the set-point predicts: the excitation.
    pub answering: f64,
    /// Number of blocks of 2 s used.
    pub blocks: usize,
    /// Number of blocks skipped.
    pub blocks_left_out: usize,
}

impl TorqueFit {
    /// Gain, uncertainty and lag in words.
    pub fn sentence(&self) -> String {
        format!(
            "{:.1} +- {:.1} rad/s2 per unit ({:.1} then {:.1}), lag {:.2} s, R2 {:.2}, {} blocks of 2 s, {} left out",
            self.gain,
            self.standard_error,
            self.gain_first_half,
            self.gain_second_half,
            self.lag_s,
            self.r2,
            self.blocks,
            self.blocks_left_out
        )
    }
}

/// Fits the gain of every axis.
pub(super) fn fit(known: &Known<'_>) -> [TorqueAxis; 3] {
    blocks(known).map(|blocks| match judge(&blocks) {
        Ok(fit) => TorqueAxis::Fitted(fit),
        Err(why) => TorqueAxis::Unknown { why },
    })
}

/// Result of one round of a fit.
struct Round {
    lag: usize,
    r2: f64,
    answering: f64,
    /// For each kept block: predicted torque times acceleration, and predicted torque times torque.
    products: Vec<(f64, f64)>,
    /// For each block, kept or not: sum of squares of the predicted torque.
    predicted: Vec<f64>,
}

/// The gain as a ratio of the summed products; NaN if the denominator is zero.
fn ratio(products: &[(f64, f64)]) -> f64 {
    let (above, below) =
        products.iter().fold((0.0, 0.0), |sums, product| (sums.0 + product.0, sums.1 + product.1));
    if below == 0.0 { f64::NAN } else { above / below }
}

/// Fits the kept blocks at the lag at which the torque explains most; `None` if the set-point does not move.
fn round(blocks: &[Block], kept: &[bool]) -> Option<Round> {
    let weigh = |kept: bool| f64::from(u8::from(kept));
    let weighed = || blocks.iter().zip(kept).map(|(block, kept)| (block, weigh(*kept)));
    let all: Square = weighed().map(|(block, weight)| block.zz * weight).sum();
    let ridge = Square::identity() * (RIDGE * all.trace() / TAPS as f64);
    let factors: Vec<Cholesky<f64, Const<TAPS>>> =
        weighed().map(|(b, w)| Cholesky::new(all - b.zz * w + ridge)).collect::<Option<_>>()?;
    // The coefficients for each block come from the other blocks.
    let predicted = |of: &dyn Fn(&Block) -> Column| -> Vec<Column> {
        let all: Column = weighed().map(|(block, weight)| of(block) * weight).sum();
        let rest = weighed().map(|(block, weight)| all - of(block) * weight);
        rest.zip(&factors).map(|(rest, factor)| factor.solve(&rest)).collect()
    };
    let y = predicted(&|block| block.zy);
    let product = |a: &[Column], b: &[Column]| -> f64 {
        let both = weighed().zip(a).zip(b);
        both.map(|(((block, weight), a), b)| weight * a.dot(&(block.zz * b))).sum()
    };
    let at = |lag: usize| {
        let u = predicted(&|block| block.lags[lag].zu);
        let (uy, uu, yy) = (product(&u, &y), product(&u, &u), product(&y, &y));
        let products: Vec<(f64, f64)> = weighed()
            .zip(&u)
            .filter(|((_, weight), _)| *weight > 0.0)
            .map(|((block, _), u)| (u.dot(&block.zy), u.dot(&block.lags[lag].zu)))
            .collect();
        let found: f64 = products.iter().map(|(_, found)| found).sum();
        let torque: f64 = weighed().map(|(block, weight)| weight * block.lags[lag].uu).sum();
        // A negative correlation counts as a negative share.
        let share = |both: f64, a: f64, b: f64| both * both.abs() / (a * b).max(f64::MIN_POSITIVE);
        let predicted = blocks.iter().zip(&u).map(|(block, u)| u.dot(&(block.zz * u))).collect();
        let (r2, answering) = (share(uy, uu, yy), share(found, uu, torque));
        Round { lag, r2, answering, products, predicted }
    };
    // The search accepts a negative gain too; its sign is checked later.
    (0..=LONGEST_LAG_TICKS).map(at).max_by(|a, b| a.r2.abs().total_cmp(&b.r2.abs()))
}

/// Fits the blocks of an axis, and skips those that do not fit.
fn judge(blocks: &[Block]) -> Result<TorqueFit, String> {
    if blocks.len() < FEWEST_BLOCKS {
        return Err(format!(
            "only {} blocks of 2 s in the air with torque, attitude set-point and angular acceleration, {FEWEST_BLOCKS} are needed",
            blocks.len()
        ));
    }
    let still = || "too little excitation: the attitude set-point does not move".to_owned();
    let mut kept = vec![true; blocks.len()];
    let mut found = round(blocks, &kept).ok_or_else(still)?;
    for _ in 1..ROUNDS {
        let better = fitting(blocks, &found);
        if better == kept {
            break;
        }
        kept = better;
        found = round(blocks, &kept).ok_or_else(still)?;
    }
    refuse(&found)?;
    let Round { lag, r2, answering, products, .. } = found;
    let gain = ratio(&products);
    let (first, second) = products.split_at(products.len() / 2);
    let used = || blocks.iter().zip(&kept).filter(|(_, kept)| **kept);
    let trims = used().map(|(block, _)| block.mean_y - gain * block.lags[lag].mean_u);
    Ok(TorqueFit {
        gain,
        standard_error: standard_error(&products),
        gain_first_half: ratio(first),
        gain_second_half: ratio(second),
        trim: trims.sum::<f64>() / products.len() as f64,
        lag_s: lag as f64 * TICK_S,
        r2,
        answering,
        blocks: products.len(),
        blocks_left_out: blocks.len() - products.len(),
    })
}

/// Refuses an unusable gain, with the reason.
fn refuse(found: &Round) -> Result<(), String> {
    let Round { r2, answering, products, .. } = found;
    let (gain, standard_error) = (ratio(products), standard_error(products));
    if products.len() < FEWEST_BLOCKS {
        return Err(format!(
            "only {} blocks of 2 s agree with one gain, {FEWEST_BLOCKS} are needed",
            products.len()
        ));
    }
    if *answering < LEAST_SHARE {
        return Err(format!(
            "too little excitation: the attitude set-point predicts {:.1} % of the variance of the torque, {:.0} % are needed",
            100.0 * answering.max(0.0),
            100.0 * LEAST_SHARE
        ));
    }
    if r2.abs() < LEAST_R2 {
        return Err(format!(
            "the torque explains {:.0} % of the angular acceleration that the attitude set-point predicts, {:.0} % are needed",
            100.0 * r2.max(0.0),
            100.0 * LEAST_R2
        ));
    }
    if gain < 0.0 {
        return Err(format!(
            "the body turns against the torque ({gain:.1} rad/s2 per unit): the sign of an axis is wrong"
        ));
    }
    // In this form the comparison also refuses NaN.
    if standard_error < LARGEST_ERROR * gain {
        return Ok(());
    }
    Err(format!(
        "the gain is uncertain: {gain:.1} +- {standard_error:.1} rad/s2 per unit, {:.0} % of the gain are allowed",
        100.0 * LARGEST_ERROR
    ))
}

/// For each block: whether the gain fits it about as well as most blocks, or errs by less than the motion that the set-point
/// predicts.
fn fitting(blocks: &[Block], found: &Round) -> Vec<bool> {
    let gain = ratio(&found.products);
    let errors: Vec<f64> = blocks
        .iter()
        .map(|block| {
            let Lagged { uy, uu, .. } = block.lags[found.lag];
            (block.yy - 2.0 * gain * uy + gain * gain * uu).max(0.0).sqrt()
        })
        .collect();
    let mut sorted = errors.clone();
    sorted.sort_by(f64::total_cmp);
    let most = OUTLIER * sorted.get(sorted.len() / 2).copied().unwrap_or(f64::MAX);
    let answered = found.predicted.iter().map(|square| gain.abs() * square.sqrt());
    errors.iter().zip(answered).map(|(error, answered)| *error <= most + answered).collect()
}

/// Standard error by a jackknife over blocks.
fn standard_error(products: &[(f64, f64)]) -> f64 {
    let n = products.len() as f64;
    let without: Vec<f64> = (0..products.len())
        .map(|i| ratio(&[&products[..i], &products[i + 1..]].concat()))
        .collect();
    let mean = without.iter().sum::<f64>() / n;
    ((n - 1.0) / n * without.iter().map(|k| squared(k - mean)).sum::<f64>()).sqrt()
}

#[cfg(test)]
#[path = "torque_fit_tests.rs"]
mod tests;
