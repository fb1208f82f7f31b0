//! Correction of the whole horizon: recursive least squares (RLS) on what the forecast of the predictor and its adapter leaves over.
//!
//! In: the forecast, the adapter's correction of it, residuals, rates and forces of the last ticks. Out: what has to be added to the
//! forecast `j` ticks ahead, for each of [`KNOTS`]. State: the weights of each knot, one covariance, the forecasts that wait for their
//! residual.
//!
//! The adapter of the paper learns from the error of now, and adds the same correction to every later tick. How wrong a forecast is
//! 200 ms ahead depends on how the vehicle moves, so each knot has a linear map of its own, from the inputs of an autoregression
//! ([`super::arx`]) and from the forecast itself. It starts at zero: before it has learned, the forecast is the network's.
//!
//! A correction is used only in the share that would have been best over the last seconds, per knot and coordinate. A map that has
//! learned little, or another motion, therefore does no harm.
//!
//! Old errors are forgotten only where new ones come in. Forgetting alone would let the covariance grow in every direction in which
//! nothing moves, so each tick puts back, for one input in turn, as much knowledge of the prior "no correction" as forgetting takes
//! away. Where nothing moves the weights leak to zero, and the covariance stays below its prior.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

use super::History;
use super::arx::{INPUTS as OF_HISTORY, inputs_of};
use super::knots::{KNOTS, between};
use crate::elementary::exp;
use crate::notation::{Coords, KnownCoords, N};
use crate::tick::Forecast;

/// Number of inputs: those of the autoregression, and the forecast at each knot.
const INPUTS: usize = OF_HISTORY + N * KNOTS.len();

/// Variance of a weight before anything is learned, relative to that of an error; all values are divided by their scales. Between 3 and
/// 30 the errors beyond `j = 0` change by 3 %, and that of `j = 0` falls by a tenth.
const PRIOR: f64 = 30.0;

/// Weight of an earlier error, relative to one of this tick, in the share of a correction that is used: a memory of 2 s.
const SHARE_FORGETTING: f64 = 0.995;

/// Number of ticks that a correction is on trial before it is used: the memory of the share. At the start of a flight filters settle, and
/// what is learned from that holds for nothing later.
const TRIAL: u32 = 200;

/// Sum of squared corrections at each knot, in units of the scale, below which a correction is doubted: it was too small for its worth to
/// be known. Later forecasts err more, and so do their corrections. With less doubt the first seconds of a path track worse.
const DOUBTS: [f64; KNOTS.len()] = [0.003, 0.03, 0.1, 0.1, 0.1, 0.1];

/// A forecast that waits for its residuals.
#[derive(Clone, Debug)]
struct Made {
    /// `[INPUTS]`.
    inputs: DVector<f64>,
    /// `[INPUTS]`, the gain by which its errors change the weights.
    gain: DVector<f64>,
    /// The forecast at each knot before the correction, in units of the scale.
    uncorrected: [Coords; KNOTS.len()],
    /// The whole correction of each knot, in units of the scale.
    correction: [Coords; KNOTS.len()],
}

/// The prior of one input as the covariance got it back.
struct PutBack {
    /// The input.
    turn: usize,
    /// `[INPUTS]`: the weights lose this times the weight of the input.
    step: DVector<f64>,
}

/// Which share of the correction of one knot would have been best so far, per coordinate: least squares with forgetting.
#[derive(Clone, Debug)]
struct Share {
    /// Sum of the products of error and correction.
    product: Coords,
    /// Sum of the squares of the correction.
    square: Coords,
    /// What that sum has at least.
    doubt: f64,
    /// Number of lessons so far, up to [`TRIAL`].
    lessons: u32,
}

impl Share {
    fn new(doubt: f64) -> Self {
        Self { product: Coords::zeros(), square: Coords::repeat(doubt), doubt, lessons: 0 }
    }

    fn learn(&mut self, error: &Coords, correction: &Coords) {
        self.lessons = TRIAL.min(self.lessons + 1);
        let doubt = Coords::repeat(self.doubt * (1.0 - SHARE_FORGETTING));
        self.product = self.product * SHARE_FORGETTING + error.component_mul(correction);
        self.square = self.square * SHARE_FORGETTING + correction.component_mul(correction) + doubt;
    }

    fn share(&self) -> Coords {
        if self.lessons < TRIAL {
            return Coords::zeros();
        }
        self.product.component_div(&self.square).map(|share| share.clamp(0.0, 1.0))
    }
}

/// The state of the correction.
#[derive(Clone, Debug)]
pub struct HorizonAdapter {
    /// Unit of residuals and forces, N and N m.
    scale: Coords,
    /// Weights of each knot, `[INPUTS, N]`.
    weights: Vec<DMatrix<f64>>,
    /// `[INPUTS, INPUTS]`.
    covariance: DMatrix<f64>,
    /// Share of each knot.
    shares: Vec<Share>,
    /// Newest first.
    made: VecDeque<Made>,
    /// The input whose prior is put back at the next tick.
    turn: usize,
}

impl HorizonAdapter {
    /// A correction that has learned nothing, for residuals of size `scale`, N and N m.
    pub fn new(scale: Coords) -> Self {
        Self {
            scale,
            weights: vec![DMatrix::zeros(INPUTS, N); KNOTS.len()],
            covariance: DMatrix::identity(INPUTS, INPUTS) * PRIOR,
            shares: DOUBTS.map(Share::new).to_vec(),
            made: VecDeque::with_capacity(KNOTS[KNOTS.len() - 1] + 1),
            turn: 0,
        }
    }

    /// What has to be added to `forecast` + `correction` at each of [`KNOTS`], N and N m, said before the residual of this tick is used;
    /// then learns that residual. While `learning` is false it learns nothing, and drops the forecasts that wait. Empty if an input is
    /// not finite. `forgetting` weighs an error of the previous tick relative to one of this tick.
    pub fn step(
        &mut self,
        forecast: &Forecast,
        correction: &Coords,
        history: &History,
        residual: &KnownCoords,
        forgetting: f64,
        learning: bool,
    ) -> Vec<Coords> {
        let uncorrected = self.at_knots(forecast, correction);
        let mut inputs = DVector::zeros(INPUTS);
        inputs.rows_mut(0, OF_HISTORY).copy_from(&inputs_of(history, &self.scale));
        for (knot, value) in uncorrected.iter().enumerate() {
            inputs.rows_mut(OF_HISTORY + knot * N, N).copy_from(value);
        }
        if !inputs.iter().all(|value| value.is_finite()) {
            self.made.clear();
            return Vec::new();
        }
        let correction: [Coords; KNOTS.len()] =
            std::array::from_fn(|knot| answer(&self.weights[knot], &inputs));
        let said = correction
            .iter()
            .zip(&self.shares)
            .map(|(z, share)| z.component_mul(&share.share()).component_mul(&self.scale))
            .collect();
        if learning {
            let (gain, back) = self.gain(&inputs, forgetting);
            self.made.push_front(Made { inputs, gain, uncorrected, correction });
            self.made.truncate(KNOTS[KNOTS.len() - 1] + 1);
            self.learn(residual);
            self.leak(&back);
        } else {
            self.made.clear();
        }
        said
    }

    /// The forecast with the adapter's correction at each knot, in units of the scale; beyond the horizon its last step.
    fn at_knots(&self, forecast: &Forecast, correction: &Coords) -> [Coords; KNOTS.len()] {
        let last = forecast.base.len().saturating_sub(1);
        KNOTS.map(|knot| {
            let base = forecast.base.get(knot.min(last)).map_or_else(Coords::zeros, |base| **base);
            (base + correction).component_div(&self.scale)
        })
    }

    /// Each knot learns from the forecast that it made for this tick.
    fn learn(&mut self, residual: &KnownCoords) {
        let z = residual.component_div(&self.scale);
        // An error of zero teaches nothing.
        let known =
            |error: Coords| KnownCoords::from(error).only(residual.known()).or(&Coords::zeros());
        for (index, (weights, knot)) in self.weights.iter_mut().zip(KNOTS).enumerate() {
            let Some(made) = self.made.get(knot) else { continue };
            let left = z - made.uncorrected[index];
            let (left, error) = (known(left), known(left - answer(weights, &made.inputs)));
            if left.iter().chain(error.iter()).all(|value| value.is_finite()) {
                self.shares[index].learn(&left, &made.correction[index]);
                weights.ger(1.0, &made.gain, &error, 1.0);
            }
        }
    }

    /// The gain for `inputs`; updates the covariance, and puts back the prior of one input.
    fn gain(&mut self, inputs: &DVector<f64>, forgetting: f64) -> (DVector<f64>, PutBack) {
        let p = &mut self.covariance;
        let p_inputs = &*p * inputs;
        let learned = 1.0 / (forgetting + inputs.dot(&p_inputs));
        let gain = &p_inputs * learned;
        // The column of the input in turn, as the first of both updates leaves it.
        let turn = self.turn;
        let kept = forgetting.recip();
        let column = (p.column(turn) - &p_inputs * (learned * p_inputs[turn])) * kept;
        let knowledge = (1.0 - forgetting) * INPUTS as f64 / PRIOR;
        let put_back = knowledge / (1.0 + knowledge * column[turn]);
        // Both factors of a product are entries of one vector, so the matrix stays symmetric to the last bit.
        for j in 0..INPUTS {
            let (p_j, column_j) = (p_inputs[j], column[j]);
            let factors = p_inputs.iter().zip(column.iter());
            for (entry, (p_i, column_i)) in p.column_mut(j).iter_mut().zip(factors) {
                *entry = (*entry - learned * (p_i * p_j)) * kept - put_back * (column_i * column_j);
            }
        }
        self.turn = (turn + 1) % INPUTS;
        (gain, PutBack { turn, step: column * put_back })
    }

    /// Moves the weights towards the prior of the input that was put back.
    fn leak(&mut self, back: &PutBack) {
        for weights in &mut self.weights {
            let row = weights.row(back.turn).transpose();
            weights.ger(-1.0, &back.step, &row, 1.0);
        }
    }
}

/// `W' inputs`.
fn answer(weights: &DMatrix<f64>, inputs: &DVector<f64>) -> Coords {
    Coords::from_iterator(weights.tr_mul(inputs).iter().copied())
}

/// The forgetting factor of one step of `dt_s` for a memory of `memory_s`, s.
pub fn forgetting(memory_s: f64, dt_s: f64) -> f64 {
    exp(-dt_s / memory_s)
}

/// The correction `step` ticks ahead on the line between those at the knots; zero without a correction.
pub fn at_step(corrections: &[Coords], step: usize) -> Coords {
    if corrections.len() == KNOTS.len() { between(corrections, step) } else { Coords::zeros() }
}

#[cfg(test)]
#[path = "horizon_tests.rs"]
mod tests;
