//! ARX: an autoregression of the residual with rates and forces as further inputs, learned in flight by recursive least squares (RLS)
//! with forgetting. Ljung, System Identification: Theory for the User, 2nd edition, 1999, sec. 11.2. It needs no training.
//!
//! In: residuals, rates and forces of the last ticks. Out: forecasts for `j = 0..=k`. State: the weights of `KNOTS`, one covariance,
//! and the inputs whose residuals are still unknown.
//!
//! A knot `j` has weights of its own, which map the inputs to `r_{t+j}`; between the knots the forecast is interpolated. The gain of a
//! tick depends on its inputs alone, so one covariance serves all knots: the weights of knot `j` learn `j + 1` ticks later, with the gain
//! of that time. It learns from every tick, also in contact.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

use super::knots::{KNOTS, between};
use super::random_features::RATE_SCALE;
use super::{HORIZON, History, NOMINAL_SCALE, Predictor};
use crate::notation::{Coords, N};
use crate::tick::Forecast;

/// Number of ticks whose residual, rates and force are inputs. With 4 the RMSE on the test flight is a third below that with 2, and
/// 6 gain nothing.
pub const TICKS: usize = 4;

/// Number of inputs: a constant, and three groups of coordinates for each tick.
pub(super) const INPUTS: usize = 1 + 3 * N * TICKS;

/// Weight of an error of the previous tick relative to one of this tick: a memory of 20 s, in which every coordinate moves.
const FORGETTING: f64 = 0.9995;

/// Bound on the trace of the covariance for each input, so that it stays finite where nothing moves.
const TRACE_CAP_PER_INPUT: f64 = 10.0;

/// Inputs of a tick, with the gain by which their errors change the weights.
#[derive(Clone, Debug)]
struct Asked {
    /// `[INPUTS]`.
    inputs: DVector<f64>,
    /// `[INPUTS]`.
    gain: DVector<f64>,
}

/// The autoregression as a predictor.
#[derive(Clone, Debug)]
pub struct ArxRls {
    /// Weights of each of `KNOTS`, `[INPUTS, N]`, between values that are divided by their scales.
    weights: Vec<DMatrix<f64>>,
    /// `[INPUTS, INPUTS]`.
    covariance: DMatrix<f64>,
    /// What was asked, newest first, as far back as the last knot.
    asked: VecDeque<Asked>,
}

impl Default for ArxRls {
    /// The predictor before its first tick: it forecasts the last residual.
    fn default() -> Self {
        let mut persistence = DMatrix::zeros(INPUTS, N);
        persistence.view_mut((1, 0), (N, N)).fill_with_identity();
        Self {
            weights: vec![persistence; KNOTS.len()],
            covariance: DMatrix::identity(INPUTS, INPUTS),
            asked: VecDeque::with_capacity(HORIZON + 1),
        }
    }
}

/// The inputs of the newest tick, `[INPUTS]`: a constant, then residual, rates and force of each tick, newest first. At the start the
/// oldest entry stands for the missing ticks. Residuals and forces are divided by `scale`, N and N m.
pub(super) fn inputs_of(history: &History, scale: &Coords) -> DVector<f64> {
    let mut inputs = DVector::zeros(INPUTS);
    inputs[0] = 1.0;
    let rate_scale = Coords::from(RATE_SCALE);
    let newest = history.len().saturating_sub(1);
    for tick in 0..TICKS {
        let Some(entry) = history.iter().nth(newest.saturating_sub(tick)) else { break };
        let groups = [
            (&entry.residual_previous, scale),
            (&entry.chi_dot, &rate_scale),
            (&entry.tau_previous, scale),
        ];
        for (group, (values, scale)) in groups.into_iter().enumerate() {
            for row in 0..N {
                inputs[1 + (3 * tick + group) * N + row] = values[row] / scale[row];
            }
        }
    }
    inputs
}

impl ArxRls {
    /// Learns the residual of the previous tick, N and N m: each knot from the inputs of so many ticks before.
    fn learn(&mut self, residual: &Coords) {
        let z = residual.component_div(&Coords::from(NOMINAL_SCALE));
        for (weights, knot) in self.weights.iter_mut().zip(KNOTS) {
            let Some(Asked { inputs, gain }) = self.asked.get(knot) else { continue };
            let error = z - weights.tr_mul(inputs);
            weights.ger(1.0, gain, &error, 1.0);
        }
    }

    /// The gain for `inputs`; updates the covariance.
    fn gain(&mut self, inputs: &DVector<f64>) -> DVector<f64> {
        let p_inputs = &self.covariance * inputs;
        let gain = &p_inputs / (FORGETTING + inputs.dot(&p_inputs));
        self.covariance.ger(-1.0, &gain, &p_inputs, 1.0);
        let cap = TRACE_CAP_PER_INPUT * INPUTS as f64;
        let scale = FORGETTING.recip().min(cap / self.covariance.trace());
        // The mean with the transpose keeps roundings from making the matrix asymmetric.
        for column in 0..INPUTS {
            for row in 0..=column {
                let mean = (self.covariance[(row, column)] + self.covariance[(column, row)]) * 0.5;
                self.covariance[(row, column)] = mean * scale;
                self.covariance[(column, row)] = mean * scale;
            }
        }
        gain
    }
}

impl Predictor for ArxRls {
    fn regime_len(&self) -> usize {
        0
    }

    fn history_len(&self) -> usize {
        TICKS
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let inputs = inputs_of(history, &Coords::from(NOMINAL_SCALE));
        let finite = inputs.iter().all(|value| value.is_finite());
        if finite {
            if let Some(entry) = history.newest() {
                self.learn(&entry.residual_previous);
            }
            let gain = self.gain(&inputs);
            self.asked.push_front(Asked { inputs: inputs.clone(), gain });
            self.asked.truncate(HORIZON + 1);
        } else {
            // What is asked from now on must not be compared with residuals of other ticks.
            self.asked.clear();
        }
        let scale = Coords::from(NOMINAL_SCALE);
        let knots: Vec<Coords> = self
            .weights
            .iter()
            .map(|weights| Coords::from_iterator(weights.tr_mul(&inputs).iter().copied()))
            .map(|z| z.component_mul(&scale))
            .collect();
        let base = (0..=HORIZON).map(|j| between(&knots, j).into()).collect();
        Forecast { base, regime: Vec::new(), attention: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::powi;
    use crate::notation::KnownCoords;
    use crate::residual::waves::{push, residual};

    #[test]
    fn it_starts_as_persistence_and_learns_a_wave_at_every_step() {
        // A line between knots 9 ticks apart misses a wave of at most 0.058 rad a tick by (9 / 2)² / 2 · 0.058² = 0.034. As much is
        // left to forgetting, which remembers the start for 30 s.
        const TOLERANCE: f64 = 0.07;
        const TICKS_FLOWN: usize = 3000;
        let (mut arx, mut history) = (ArxRls::default(), History::new(TICKS));
        push(&mut history, 0);
        let first = arx.predict(&history);
        assert!(first.base.iter().all(|base| (**base - residual(0)).norm() < 1e-12));
        let mut said = first;
        for tick in 1..TICKS_FLOWN {
            push(&mut history, tick);
            said = arx.predict(&history);
        }
        assert_eq!(said.base.len(), HORIZON + 1);
        for (j, base) in said.base.iter().enumerate() {
            let error = (**base - residual(TICKS_FLOWN - 1 + j)).amax();
            assert!(error < TOLERANCE, "{error} at {j}");
        }
        let persistence = (residual(TICKS_FLOWN - 2) - residual(TICKS_FLOWN - 1 + HORIZON)).amax();
        assert!(persistence > 5.0 * TOLERANCE, "{persistence}");
    }

    #[test]
    fn the_weights_of_every_knot_are_those_of_weighted_least_squares() {
        // Rounding of sums of hundreds of numbers of order ten, times the condition of the normal equations with the prior, near 1e5.
        const BATCH_TOLERANCE: f64 = 1e-6;
        const TICKS_FLOWN: usize = 120;
        let (mut arx, mut history) = (ArxRls::default(), History::new(TICKS));
        let mut asked = Vec::new();
        let scale = Coords::from(NOMINAL_SCALE);
        for tick in 0..TICKS_FLOWN {
            push(&mut history, tick);
            asked.push(inputs_of(&history, &scale));
            arx.predict(&history);
        }
        for (at, knot) in KNOTS.into_iter().enumerate() {
            // The last call learned the residual of tick TICKS_FLOWN - 2, which knot j asked about j ticks before.
            let lessons = TICKS_FLOWN - 1 - knot;
            let weight = |ago: usize| powi(FORGETTING, i32::try_from(ago).unwrap());
            let mut a = DMatrix::identity(INPUTS, INPUTS) * weight(lessons);
            let mut b = ArxRls::default().weights[at].clone() * weight(lessons);
            for (tick, inputs) in asked.iter().take(lessons).enumerate() {
                let z = residual(tick + knot).component_div(&scale);
                let w = weight(lessons - 1 - tick);
                a += inputs * inputs.transpose() * w;
                b += inputs * z.transpose() * w;
            }
            let wanted = a.cholesky().unwrap().solve(&b);
            let error = (&arx.weights[at] - wanted).amax();
            assert!(error < BATCH_TOLERANCE, "{error} at knot {knot}");
        }
    }

    #[test]
    fn a_number_that_is_not_finite_is_answered_and_not_learned() {
        let (mut arx, mut history) = (ArxRls::default(), History::new(TICKS));
        for tick in 0..50 {
            push(&mut history, tick);
            arx.predict(&history);
        }
        let (weights, covariance) = (arx.weights.clone(), arx.covariance.clone());
        history.push(Coords::repeat(f64::NAN), Coords::repeat(f64::NAN), residual(0), residual(0));
        assert!(!arx.predict(&history).base[0].is_finite());
        assert_eq!((&arx.weights, &arx.covariance), (&weights, &covariance));
        for tick in 50..60 {
            push(&mut history, tick);
            arx.predict(&history);
        }
        assert!(arx.predict(&history).base.iter().all(KnownCoords::is_finite));
    }
}
