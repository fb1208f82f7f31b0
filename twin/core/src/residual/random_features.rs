//! Gravity plus an adapted correction on random `tanh` features: the adapter at work without any training.
//!
//! `g' = tanh(A z + b)`, `z` = attitude, joints, rates and previous force, each divided by a fixed scale. `A`, `b` come from a
//! seed, so the predictor is a function of its configuration alone.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::{GravityModel, History, NOMINAL_SCALE, Predictor, constant_forecast, gravity};
use crate::elementary::tanh;
use crate::normal::StandardNormal;
use crate::notation::Coords;
use crate::tick::Forecast;

/// Inputs: phi, theta, q1, q2, eight rates, eight slow forces, eight fast forces.
const N_INPUTS: usize = 28;

/// Spread of the rows of `A`: features stay in the bent part of `tanh` over normal flight.
const PROJECTION_STD: f64 = 0.5;

/// Spread of the offsets `b`.
const OFFSET_STD: f64 = 0.3;

/// Slow forces (their moving mean) are divided by this times the residual's spread: a payload is three spreads.
const SLOW_SCALE: f64 = 3.0;

/// Fast forces (the rest) are divided by this times the residual's spread: fine enough that hovering excites every feature, or
/// the adapter learns the residual of a hover at the pace of a bias.
const FAST_SCALE: f64 = 0.3;

/// Time constant of the moving mean, ticks.
const MEAN_TICKS: f64 = 60.0;

/// Scale of attitude (rad), joint angles (rad), then of the eight rates (m/s, rad/s).
const ATTITUDE_SCALE_RAD: f64 = 0.1;
const JOINT_SCALE_RAD: f64 = 0.5;
const RATE_SCALE: [f64; 8] = [0.5, 0.5, 0.3, 0.3, 0.3, 0.2, 0.5, 0.5];

/// Typical joint angles around which the features are centred, rad.
const JOINT_CENTRE_RAD: [f64; 2] = [0.15, 1.24];

/// The predictor's fixed random projection.
pub struct RandomFeatures {
    model: GravityModel,
    projection: DMatrix<f64>,
    offset: DVector<f64>,
    mean: Option<Coords>,
}

impl RandomFeatures {
    /// `d_k` features drawn from `seed`, over the gravity force of the vehicle. The first feature is constant.
    pub fn new(model: GravityModel, d_k: usize, seed: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut projection = DMatrix::from_fn(d_k, N_INPUTS, |_, _| draw() * PROJECTION_STD);
        let mut offset = DVector::from_fn(d_k, |_, _| draw() * OFFSET_STD);
        if d_k > 0 {
            projection.row_mut(0).fill(0.0);
            offset[0] = 20.0;
        }
        Self { model, projection, offset, mean: None }
    }

    fn inputs(&mut self, history: &History) -> DVector<f64> {
        let mut z = DVector::zeros(N_INPUTS);
        let Some(entry) = history.newest() else { return z };
        let force = entry.tau_previous - (self.model)(&entry.chi);
        let mean = self.mean.map_or(force, |mean| mean + (force - mean) / MEAN_TICKS);
        self.mean = Some(mean);
        z[0] = entry.chi[3] / ATTITUDE_SCALE_RAD;
        z[1] = entry.chi[4] / ATTITUDE_SCALE_RAD;
        for joint in 0..2 {
            z[2 + joint] = (entry.chi[6 + joint] - JOINT_CENTRE_RAD[joint]) / JOINT_SCALE_RAD;
        }
        for row in 0..8 {
            z[4 + row] = entry.chi_dot[row] / RATE_SCALE[row];
            z[12 + row] = mean[row] / (SLOW_SCALE * NOMINAL_SCALE[row]);
            z[20 + row] = (force[row] - mean[row]) / (FAST_SCALE * NOMINAL_SCALE[row]);
        }
        z
    }
}

impl Predictor for RandomFeatures {
    fn regime_len(&self) -> usize {
        self.offset.len()
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let inputs = self.inputs(history);
        let regime = (&self.projection * inputs + &self.offset).map(tanh);
        let base: Coords = gravity::base(&self.model, history);
        constant_forecast(base, regime.iter().copied().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::sin;

    fn features(seed: u64) -> RandomFeatures {
        RandomFeatures::new(Box::new(|_| Coords::repeat(1.0)), 32, seed)
    }

    #[test]
    fn regime_norm_is_in_the_range_the_adapter_expects() {
        let mut history = History::new(1);
        for i in 0..50 {
            let wave = Coords::from_fn(|row, _| sin(0.3 * f64::from(i) + row as f64) * 0.3);
            history.push(wave, wave, wave, wave);
            let norm = features(1).predict(&history).regime.iter().map(|v| v * v).sum::<f64>();
            assert!((1.0..=30.0).contains(&norm), "|g'|^2 = {norm}");
        }
    }

    #[test]
    fn the_seed_decides_the_features() {
        let mut history = History::new(1);
        let v = Coords::repeat(0.2);
        history.push(v, v, v, v);
        assert_eq!(features(1).predict(&history), features(1).predict(&history));
        assert_ne!(features(1).predict(&history).regime, features(2).predict(&history).regime);
    }
}
