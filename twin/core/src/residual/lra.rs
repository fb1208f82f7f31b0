//! Latent Residual Adapter: Recursive Least Squares on the regime latent with forgetting, trace cap and covariance reset.
//!
//! In: base forecast `r_hat_base`, regime `g'`, measured residual `r`. Out: [`Adapted`]. State: `W` (`d_k` × n), `Sigma`
//! (`d_k` × `d_k`), the moving average of the innovation, ticks since the last reset.

use nalgebra::{Const, DMatrix, DVector, Dyn, OMatrix};
use serde::{Deserialize, Serialize};

use crate::notation::{Coords, KnownCoords, N};
use crate::tick::{Adapted, Forecast};

/// Settings of the adapter, which an operator may change in flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The adapter corrects the base forecast; if false, the base forecast is used alone.
    pub enabled: bool,
    /// Forgetting factor `lambda` in (0, 1].
    pub forgetting: f64,
    /// `sigma_0`: the covariance is `sigma_0 I` at the start and after a reset.
    pub reset_scale: f64,
    /// The covariance may be reset; if false, only forgetting keeps the covariance large.
    #[serde(default = "on")]
    pub reset_enabled: bool,
    /// `delta_thresh`, compared with the norm of the mean innovation.
    pub reset_threshold: f64,
    /// `alpha`, weight of the old value in the mean innovation.
    pub innovation_smoothing: f64,
    /// Shortest time between two resets, s.
    pub refractory_s: f64,
    /// The trace of the covariance is capped at this value times `d_k`; infinite switches the cap off.
    pub trace_cap_per_feature: f64,
}

/// Default of `reset_enabled` for recordings that were made before this switch existed: they could reset.
fn on() -> bool {
    true
}

impl Default for Settings {
    /// The paper's values (implementation details) with the trace cap of 10 `d_k` and 1 s refractory time.
    fn default() -> Self {
        Self {
            enabled: true,
            forgetting: 0.99,
            reset_scale: 1.0,
            reset_enabled: true,
            reset_threshold: 3.2,
            innovation_smoothing: 0.9,
            refractory_s: 1.0,
            trace_cap_per_feature: 10.0,
        }
    }
}

/// `W`, `d_k` × n.
pub type Weights = OMatrix<f64, Dyn, Const<N>>;

/// The adapter's state.
#[derive(Clone, Debug)]
pub struct Adapter {
    scale: Coords,
    weights: Weights,
    covariance: DMatrix<f64>,
    innovation_mean: Coords,
    ticks_since_reset: u64,
}

impl Adapter {
    /// An adapter over `d_k` features. `scale` is the unit of its innovation per coordinate (z-score: the standard deviation of the
    /// residual; physical units: ones).
    pub fn new(d_k: usize, scale: Coords, settings: &Settings) -> Self {
        Self {
            scale,
            weights: Weights::zeros(d_k),
            covariance: DMatrix::identity(d_k, d_k) * settings.reset_scale,
            innovation_mean: Coords::zeros(),
            ticks_since_reset: u64::MAX / 2,
        }
    }

    /// `W`, `d_k` × n, in units of the scale.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// `Sigma`, `d_k` × `d_k`.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// Eigenvalues of `Sigma`, largest first; empty if they cannot be found.
    pub fn spectrum(&self) -> Vec<f64> {
        // Bound on the iterations: the decomposition must end for every matrix.
        const MOST_STEPS: usize = 10_000;
        let found =
            nalgebra::SymmetricEigen::try_new(self.covariance.clone(), f64::EPSILON, MOST_STEPS);
        let mut values = found.map_or_else(Vec::new, |e| e.eigenvalues.iter().copied().collect());
        values.sort_by(|a: &f64, b| b.total_cmp(a));
        values
    }

    /// Makes the smallest change of the weights after which the estimate for `forecast` equals `known` (N and N m). The adapter need not
    /// learn a known jump, such as the release of a payload, from its error. A coordinate without a known forecast is not changed.
    pub fn move_to(&mut self, forecast: &Forecast, known: &Coords) {
        let g = DVector::from_column_slice(&forecast.regime);
        let power = g.norm_squared();
        let base = forecast.base.first().copied().unwrap_or_else(|| Coords::zeros().into());
        let step = (known - *base).component_div(&self.scale) - self.correction(&g);
        let step = KnownCoords::from(step).only(base.known()).or(&Coords::zeros());
        if g.len() == self.weights.nrows()
            && power > 0.0
            && power.is_finite()
            && step.iter().all(|v| v.is_finite())
        {
            self.weights += &g * (step / power).transpose();
        }
    }

    /// One step of Algorithm 1, lines 5 to 8. With `frozen` it estimates but does not learn. A non-finite input leaves the state unchanged.
    /// In a coordinate whose residual is unknown it learns nothing, and the estimate is unknown.
    pub fn step(
        &mut self,
        forecast: &Forecast,
        residual: &KnownCoords,
        dt_s: f64,
        frozen: bool,
        settings: &Settings,
    ) -> Adapted {
        let base = forecast.base.first().map_or_else(Coords::zeros, |base| **base);
        let g = DVector::from_column_slice(&forecast.regime);
        let correction = self.correction(&g);
        let r_hat_prior = base + correction.component_mul(&self.scale);
        // lip: innovation with the weights of the previous tick
        let innovation = (**residual - r_hat_prior).component_div(&self.scale);
        let known = residual.known();
        let said = |values: Coords| KnownCoords::from(values).only(known);
        // An innovation of zero moves no weight.
        let lesson = said(innovation).or(&Coords::zeros());
        let usable = settings.enabled
            && !frozen
            && g.len() == self.weights.nrows()
            && !g.is_empty()
            && residual.is_any_known()
            && lesson.iter().chain(g.iter()).all(|v| v.is_finite());
        let mut gain_norm = 0.0;
        let mut reset = false;
        if usable {
            gain_norm = self.rls(&g, &lesson, settings);
            reset = self.detect_reset(&lesson, dt_s, settings);
        }
        let r_hat = if settings.enabled {
            base + self.correction(&g).component_mul(&self.scale)
        } else {
            base
        };
        let diagonal = self.covariance.diagonal();
        Adapted {
            r_hat: said(r_hat), // r_adapt
            r_hat_prior: said(if settings.enabled { r_hat_prior } else { base }),
            innovation: said(innovation),
            innovation_mean_norm: self.innovation_mean.norm(),
            covariance_trace: diagonal.sum(),
            covariance_max: diagonal.iter().copied().fold(0.0, f64::max),
            covariance_min: diagonal.iter().copied().fold(f64::MAX, f64::min).min(diagonal.sum()),
            gain_norm,
            weight_norm: self.weights.norm(),
            reset,
            frozen: frozen || !settings.enabled,
        }
    }

    fn correction(&self, g: &DVector<f64>) -> Coords {
        if g.len() != self.weights.nrows() || g.is_empty() {
            return Coords::zeros();
        }
        self.weights.tr_mul(g)
    }

    /// Computes the whole new state, checks it, then assigns it. Returns the norm of `K`.
    fn rls(&mut self, g: &DVector<f64>, innovation: &Coords, settings: &Settings) -> f64 {
        let lambda = settings.forgetting;
        let p_g = &self.covariance * g;
        let k = &p_g / (lambda + g.dot(&p_g)); // eq:rls_gain
        let w = &self.weights + &k * innovation.transpose(); // eq:rls_weight
        let mut p = (&self.covariance - &k * p_g.transpose()) / lambda; // eq:rls_cov
        p = (&p + p.transpose()) * 0.5;
        let cap = settings.trace_cap_per_feature * g.len() as f64;
        let trace = p.trace();
        if trace > cap {
            p *= cap / trace;
        }
        let norm = k.norm();
        if norm.is_finite() && w.iter().chain(p.iter()).all(|v| v.is_finite()) {
            self.weights = w;
            self.covariance = p;
        }
        norm
    }

    /// Covariance reset with refractory time (sec. reset). True if it fired.
    fn detect_reset(&mut self, innovation: &Coords, dt_s: f64, settings: &Settings) -> bool {
        let alpha = settings.innovation_smoothing;
        self.innovation_mean = self.innovation_mean * alpha + innovation * (1.0 - alpha);
        self.ticks_since_reset += 1;
        let refractory_over = self.ticks_since_reset as f64 * dt_s > settings.refractory_s;
        let fires = settings.reset_enabled
            && self.innovation_mean.norm() > settings.reset_threshold
            && refractory_over;
        if fires {
            let d_k = self.covariance.nrows();
            self.covariance = DMatrix::identity(d_k, d_k) * settings.reset_scale;
            self.ticks_since_reset = 0;
        }
        fires
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::powi;
    use proptest::prelude::*;

    /// RLS and the normal equations differ by rounding amplified by the conditioning of 4 random features.
    const BATCH_TOLERANCE: f64 = 1e-6;

    fn forecast(g: &[f64]) -> Forecast {
        Forecast { base: vec![Coords::zeros().into()], regime: g.to_vec(), attention: Vec::new() }
    }

    #[test]
    fn the_spectrum_of_a_known_covariance_is_known_and_ordered() {
        // Householder reflection H = I - 2 v v' / v'v of diag(5, 2, 0.5): eigenvalues stay.
        let v = DVector::from_column_slice(&[1.0, -2.0, 0.5]);
        let h = DMatrix::identity(3, 3) - &v * v.transpose() * (2.0 / v.norm_squared());
        let d = DMatrix::from_diagonal(&DVector::from_column_slice(&[0.5, 5.0, 2.0]));
        let mut adapter = Adapter::new(3, Coords::repeat(1.0), &Settings::default());
        adapter.covariance = &h * d * &h;
        let spectrum = adapter.spectrum();
        for (found, wanted) in spectrum.iter().zip([5.0, 2.0, 0.5]) {
            // A few roundings of numbers below 10.
            assert!((found - wanted).abs() < 1e-12, "{spectrum:?}");
        }
        adapter.covariance[(0, 0)] = f64::NAN;
        assert!(adapter.spectrum().len() <= 3, "ends for what is not a number too");
    }

    proptest! {
        #[test]
        fn weights_equal_batch_weighted_least_squares(
            data in proptest::collection::vec((proptest::array::uniform4(-1.0..1.0f64), -1.0..1.0f64), 30..60)
        ) {
            let settings = Settings { trace_cap_per_feature: f64::INFINITY, reset_threshold: 1e9, ..Settings::default() };
            let mut adapter = Adapter::new(4, Coords::repeat(1.0), &settings);
            let lambda: f64 = settings.forgetting;
            // Oracle: argmin sum lambda^(T-t) (y - w'g)^2 + lambda^T |w|^2 / sigma_0 by the normal equations.
            let total = i32::try_from(data.len()).unwrap();
            let mut a = DMatrix::identity(4, 4) * powi(lambda, total);
            let mut b = DVector::zeros(4);
            for (t, (g, y)) in data.iter().enumerate() {
                adapter.step(&forecast(g), &Coords::repeat(*y).into(), 0.01, false, &settings);
                let g = DVector::from_column_slice(g);
                let weight = powi(lambda, total - 1 - i32::try_from(t).unwrap());
                a += &g * g.transpose() * weight;
                b += &g * (*y * weight);
            }
            let w = a.lu().solve(&b).unwrap();
            let error = (adapter.weights().column(0) - w).norm();
            prop_assert!(error < BATCH_TOLERANCE, "{error}");
        }

        #[test]
        fn trace_never_exceeds_its_cap_and_covariance_stays_symmetric(
            data in proptest::collection::vec(proptest::array::uniform4(-1.0..1.0f64), 200..400)
        ) {
            let settings = Settings::default();
            let mut adapter = Adapter::new(4, Coords::repeat(1.0), &settings);
            for g in &data {
                let adapted = adapter.step(&forecast(g), &Coords::repeat(0.1).into(), 0.01, false, &settings);
                prop_assert!(adapted.covariance_trace <= settings.trace_cap_per_feature * 4.0 * (1.0 + 1e-12));
            }
            prop_assert_eq!(adapter.covariance().transpose(), adapter.covariance().clone());
        }
    }

    #[test]
    fn a_step_of_the_residual_resets_once_per_refractory_time() {
        let settings = Settings { forgetting: 1.0, ..Settings::default() };
        let mut adapter = Adapter::new(1, Coords::repeat(1.0), &settings);
        for _ in 0..2000 {
            adapter.step(&forecast(&[1.0]), &Coords::zeros().into(), 0.01, false, &settings);
        }
        let resets: Vec<usize> = (0..100)
            .filter(|_| {
                adapter
                    .step(&forecast(&[1.0]), &Coords::repeat(5.0).into(), 0.01, false, &settings)
                    .reset
            })
            .collect();
        assert_eq!(resets.len(), 1, "a collapsed covariance reopens once: {resets:?}");
    }

    #[test]
    fn after_a_move_the_estimate_is_the_known_value() {
        let settings = Settings::default();
        let mut adapter = Adapter::new(2, Coords::repeat(2.0), &settings);
        adapter.step(&forecast(&[1.0, 0.5]), &Coords::repeat(3.0).into(), 0.01, false, &settings);
        adapter.move_to(&forecast(&[1.0, 0.5]), &Coords::repeat(-5.0));
        let after = adapter
            .step(&forecast(&[1.0, 0.5]), &Coords::zeros().into(), 0.01, true, &settings)
            .r_hat;
        assert!((*after - Coords::repeat(-5.0)).norm() < 1e-12);
    }

    #[test]
    fn a_row_whose_residual_is_unknown_teaches_nothing_and_is_not_estimated() {
        let settings = Settings::default();
        let mut adapter = Adapter::new(1, Coords::repeat(1.0), &settings);
        adapter.step(&forecast(&[1.0]), &Coords::repeat(1.0).into(), 0.01, false, &settings);
        let before = adapter.weights().clone();
        let mut known = [true; N];
        known[1] = false;
        let partly = KnownCoords::from(Coords::repeat(9.0)).only(known);
        let adapted = adapter.step(&forecast(&[1.0]), &partly, 0.01, false, &settings);
        for row in 0..N {
            assert_eq!(
                adapter.weights()[row].to_bits() == before[row].to_bits(),
                !known[row],
                "{row}"
            );
        }
        assert_eq!((adapted.r_hat.known(), adapted.innovation.known()), (known, known));
        let before = (adapter.weights().clone(), adapter.covariance().clone());
        adapter.step(&forecast(&[1.0]), &KnownCoords::unknown(), 0.01, false, &settings);
        assert_eq!(before, (adapter.weights().clone(), adapter.covariance().clone()));
    }

    #[test]
    fn frozen_or_non_finite_input_changes_nothing() {
        let settings = Settings::default();
        let mut adapter = Adapter::new(1, Coords::repeat(1.0), &settings);
        adapter.step(&forecast(&[1.0]), &Coords::repeat(1.0).into(), 0.01, false, &settings);
        let before = (adapter.weights().clone(), adapter.covariance().clone());
        adapter.step(&forecast(&[1.0]), &Coords::repeat(9.0).into(), 0.01, true, &settings);
        adapter.step(&forecast(&[f64::NAN]), &Coords::repeat(9.0).into(), 0.01, false, &settings);
        adapter.step(
            &forecast(&[1.0]),
            &Coords::repeat(f64::INFINITY).into(),
            0.01,
            false,
            &settings,
        );
        assert_eq!(before, (adapter.weights().clone(), adapter.covariance().clone()));
    }
}
