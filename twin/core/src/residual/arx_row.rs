//! The autoregression of one coordinate: recursive least squares (RLS) for several steps ahead, shrunk towards the mean so far.
//!
//! In: the inputs of a tick, and whether they are known. Out: a forecast for each of [`KNOTS`], N or N m. State: weights, covariance,
//! running mean and deviation of residual and force, the shrinkage of each knot, and the inputs whose residuals are still to come.
//!
//! Weights belong to z-scores, so that a vehicle of 30 g and one of 3 kg, and forces and torques, have the same prior.

use std::collections::VecDeque;

use nalgebra::{SMatrix, SVector};

use super::HORIZON;
use super::knots::KNOTS;
use crate::elementary::squared;

/// Number of past residuals that are inputs. The residual passed a filter of second order, so four of them continue it; six leave room
/// for the vehicle, and ten foresee recorded flights no better.
pub(super) const RESIDUALS: usize = 6;

/// Ages in ticks of the applied forces that are inputs: what was commanded shows in the residual up to 100 ms later.
pub(super) const FORCE_AGES: [usize; 3] = [0, 4, 10];

/// Number of inputs: a constant, residuals, forces, and the rate of the coordinate.
const INPUTS: usize = 1 + RESIDUALS + FORCE_AGES.len() + 1;

/// Place of the first force among the inputs.
const FORCES: usize = 1 + RESIDUALS;

/// Weight of an error of the previous tick relative to one of this tick: a memory of 50 s. Shorter memories fit the noise of the long
/// steps on recorded flights.
const FORGETTING: f64 = 0.9998;

/// Initial variance of the weights: of the constant, of past residuals, and of forces and rate. The mean is subtracted before, so the
/// constant has little left to learn.
const PRIOR: [f64; 3] = [0.01, 1.0, 0.1];

/// Bound on the trace of the covariance, as a multiple of its initial trace, so that it stays finite where nothing moves.
const TRACE_CAP: f64 = 10.0;

/// Largest error that teaches in full, standard deviations: one bump of a landing must not move the weights of a whole flight.
const LARGEST_LESSON: f64 = 3.0;

/// Largest forecast, standard deviations, and its multiple of the largest recent residual at each knot. A residual that already is
/// large may go on growing for some ticks, and not longer.
const LARGEST_FORECAST: f64 = 2.0;
const GROWTH: [f64; KNOTS.len()] = [1.5, 1.5, 1.5, 1.2, 1.0, 1.0];

/// Shrinkage of each knot before the first lesson (1 is none), and the number of ticks of unit variance for which it counts. The next
/// tick follows from the last ones on every vehicle; what 250 ms bring must be shown first.
const SHRINKAGE: [f64; KNOTS.len()] = [1.0, 0.9, 0.8, 0.6, 0.5, 0.5];
const SHRINKAGE_TICKS: [f64; KNOTS.len()] = [5.0, 50.0, 100.0, 200.0, 200.0, 200.0];

/// Number of ticks for which the initial scale counts among the measured deviations.
const SCALE_TICKS: f64 = 2.0;

/// Smallest standard deviation that is used as a scale, N and N m.
const LEAST_SCALE: f64 = 1e-9;

type Inputs = SVector<f64, INPUTS>;

/// What one coordinate did in the last ticks, newest first. The age 0 is the tick before the forecast.
pub(super) struct Past {
    /// Residuals, N or N m; `None` where unknown.
    pub residuals: [Option<f64>; RESIDUALS],
    /// Applied forces of [`FORCE_AGES`], N or N m; `None` where the residual is unknown.
    pub forces: [Option<f64>; FORCE_AGES.len()],
    /// Rate of this tick, m/s or rad/s.
    pub rate: f64,
}

/// A forecast that waits for its residuals.
#[derive(Clone, Debug)]
struct Asked {
    /// `None` if an input was unknown: then nothing is learned from this tick.
    lesson: Option<Lesson>,
}

#[derive(Clone, Debug)]
struct Lesson {
    inputs: Inputs,
    gain: Inputs,
    mean: f64,
    scale: f64,
    /// Forecasts before they were shrunk, z-scores.
    said: [f64; KNOTS.len()],
}

/// The autoregression of one coordinate.
#[derive(Clone, Debug)]
pub(super) struct ArxRow {
    weights: [Inputs; KNOTS.len()],
    covariance: SMatrix<f64, INPUTS, INPUTS>,
    /// Number of known residuals so far, their mean and mean squared deviation, and the mean of the force.
    count: f64,
    mean: f64,
    square: f64,
    mean_force: f64,
    /// Sums of products of forecast and residual, and of squared forecasts, per knot.
    products: [[f64; 2]; KNOTS.len()],
    /// Newest first, as far back as the last knot.
    asked: VecDeque<Asked>,
}

/// The initial variances of all weights.
fn prior() -> Inputs {
    Inputs::from_fn(|at, _| match at {
        0 => PRIOR[0],
        at if at < FORCES => PRIOR[1],
        _ => PRIOR[2],
    })
}

impl ArxRow {
    /// The row before its first tick; it forecasts the last residual. `scale` is a first guess of the residual's deviation, N or N m.
    pub(super) fn new(scale: f64) -> Self {
        let mut persistence = Inputs::zeros();
        persistence[1] = 1.0;
        let products =
            std::array::from_fn(|at| [SHRINKAGE[at] * SHRINKAGE_TICKS[at], SHRINKAGE_TICKS[at]]);
        Self {
            weights: [persistence; KNOTS.len()],
            covariance: SMatrix::from_diagonal(&prior()),
            count: 0.0,
            mean: 0.0,
            square: squared(scale),
            mean_force: 0.0,
            products,
            asked: VecDeque::with_capacity(HORIZON + 1),
        }
    }

    /// Forecasts of all knots, N or N m, after learning the newest residual of `past`. `None` before the first known residual.
    pub(super) fn step(&mut self, past: &Past) -> Option<[f64; KNOTS.len()]> {
        if let Some(residual) = past.residuals[0] {
            self.describe(residual, past.forces[0]);
            self.learn(residual);
        }
        let Some(inputs) = self.inputs(past) else {
            self.ask(None);
            let stand_in = past.residuals[0].unwrap_or(self.mean);
            return (self.count > 0.0).then_some([stand_in; KNOTS.len()]);
        };
        let gain = self.gain(&inputs);
        let said = std::array::from_fn(|at| self.weights[at].dot(&inputs));
        let (mean, scale) = (self.mean, self.scale());
        self.ask(Some(Lesson { inputs, gain, mean, scale, said }));
        let largest = inputs.fixed_rows::<RESIDUALS>(1).amax();
        Some(std::array::from_fn(|at| {
            let [with, own] = self.products[at];
            let bound = LARGEST_FORECAST.max(GROWTH[at] * largest);
            mean + scale * (said[at] * (with / own).clamp(0.0, 1.0)).clamp(-bound, bound)
        }))
    }

    fn scale(&self) -> f64 {
        self.square.sqrt().max(LEAST_SCALE)
    }

    fn ask(&mut self, lesson: Option<Lesson>) {
        self.asked.push_front(Asked { lesson });
        self.asked.truncate(HORIZON + 1);
    }

    /// Takes a residual and its force into the mean and the deviation.
    fn describe(&mut self, residual: f64, force: Option<f64>) {
        let force = force.unwrap_or(self.mean_force);
        let share = (self.count + 1.0).recip();
        self.mean += share * (residual - self.mean);
        self.mean_force += share * (force - self.mean_force);
        let share = (self.count + 1.0 + SCALE_TICKS).recip();
        self.square += share * (squared(residual - self.mean) - self.square);
        self.count += 1.0;
    }

    /// Inputs as z-scores; `None` if a residual is unknown. The mean stands for an unknown force.
    fn inputs(&self, past: &Past) -> Option<Inputs> {
        let scale = self.scale();
        let mut inputs = Inputs::zeros();
        inputs[0] = 1.0;
        for (at, residual) in past.residuals.iter().enumerate() {
            inputs[1 + at] = ((*residual)? - self.mean) / scale;
        }
        for (at, force) in past.forces.iter().enumerate() {
            inputs[FORCES + at] = (force.unwrap_or(self.mean_force) - self.mean_force) / scale;
        }
        inputs[INPUTS - 1] = past.rate;
        inputs.iter().all(|value| value.is_finite()).then_some(inputs)
    }

    /// Learns the residual of the previous tick: each knot from the inputs of so many ticks before.
    fn learn(&mut self, residual: f64) {
        for (at, knot) in KNOTS.into_iter().enumerate() {
            let Some(Asked { lesson: Some(lesson) }) = self.asked.get(knot) else { continue };
            let z = (residual - lesson.mean) / lesson.scale;
            let error =
                (z - self.weights[at].dot(&lesson.inputs)).clamp(-LARGEST_LESSON, LARGEST_LESSON);
            self.weights[at] += lesson.gain * error;
            let said = lesson.said[at];
            let large = said.abs().max(z.abs()) / LARGEST_LESSON;
            let weight = squared(large.max(1.0)).recip();
            self.products[at][0] += weight * said * z;
            self.products[at][1] += weight * said * said;
        }
    }

    /// The gain for `inputs`; updates the covariance.
    fn gain(&mut self, inputs: &Inputs) -> Inputs {
        let p_inputs = self.covariance * inputs;
        let gain = p_inputs / (FORGETTING + inputs.dot(&p_inputs));
        self.covariance -= gain * p_inputs.transpose();
        let cap = TRACE_CAP * prior().sum();
        let scale = FORGETTING.recip().min(cap / self.covariance.trace());
        // The mean with the transpose keeps roundings from making the matrix asymmetric.
        self.covariance = (self.covariance + self.covariance.transpose()) * (0.5 * scale);
        gain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::{cos, powi, sin};

    fn residual(tick: usize) -> f64 {
        5.0 + cos(tick as f64 * 0.04) + 0.3 * sin(tick as f64 * 0.11)
    }

    fn past(tick: usize, of: impl Fn(usize) -> Option<f64>) -> Past {
        let force = |age: usize| of(tick - age).map(|_| 9.0 + sin((tick - age) as f64 * 0.021));
        Past {
            residuals: std::array::from_fn(|age| of(tick - age)),
            forces: FORCE_AGES.map(force),
            rate: cos(tick as f64 * 0.017),
        }
    }

    #[test]
    fn the_weights_of_every_knot_are_those_of_weighted_least_squares_with_the_prior() {
        // Rounding of sums of hundreds of numbers of order one, times the condition of the normal equations, near 1e5.
        const TOLERANCE: f64 = 1e-7;
        const FROM: usize = 20;
        const TICKS: usize = 300;
        let mut row = ArxRow::new(1.0);
        let mut asked = Vec::new();
        for tick in FROM..FROM + TICKS {
            row.step(&past(tick, |t| Some(residual(t)))).unwrap();
            let Some(Asked { lesson: Some(lesson) }) = row.asked.front() else { panic!("asked") };
            asked.push(lesson.clone());
        }
        for (at, knot) in KNOTS.into_iter().enumerate() {
            let lessons = TICKS - 1 - knot;
            let weight = |ago: usize| powi(FORGETTING, i32::try_from(ago).unwrap());
            let prior = SMatrix::from_diagonal(&prior().map(f64::recip)) * weight(lessons);
            let mut persistence = Inputs::zeros();
            persistence[1] = 1.0;
            let (mut a, mut b) = (prior, prior * persistence);
            for (n, lesson) in asked.iter().take(lessons).enumerate() {
                // The tick that was asked at FROM + n knows residuals up to FROM + n, and forecasts that of one tick later.
                let z = (residual(FROM + n + 1 + knot) - lesson.mean) / lesson.scale;
                let w = weight(lessons - 1 - n);
                a += lesson.inputs * lesson.inputs.transpose() * w;
                b += lesson.inputs * z * w;
            }
            let error = (row.weights[at] - a.cholesky().unwrap().solve(&b)).amax();
            assert!(error < TOLERANCE, "{error} at knot {knot}");
        }
    }

    #[test]
    fn what_cannot_be_foreseen_is_forecast_as_the_mean() {
        // Noise without memory: the best forecast is its mean, and persistence errs by the square root of two times as much.
        const TICKS: usize = 6000;
        let noise = |tick: usize| {
            let mut x = (tick as u64 + 7).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            4.0 + ((x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
        };
        let mut row = ArxRow::new(1.0);
        let (mut squares, mut scored) = ([0.0; KNOTS.len()], 0.0);
        for tick in 20..TICKS {
            let said = row.step(&past(tick, |t| Some(noise(t)))).unwrap();
            if tick < TICKS / 2 {
                continue;
            }
            scored += 1.0;
            for (at, knot) in KNOTS.into_iter().enumerate() {
                squares[at] += squared(noise(tick + 1 + knot) - said[at]);
            }
        }
        // A uniform distribution of half width 1 has the variance 1/3; 3000 samples estimate it within 3 %.
        for square in squares {
            assert!((square / scored * 3.0).sqrt() < 1.03, "{squares:?}");
        }
    }

    #[test]
    fn an_unknown_residual_teaches_nothing_and_the_mean_stands_for_it() {
        let known = |tick: usize| (!(400..430).contains(&tick)).then(|| residual(tick));
        let mut row = ArxRow::new(1.0);
        assert_eq!(row.step(&past(20, |_| None)), None);
        for tick in 20..400 {
            row.step(&past(tick, known)).unwrap();
        }
        let (weights, mean) = (row.weights, row.mean);
        for tick in 400..430 {
            assert_eq!(row.step(&past(tick, known)), Some([mean; KNOTS.len()]));
        }
        assert_eq!(row.weights, weights);
        // After the gap all lags must be known again before anything is learned: forecasts of before the gap are not compared with it.
        assert_eq!(row.step(&past(430, known)), Some([residual(430); KNOTS.len()]));
    }
}
