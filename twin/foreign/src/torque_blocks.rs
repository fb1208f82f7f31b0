//! Sums over blocks of 2 s of a flight, from which the gain of a normalised torque is fitted.
//!
//! In: torque, attitude set-point, angular acceleration. Out: per axis a [`Block`] for every 2 s in the air during which all
//! three are known.

use std::ops::Range;

use nalgebra::{SMatrix, SVector};

use super::grid::{Ticks, filtered_times};
use super::series::Series;
use super::thrust_fit::{BLOCK_TICKS, LONGEST_LAG_TICKS};
use twin_core::notation::TICK_S;

/// Number of taps of the set-point, and the ticks between two taps.
pub(super) const TAPS: usize = 12;
const TAP_TICKS: usize = 5;

/// Half width of the moving mean, ticks (0.5 s). The mean removes slow changes, which are trim or disturbance.
const SLOW_TICKS: usize = 50;

pub(super) type Square = SMatrix<f64, TAPS, TAPS>;
pub(super) type Column = SVector<f64, TAPS>;

/// The data of all three axes to which a gain is fitted.
pub(super) struct Known<'a> {
    /// Time of every tick, s.
    pub times_s: &'a [f64],
    /// Normalised torque about the body axes.
    pub torque: &'a Series<3>,
    /// Commanded roll, pitch and yaw, rad.
    pub setpoint: &'a Series<3>,
    /// Angular acceleration of the body, rad/s², after `passes` passes of `H`.
    pub acceleration: &'a Ticks<3>,
    /// Number of passes of `H`.
    pub passes: usize,
    /// Whether the vehicle is airborne, per tick.
    pub airborne: &'a [bool],
}

/// The blocks of every axis.
pub(super) fn blocks(known: &Known<'_>) -> [Vec<Block>; 3] {
    let (newest, oldest) = (known.delayed(0), known.delayed(LONGEST_LAG_TICKS));
    let taps =
        |tick: usize| (0..TAPS).all(|tap| known.setpoint.linear(known.tap_s(tick, tap)).is_some());
    // A tick whose torque is known at the shortest and at the longest lag is known at the lags between, because the filter
    // settles as long at each.
    let usable = |tick: &usize| {
        let tick = *tick;
        let torque = newest[tick].is_some() && oldest[tick].is_some();
        torque && known.airborne[tick] && known.acceleration[tick].is_some() && taps(tick)
    };
    let ticks: Vec<usize> = (0..known.times_s.len()).filter(usable).collect();
    let runs: Vec<Range<usize>> = ticks
        .chunk_by(|a, b| a + 1 == *b)
        .map(|run| run[0]..run[0] + run.len())
        .filter(|run| run.len() >= BLOCK_TICKS)
        .collect();
    let mut axes: [Vec<Block>; 3] = std::array::from_fn(|axis| of_axis(known, axis, &runs));
    for lag in 0..=LONGEST_LAG_TICKS {
        let torque = known.delayed(lag);
        for (axis, blocks) in axes.iter_mut().enumerate() {
            let values = |tick: usize| torque[tick].map_or(0.0, |u| u[axis]);
            add_lag(blocks, &Fast::of(&runs, known.times_s.len(), values), values);
        }
    }
    axes
}

impl Known<'_> {
    fn delayed(&self, lag: usize) -> Ticks<3> {
        let lag_s = lag as f64 * TICK_S;
        let raw = self.times_s.iter().map(|t_s| self.torque.linear(t_s - lag_s)).collect();
        filtered_times(&raw, self.passes)
    }

    fn tap_s(&self, tick: usize, tap: usize) -> f64 {
        self.times_s[tick] - (tap * TAP_TICKS) as f64 * TICK_S
    }
}

/// Values per tick minus their moving mean.
struct Fast(Vec<f64>);

impl Fast {
    fn of(runs: &[Range<usize>], ticks: usize, value: impl Fn(usize) -> f64) -> Self {
        let mut fast = vec![0.0; ticks];
        for run in runs {
            let mut sums = vec![0.0];
            let mut sum = 0.0;
            for tick in run.clone() {
                sum += value(tick);
                sums.push(sum);
            }
            for tick in run.clone() {
                let from = tick.saturating_sub(SLOW_TICKS).max(run.start) - run.start;
                let to = (tick + SLOW_TICKS + 1).min(run.end) - run.start;
                fast[tick] = value(tick) - (sums[to] - sums[from]) / (to - from) as f64;
            }
        }
        Self(fast)
    }
}

/// Sums of products over a block: `z` are taps of the set-point, `y` is acceleration, `u` is torque.
pub(super) struct Block {
    ticks: Range<usize>,
    z: Vec<Column>,
    y: Vec<f64>,
    /// Mean acceleration with its slow part, rad/s².
    pub mean_y: f64,
    pub zz: Square,
    pub zy: Column,
    pub yy: f64,
    /// Sums with the delayed torque, by lag in ticks.
    pub lags: Vec<Lagged>,
}

/// Sums of products with a delayed torque.
#[derive(Clone, Copy)]
pub(super) struct Lagged {
    /// Mean torque with its slow part.
    pub mean_u: f64,
    pub zu: Column,
    pub uy: f64,
    pub uu: f64,
}

/// The blocks of one axis, without lags.
fn of_axis(known: &Known<'_>, axis: usize, runs: &[Range<usize>]) -> Vec<Block> {
    let ticks = known.times_s.len();
    let turning = |tick: usize| known.acceleration[tick].map_or(0.0, |y| y[axis]);
    let acceleration = Fast::of(runs, ticks, turning);
    let taps: [Fast; TAPS] = std::array::from_fn(|tap| {
        let wanted = |tick| known.setpoint.linear(known.tap_s(tick, tap)).map_or(0.0, |z| z[axis]);
        Fast::of(runs, ticks, wanted)
    });
    let block = |ticks: Range<usize>| {
        let z: Vec<Column> =
            ticks.clone().map(|t| Column::from_fn(|tap, _| taps[tap].0[t])).collect();
        let y = acceleration.0[ticks.clone()].to_vec();
        Block {
            mean_y: ticks.clone().map(turning).sum::<f64>() / ticks.len() as f64,
            zz: z.iter().map(|z| z * z.transpose()).sum(),
            zy: z.iter().zip(&y).map(|(z, y)| z * *y).sum(),
            yy: y.iter().map(|y| y * y).sum(),
            lags: Vec::new(),
            ticks,
            z,
            y,
        }
    };
    let starts = |run: &Range<usize>| (run.start..=run.end - BLOCK_TICKS).step_by(BLOCK_TICKS);
    runs.iter().flat_map(starts).map(|start| block(start..start + BLOCK_TICKS)).collect()
}

/// Adds the sums at the next lag to every block.
fn add_lag(blocks: &mut [Block], torque: &Fast, value: impl Fn(usize) -> f64) {
    for block in blocks {
        let u = &torque.0[block.ticks.clone()];
        block.lags.push(Lagged {
            mean_u: block.ticks.clone().map(&value).sum::<f64>() / u.len() as f64,
            zu: block.z.iter().zip(u).map(|(z, u)| z * *u).sum(),
            uy: block.y.iter().zip(u).map(|(y, u)| y * u).sum(),
            uu: u.iter().map(|u| u * u).sum(),
        });
    }
}
