//! Gaussian process on a subset of the data: ARD-RBF kernel, one Cholesky factor for all outputs.
//!
//! Source: Torrente, Kaufmann, Foehn and Scaramuzza, "Data-driven MPC for quadrotors", IEEE RA-L 6(2), 2021 (the paper's line "GP");
//! training as in Rasmussen and Williams, "Gaussian processes for machine learning", 2006, eq. 2.25, 5.8 and 5.9.
//!
//! In: z-scored coordinates, rates and previous force of the newest tick. Out: residual for `j = 0..=k`, the posterior mean. State:
//! the subset and its weights.

use nalgebra::{DMatrix, DVector};

use super::{Standard, TARGETS};
use crate::elementary::{exp, ln, powi, squared};
use crate::notation::N;
use crate::residual::weights::{Weights, WeightsError};
use crate::residual::{History, Predictor, PredictorInfo};
use crate::tick::Forecast;

/// Name of the model in the head of its file.
pub const NAME: &str = "gp";

/// Names of the tensors, with shapes `[samples, inputs]`, `[samples, targets]`, `[inputs]` and `[1]`.
const TENSORS: [&str; 4] = ["inputs", "alpha", "length_scale", "signal_variance"];

/// Number of Adam steps on the logarithms of the hyperparameters, and their rate: the likelihood changes by less than 1 % over
/// the last ten.
const STEPS: i32 = 40;
const RATE: f64 = 0.1;

/// Lower bound of the noise variance, so that the Cholesky factor exists.
const LEAST_NOISE: f64 = 1e-4;

/// Hyperparameters as logarithms: a length scale per input, the signal variance, the noise variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    /// Logarithm of the length scale of each input, in standard deviations of the input.
    pub log_length: Vec<f64>,
    /// Logarithm of the signal variance.
    pub log_signal: f64,
    /// Logarithm of the noise variance.
    pub log_noise: f64,
}

impl Kernel {
    /// Initial hyperparameters: lengths that leave random samples barely correlated, and a tenth of noise.
    pub fn start(inputs: usize) -> Self {
        let log_length = vec![ln((inputs as f64).sqrt()); inputs];
        Self { log_length, log_signal: 0.0, log_noise: ln(0.1_f64) }
    }

    fn weights(&self) -> Vec<f64> {
        self.log_length.iter().map(|l| exp(-2.0 * l)).collect()
    }

    /// Covariance matrix of the signal between the samples `x`, `[samples, samples]`.
    fn signal(&self, x: &[Vec<f64>]) -> DMatrix<f64> {
        let (w, signal) = (self.weights(), exp(self.log_signal));
        DMatrix::from_fn(x.len(), x.len(), |i, j| signal * rbf(&x[i], &x[j], &w))
    }

    fn noise(&self) -> f64 {
        exp(self.log_noise).max(LEAST_NOISE)
    }

    /// Log marginal likelihood of the columns of `y` without its constant, and its gradient with respect to the logarithms of
    /// lengths, signal and noise; `None` if the covariance has no Cholesky factor.
    pub fn likelihood(&self, x: &[Vec<f64>], y: &DMatrix<f64>) -> Option<(f64, Vec<f64>)> {
        let n = x.len();
        let signal = self.signal(x);
        let factor = (&signal + DMatrix::identity(n, n) * self.noise()).cholesky()?;
        let alpha = factor.solve(y);
        let outputs = y.ncols() as f64;
        let log_det = 2.0 * factor.l_dirty().diagonal().iter().map(|d| ln(*d)).sum::<f64>();
        let value = -0.5 * y.dot(&alpha) - 0.5 * outputs * log_det;
        // ½ tr((α α' - K⁻¹) dK)
        let a = &alpha * alpha.transpose() - factor.inverse() * outputs;
        let w = self.weights();
        let mut gradient = vec![0.0; self.log_length.len() + 2];
        let (lengths, rest) = gradient.split_at_mut(self.log_length.len());
        for i in 0..n {
            for j in 0..i {
                let pair = a[(i, j)] * signal[(i, j)];
                for (d, slope) in lengths.iter_mut().enumerate() {
                    *slope += pair * w[d] * squared(x[i][d] - x[j][d]);
                }
            }
        }
        rest[0] = 0.5 * a.dot(&signal);
        rest[1] = 0.5 * a.trace() * self.noise();
        Some((value, gradient))
    }

    /// Maximises the likelihood by Adam.
    #[must_use]
    pub fn train(mut self, x: &[Vec<f64>], y: &DMatrix<f64>) -> Self {
        let size = self.log_length.len() + 2;
        let (mut first, mut second) = (vec![0.0; size], vec![0.0; size]);
        for step in 1..=STEPS {
            let Some((_, gradient)) = self.likelihood(x, y) else { break };
            for (i, slope) in gradient.iter().enumerate() {
                first[i] = 0.9 * first[i] + 0.1 * slope;
                second[i] = 0.999 * second[i] + 0.001 * slope * slope;
                let mean = first[i] / (1.0 - powi(0.9_f64, step));
                let size = (second[i] / (1.0 - powi(0.999_f64, step))).sqrt();
                *self.value(i) += RATE * mean / (size + 1e-12);
            }
            self.log_noise = self.log_noise.max(ln(LEAST_NOISE));
        }
        self
    }

    fn value(&mut self, i: usize) -> &mut f64 {
        let lengths = self.log_length.len();
        match i.checked_sub(lengths) {
            None => &mut self.log_length[i],
            Some(0) => &mut self.log_signal,
            Some(_) => &mut self.log_noise,
        }
    }
}

fn rbf(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    let square: f64 = a.iter().zip(b).zip(weights).map(|((a, b), w)| w * (a - b) * (a - b)).sum();
    exp(-0.5 * square)
}

/// A fitted process: the kernel, the subset and `K⁻¹ y`.
#[derive(Clone, Debug)]
pub struct Fit {
    kernel: Kernel,
    x: Vec<Vec<f64>>,
    alpha: DMatrix<f64>,
}

/// Fits `y` (`[samples][targets]`, z-scored) on the subset `x` (`[samples][inputs]`, z-scored). Lengths and variances come from
/// the first `few` samples and the first eight targets; `None` if the covariance has no Cholesky factor.
pub fn fit(x: &[Vec<f64>], y: &[Vec<f64>], few: usize) -> Option<Fit> {
    let inputs = x.first()?.len();
    let matrix = |n: usize, targets: usize| DMatrix::from_fn(n, targets, |i, j| y[i][j]);
    let few = few.min(x.len());
    let kernel = Kernel::start(inputs).train(&x[..few], &matrix(few, N));
    let n = x.len();
    let k = kernel.signal(x) + DMatrix::identity(n, n) * kernel.noise();
    let alpha = k.cholesky()?.solve(&matrix(n, y.first()?.len()));
    Some(Fit { kernel, x: x.to_vec(), alpha })
}

impl Fit {
    /// Names, shapes and values of the tensors.
    pub fn tensors(&self) -> Vec<(String, Vec<usize>, Vec<f32>)> {
        let (n, inputs) = (self.x.len(), self.kernel.log_length.len());
        let narrow = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v as f32).collect();
        let [x, alpha, length, signal] = TENSORS.map(str::to_owned);
        vec![
            (x, vec![n, inputs], narrow(&mut self.x.iter().flatten().copied())),
            (
                alpha,
                vec![n, self.alpha.ncols()],
                narrow(&mut self.alpha.transpose().iter().copied()),
            ),
            (length, vec![inputs], narrow(&mut self.kernel.log_length.iter().map(|l| exp(*l)))),
            (signal, vec![1], vec![exp(self.kernel.log_signal) as f32]),
        ]
    }
}

/// The Gaussian process as a predictor.
#[derive(Clone)]
pub struct Gp {
    standard: Standard,
    x: Vec<Vec<f64>>,
    /// `K⁻¹ y` transposed, `[targets, samples]`.
    alpha: DMatrix<f64>,
    weights: Vec<f64>,
    signal: f64,
}

impl Gp {
    /// Builds the predictor from `weights`.
    ///
    /// # Errors
    /// [`WeightsError`] if the weights belong to another model or vehicle.
    pub fn new(weights: &Weights) -> Result<Self, WeightsError> {
        weights.head.check_model(NAME)?;
        let standard = Standard::new(&weights.head)?;
        let inputs = standard.len();
        let samples = weights.tensors.get(TENSORS[0]).map_or(0, |tensor| tensor.shape[0]);
        let shapes = [vec![samples, inputs], vec![samples, TARGETS], vec![inputs], vec![1]];
        let expected: Vec<(String, Vec<usize>)> =
            TENSORS.map(str::to_owned).into_iter().zip(shapes).collect();
        weights.check_tensors(&expected)?;
        let [x, alpha, length, signal] = TENSORS.map(|name| weights.values(name));
        Ok(Self {
            x: x.chunks_exact(inputs.max(1))
                .map(|row| row.iter().map(|v| f64::from(*v)).collect())
                .collect(),
            alpha: DMatrix::from_fn(TARGETS, samples, |target, sample| {
                f64::from(alpha[sample * TARGETS + target])
            }),
            weights: length.iter().map(|l| powi(f64::from(*l), -2)).collect(),
            signal: f64::from(signal[0]),
            standard,
        })
    }

    /// Number of fitted numbers: subset, weights and kernel.
    pub fn parameters(&self) -> usize {
        self.x.len() * (self.standard.len() + TARGETS) + self.weights.len() + 2
    }
}

impl Predictor for Gp {
    fn regime_len(&self) -> usize {
        0
    }

    fn info(&self) -> PredictorInfo {
        PredictorInfo { scale: self.standard.std, ..PredictorInfo::default() }
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let z = self.standard.newest(history);
        let k = DVector::from_iterator(
            self.x.len(),
            self.x.iter().map(|x| self.signal * rbf(&z, x, &self.weights)),
        );
        let targets = &self.alpha * k;
        self.standard.forecast(targets.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::{cos, sin};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    fn samples(n: usize, seed: u64) -> (Vec<Vec<f64>>, DMatrix<f64>) {
        let mut rng = Pcg64::seed_from_u64(seed);
        let x: Vec<Vec<f64>> =
            (0..n).map(|_| (0..3).map(|_| 4.0 * rng.random::<f64>() - 2.0).collect()).collect();
        // Two outputs depend strongly on the first input, weakly on the second, and not on the third.
        let y = DMatrix::from_fn(n, 2, |i, j| {
            if j == 0 { sin(2.0 * x[i][0]) } else { cos(2.0 * x[i][0]) + 0.3 * x[i][1] }
        });
        (x, y)
    }

    #[test]
    fn the_gradient_of_the_likelihood_is_that_of_finite_differences() {
        let (x, y) = samples(30, 1);
        let kernel = Kernel { log_noise: ln(0.05_f64), ..Kernel::start(3) };
        let (_, gradient) = kernel.likelihood(&x, &y).unwrap();
        for (i, slope) in gradient.iter().enumerate() {
            let h = 1e-5;
            let at = |step: f64| {
                let mut moved = kernel.clone();
                *moved.value(i) += step;
                moved.likelihood(&x, &y).unwrap().0
            };
            let found = (at(h) - at(-h)) / (2.0 * h);
            // Central differences of a function of size 100 have an error of h² and 1e-14/h.
            assert!((found - slope).abs() < 1e-5 * (1.0 + slope.abs()), "{i}: {found} {slope}");
        }
    }

    #[test]
    fn training_finds_which_inputs_matter_and_predicts_what_it_has_not_seen() {
        let (x, y) = samples(120, 2);
        let kernel = Kernel::start(3).train(&x, &y);
        let length: Vec<f64> = kernel.log_length.iter().map(|l| exp(*l)).collect();
        assert!(length[0] < length[1] && length[1] < length[2] && length[2] > 4.0, "{length:?}");
        let k = kernel.signal(&x) + DMatrix::identity(120, 120) * kernel.noise();
        let alpha = k.cholesky().unwrap().solve(&y);
        let (fresh, truth) = samples(50, 3);
        let w = kernel.weights();
        for (i, z) in fresh.iter().enumerate() {
            let kz = DVector::from_iterator(
                120,
                x.iter().map(|x| exp(kernel.log_signal) * rbf(z, x, &w)),
            );
            let found = alpha.tr_mul(&kz);
            // 120 samples of two smooth functions: the posterior's standard deviation is below 0.1.
            assert!((found - truth.row(i).transpose()).norm() < 0.3, "sample {i}");
        }
    }
}
