//! Adds a multisine to the output of another control law, so that a residual can be learned from the flight.
//!
//! In: the set-point of the other law. Out: that set-point with a sum of sines on forces, moments and joint torques. State: time
//! since the first tick. Source: control study, section 6: from smooth flights alone a predictor learns to copy `tau_{t-1}`.

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{Controller, Gains, Input};
use crate::elementary::{powf, sin};
use crate::notation::{Coords, N};
use crate::tick::{ControlState, Setpoint};

/// Time in which the excitation grows from zero, s, so that it does not disturb a grasp at the start.
const GROW_S: f64 = 2.0;

/// Makes these random draws independent of other draws from the same seed.
const STREAM: u64 = 0x0e8c_17ed;

/// A sum of sines for each coordinate.
#[derive(Clone, Debug)]
pub struct Multisine {
    /// Per coordinate and tone: amplitude in N or N m, frequency in rad/s, phase in rad.
    tones: [Vec<(f64, f64, f64)>; N],
}

impl Multisine {
    /// A multisine with `tones` sines per coordinate. The frequencies are log-spaced over `force_hz` for x y z and over
    /// `moment_hz` for the other coordinates, Hz. The amplitudes of a coordinate are equal and give the root mean square `rms` (N
    /// and N m). `seed` shifts each frequency by up to 3 % and draws the phases, so that the coordinates are uncorrelated.
    pub fn new(
        tones: usize,
        force_hz: [f64; 2],
        moment_hz: [f64; 2],
        rms: [f64; N],
        seed: u64,
    ) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed ^ STREAM);
        let tones = std::array::from_fn(|row| {
            let [low, high] = if row < 3 { force_hz } else { moment_hz };
            let amplitude = rms[row] * (2.0 / tones.max(1) as f64).sqrt();
            (0..tones)
                .map(|tone| {
                    let part = tone as f64 / (tones.max(2) - 1) as f64;
                    let beside = 1.0 + 0.03 * (2.0 * rng.random::<f64>() - 1.0);
                    let hz = low * powf(high / low, part) * beside;
                    (amplitude, TAU * hz, 2.0 * PI * rng.random::<f64>())
                })
                .collect()
        });
        Self { tones }
    }

    /// Forces and moments at `t_s` seconds after the start, N and N m.
    pub fn at(&self, t_s: f64) -> Coords {
        let grown = (t_s / GROW_S).clamp(0.0, 1.0);
        Coords::from_fn(|row, _| {
            let sum = self.tones[row].iter().map(|(a, w, phase)| a * sin(w * t_s + phase));
            sum.sum::<f64>() * grown
        })
    }
}

/// A control law with an excitation on its output.
#[derive(Clone)]
pub struct Excited {
    law: Box<dyn Controller>,
    multisine: Multisine,
    t_s: f64,
}

impl Excited {
    /// A controller that adds `multisine` to the forces, moments and joint torques of `law`.
    pub fn new(law: Box<dyn Controller>, multisine: Multisine) -> Self {
        Self { law, multisine, t_s: 0.0 }
    }
}

impl Controller for Excited {
    fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState) {
        let (mut setpoint, state) = self.law.control(input, gains);
        let extra = self.multisine.at(self.t_s);
        self.t_s += input.dt_s;
        for axis in 0..3 {
            setpoint.force_in_world_n[axis] += extra[axis];
        }
        // The excitation of moments and joint torques is added to the residual estimate, which both inner controllers pass on
        // unchanged.
        for row in 3..N {
            setpoint.r_hat[row] += extra[row];
        }
        (setpoint, state)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RMS: [f64; N] = [1.5, 1.5, 2.5, 0.12, 0.12, 0.05, 0.15, 0.10];

    fn multisine(seed: u64) -> Multisine {
        Multisine::new(6, [0.2, 5.0], [0.2, 8.0], RMS, seed)
    }

    #[test]
    fn each_row_has_the_power_it_was_given_and_no_mean() {
        let series: Vec<Coords> =
            (0..30_000).map(|tick| multisine(3).at(GROW_S + f64::from(tick) * 0.01)).collect();
        for row in 0..N {
            let n = series.len() as f64;
            let mean = series.iter().map(|v| v[row]).sum::<f64>() / n;
            let rms = (series.iter().map(|v| v[row] * v[row]).sum::<f64>() / n).sqrt();
            // 300 s contain 60 periods of the slowest tone. The share of an unfinished period is below 2 %.
            assert!((rms / RMS[row] - 1.0).abs() < 0.02, "row {row}: {rms}");
            assert!(mean.abs() < 0.02 * RMS[row], "row {row}: {mean}");
        }
        for (a, b) in [(0, 1), (3, 4), (6, 7), (2, 5)] {
            let dot: f64 = series.iter().map(|v| v[a] * v[b]).sum::<f64>() / series.len() as f64;
            assert!(dot.abs() < 0.1 * RMS[a] * RMS[b], "rows {a} and {b} are correlated: {dot}");
        }
    }

    #[test]
    fn it_begins_at_rest_and_the_seed_decides_it() {
        assert_eq!(multisine(1).at(0.0), Coords::zeros());
        assert_eq!(multisine(1).at(7.3), multisine(1).at(7.3));
        assert_ne!(multisine(1).at(7.3), multisine(2).at(7.3));
    }
}
