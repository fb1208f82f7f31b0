//! Gravity plus an adapted correction on random `tanh` features: an adapter that needs no training.
//!
//! `g' = tanh(A z + b)`, where `z` contains attitude, joints, rates and previous force, each divided by a fixed scale. A seed
//! determines `A` and `b`, so the configuration alone determines the predictor.

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

/// Standard deviation of the entries of `A`: in normal flight the features stay in the curved part of `tanh`.
const PROJECTION_STD: f64 = 0.5;

/// Standard deviation of the offsets `b`.
const OFFSET_STD: f64 = 0.3;

/// Slow forces (the moving mean) are divided by this number times the residual's standard deviation. A payload is about three
/// standard deviations.
const SLOW_SCALE: f64 = 3.0;

/// Fast forces (the rest) are divided by this number times the residual's standard deviation. The scale is small, so that
/// hovering excites every feature; otherwise the adapter would learn the residual of a hover as slowly as a bias.
const FAST_SCALE: f64 = 0.3;

/// Time constant of the moving mean, ticks.
const MEAN_TICKS: f64 = 60.0;

/// Scales of attitude (rad), of joint angles (rad) and of the eight rates (m/s, rad/s).
const ATTITUDE_SCALE_RAD: f64 = 0.1;
const JOINT_SCALE_RAD: f64 = 0.5;
pub(super) const RATE_SCALE: [f64; 8] = [0.5, 0.5, 0.3, 0.3, 0.3, 0.2, 0.5, 0.5];

/// Typical joint angles around which the features are centred, rad.
const JOINT_CENTRE_RAD: [f64; 2] = [0.15, 1.24];

/// The random features as a predictor, with a fixed projection.
#[derive(Clone)]
pub struct RandomFeatures {
    model: GravityModel,
    projection: DMatrix<f64>,
    offset: DVector<f64>,
    mean: Option<Coords>,
}

impl RandomFeatures {
    /// A predictor with `d_k` features drawn from `seed`, over the gravity force `model`. The first feature is constant.
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
    use std::sync::Arc;

    use super::*;
    use crate::elementary::sin;

    fn features(seed: u64) -> RandomFeatures {
        RandomFeatures::new(Arc::new(|_| Coords::repeat(1.0)), 32, seed)
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
