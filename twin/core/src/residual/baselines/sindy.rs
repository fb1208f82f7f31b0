//! Sparse identification of the residual: a quadratic library, sequentially thresholded least squares.
//!
//! Source: Brunton, Proctor and Kutz, "Discovering governing equations from data by sparse identification of nonlinear dynamical
//! systems", PNAS 113(15), 2016; for control Kaiser, Kutz and Brunton, Proc. R. Soc. A 474, 2018 (the paper's line "`SysID`").
//!
//! In: z-scored coordinates, rates and previous force of the newest tick. Out: residual for `j = 0..=k`. State: the coefficients.

use nalgebra::{DMatrix, DVector};

use super::{Standard, TARGETS};
use crate::residual::weights::{Weights, WeightsError};
use crate::residual::{History, Predictor, PredictorInfo};
use crate::tick::Forecast;

/// Name of the model in the head of its file.
pub const NAME: &str = "sindy";

/// Coefficients below this threshold are dropped, in standard deviations of the residual per unit of the term.
pub const THRESHOLD: f64 = 0.02;

/// Weight of the squared coefficients relative to the mean squared error; it keeps collinear terms solvable.
const RIDGE: f64 = 1e-6;

/// Largest number of rounds of thresholding; it ends earlier if a round drops no term.
const ROUNDS: usize = 10;

/// Number of samples whose library is computed at a time.
const CHUNK: usize = 1000;

/// Name of the tensor, whose shape is `[terms, targets]`.
const TENSOR: &str = "coefficients";

/// The sparse model as a predictor.
#[derive(Clone)]
pub struct Sindy {
    standard: Standard,
    /// Coefficients, `[targets, terms]`.
    coefficients: DMatrix<f64>,
}

/// Number of terms of a quadratic library over `n` inputs.
pub fn terms(n: usize) -> usize {
    1 + n + n * (n + 1) / 2
}

/// The quadratic library `[1, z_i, z_i z_j (i ≤ j)]` of the inputs `z`.
pub fn library(z: &[f64]) -> Vec<f64> {
    let mut all = Vec::with_capacity(terms(z.len()));
    all.push(1.0);
    all.extend_from_slice(z);
    for (i, a) in z.iter().enumerate() {
        all.extend(z[i..].iter().map(|b| a * b));
    }
    all
}

/// Sparse coefficients `[terms, targets]` of `y ≈ library(x) c`. Least squares by the normal equations is repeated with the terms
/// whose coefficient reaches `threshold`.
pub fn fit(x: &[Vec<f64>], y: &[Vec<f64>], threshold: f64) -> DMatrix<f64> {
    let m = x.first().map_or(1, |x| terms(x.len()));
    let targets = y.first().map_or(0, Vec::len);
    let (mut gram, mut moment) = (DMatrix::zeros(m, m), DMatrix::zeros(m, targets));
    for (x, y) in x.chunks(CHUNK).zip(y.chunks(CHUNK)) {
        let rows: Vec<Vec<f64>> = x.iter().map(|z| library(z)).collect();
        let theta = DMatrix::from_fn(m, rows.len(), |term, sample| rows[sample][term]);
        let y = DMatrix::from_fn(y.len(), targets, |sample, target| y[sample][target]);
        gram += &theta * theta.transpose();
        moment += theta * y;
    }
    let n = x.len().max(1) as f64;
    gram = gram / n + DMatrix::identity(m, m) * RIDGE;
    moment /= n;
    let mut all = DMatrix::zeros(m, targets);
    for target in 0..targets {
        all.set_column(target, &thresholded(&gram, &moment.column(target).into_owned(), threshold));
    }
    all
}

fn thresholded(gram: &DMatrix<f64>, moment: &DVector<f64>, threshold: f64) -> DVector<f64> {
    let mut active: Vec<usize> = (0..moment.len()).collect();
    let mut out = DVector::zeros(moment.len());
    for _ in 0..ROUNDS {
        let a = gram.select_rows(&active).select_columns(&active);
        let b = moment.select_rows(&active);
        let Some(c) = a.cholesky().map(|factor| factor.solve(&b)) else { break };
        out.fill(0.0);
        for (index, term) in active.iter().enumerate() {
            out[*term] = c[index];
        }
        let kept: Vec<usize> =
            active.iter().copied().filter(|term| out[*term].abs() >= threshold).collect();
        if kept.len() == active.len() || kept.is_empty() {
            break;
        }
        active = kept;
    }
    out.apply(|c| *c = if c.abs() >= threshold { *c } else { 0.0 });
    out
}

impl Sindy {
    /// Builds the predictor from `weights`.
    ///
    /// # Errors
    /// [`WeightsError`] if the weights belong to another model or vehicle.
    pub fn new(weights: &Weights) -> Result<Self, WeightsError> {
        weights.head.check_model(NAME)?;
        let standard = Standard::new(&weights.head)?;
        let m = terms(standard.len());
        weights.check_tensors(&[(TENSOR.to_owned(), vec![m, TARGETS])])?;
        let values = weights.values(TENSOR);
        let coefficients =
            DMatrix::from_fn(TARGETS, m, |target, term| f64::from(values[term * TARGETS + target]));
        Ok(Self { standard, coefficients })
    }

    /// Name, shape and values of the tensor of `coefficients`.
    pub fn tensors(coefficients: &DMatrix<f64>) -> (String, Vec<usize>, Vec<f32>) {
        let (m, targets) = coefficients.shape();
        let values = coefficients.transpose().iter().map(|c| *c as f32).collect();
        (TENSOR.to_owned(), vec![m, targets], values)
    }

    /// Number of coefficients that are not zero.
    pub fn parameters(&self) -> usize {
        self.coefficients.iter().filter(|c| **c != 0.0).count()
    }
}

impl Predictor for Sindy {
    fn regime_len(&self) -> usize {
        0
    }

    fn info(&self) -> PredictorInfo {
        PredictorInfo { scale: self.standard.std, ..PredictorInfo::default() }
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let theta = DVector::from_vec(library(&self.standard.newest(history)));
        let targets = &self.coefficients * theta;
        self.standard.forecast(targets.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    #[test]
    fn the_terms_of_a_sparse_law_are_found_and_no_other() {
        let mut rng = Pcg64::seed_from_u64(1);
        let x: Vec<Vec<f64>> =
            (0..3000).map(|_| (0..4).map(|_| 2.0 * rng.random::<f64>() - 1.0).collect()).collect();
        // y0 = 0.5 + 2 z1 - 0.7 z0 z3, y1 = 1.5 z2², with 1 % noise.
        let mut noise = || 0.02 * (rng.random::<f64>() - 0.5);
        let y: Vec<Vec<f64>> = x
            .iter()
            .map(|z| {
                vec![0.5 + 2.0 * z[1] - 0.7 * z[0] * z[3] + noise(), 1.5 * z[2] * z[2] + noise()]
            })
            .collect();
        let c = fit(&x, &y, 0.05);
        let term = |i: usize, j: usize| {
            let unit = |k: usize| (0..4).map(|n| f64::from(u8::from(n == k))).collect::<Vec<_>>();
            let both: Vec<f64> = unit(i).iter().zip(unit(j)).map(|(a, b)| a + b).collect();
            // The product that needs both inputs.
            (5..terms(4)).find(|t| {
                let only = |z: &[f64]| library(z)[*t];
                only(&both) != 0.0 && (i == j || (only(&unit(i)) == 0.0 && only(&unit(j)) == 0.0))
            })
        };
        let wanted = [
            (0, 0, 0.5),
            (2, 0, 2.0),
            (term(0, 3).unwrap(), 0, -0.7),
            (term(2, 2).unwrap(), 1, 1.5),
        ];
        for (term, target, value) in wanted {
            // 3000 samples with a noise of 0.006 give an error of 5 σ/√n = 0.001.
            assert!((c[(term, target)] - value).abs() < 1e-3, "{term} {target}");
        }
        assert_eq!(c.iter().filter(|c| **c != 0.0).count(), wanted.len(), "{c}");
    }
}
