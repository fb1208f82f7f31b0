//! Latent Residual Adapter: Recursive Least Squares on the regime latent with forgetting, trace cap and covariance reset.
//!
//! In: base forecast `r_hat_base`, regime `g'`, measured residual `r`. Out: [`Adapted`]. State: `W` (`d_k` × n), `Sigma`
//! (`d_k` × `d_k`), the bias, the moving average of the innovation, ticks since the last reset.
//!
//! Three parts are ours, and off in the presets of the paper: a bias per coordinate, which learns a constant force without waiting for a
//! feature that is constant; a leak of the weights towards zero, so that a correction that nothing asks for any more fades; and the
//! correction of the whole horizon ([`HorizonAdapter`]).

use nalgebra::{Const, DMatrix, DVector, Dyn, OMatrix};
use serde::{Deserialize, Serialize};

use super::History;
use super::horizon::{self, HorizonAdapter};
use crate::elementary::exp;
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
    /// Time constant with which the bias follows what base and weights leave over, s; 0 switches the bias off.
    #[serde(default)]
    pub bias_s: f64,
    /// Rate at which the weights leak to zero, 1/s.
    #[serde(default)]
    pub weight_leak_per_s: f64,
    /// Time constant with which the correction of the whole horizon forgets, s; 0 switches that correction off.
    #[serde(default)]
    pub horizon_memory_s: f64,
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
            bias_s: 0.0,
            weight_leak_per_s: 0.0,
            horizon_memory_s: 0.0,
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
    /// The constant part of the correction, in units of the scale.
    bias: Coords,
    innovation_mean: Coords,
    ticks_since_reset: u64,
    /// From the first tick on in which it is switched on: it is large, and a copy of a flight copies it.
    horizon: Option<Box<HorizonAdapter>>,
}

impl Adapter {
    /// An adapter over `d_k` features. `scale` is the unit of its innovation per coordinate (z-score: the standard deviation of the
    /// residual; physical units: ones).
    pub fn new(d_k: usize, scale: Coords, settings: &Settings) -> Self {
        Self {
            scale,
            weights: Weights::zeros(d_k),
            covariance: DMatrix::identity(d_k, d_k) * settings.reset_scale,
            bias: Coords::zeros(),
            innovation_mean: Coords::zeros(),
            ticks_since_reset: u64::MAX / 2,
            horizon: None,
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

    /// Eigenvalues of `Sigma`, largest first; empty if they cannot be found, and without features.
    pub fn spectrum(&self) -> Vec<f64> {
        // Bound on the iterations: the decomposition must end for every matrix.
        const MOST_STEPS: usize = 10_000;
        if self.covariance.is_empty() {
            return Vec::new();
        }
        let found =
            nalgebra::SymmetricEigen::try_new(self.covariance.clone(), f64::EPSILON, MOST_STEPS);
        let mut values = found.map_or_else(Vec::new, |e| e.eigenvalues.iter().copied().collect());
        values.sort_by(|a: &f64, b| b.total_cmp(a));
        values
    }

    /// Changes the estimate for `forecast` to `known` (N and N m): by the bias if there is one, otherwise by the smallest change of the
    /// weights. The adapter need not learn a known jump, such as the release of a payload, from its error. A coordinate without a known
    /// forecast is not changed.
    pub fn move_to(&mut self, forecast: &Forecast, known: &Coords, settings: &Settings) {
        let g = DVector::from_column_slice(&forecast.regime);
        let power = g.norm_squared();
        let base = forecast.base.first().copied().unwrap_or_else(|| Coords::zeros().into());
        let step = (known - *base).component_div(&self.scale) - self.correction(&g);
        let step = KnownCoords::from(step).only(base.known()).or(&Coords::zeros());
        if !self.adapts(&g) {
            return;
        }
        if settings.bias_s > 0.0 && step.iter().all(|v| v.is_finite()) {
            self.bias += step;
        } else if power > 0.0 && power.is_finite() && step.iter().all(|v| v.is_finite()) {
            self.weights += &g * (step / power).transpose();
        }
    }

    /// One step of Algorithm 1, lines 5 to 8. With `frozen` it estimates but does not learn. A non-finite input leaves the state unchanged.
    /// In a coordinate whose residual is unknown it learns nothing, and the estimate is unknown.
    pub fn step(
        &mut self,
        forecast: &Forecast,
        history: &History,
        residual: &KnownCoords,
        dt_s: f64,
        frozen: bool,
        settings: &Settings,
    ) -> Adapted {
        let base = forecast.base.first().map_or_else(Coords::zeros, |base| **base);
        let g = DVector::from_column_slice(&forecast.regime);
        let correction = self.correction(&g);
        let correction = correction.component_mul(&self.scale);
        let r_hat_prior = base + correction;
        // lip: innovation with the weights of the previous tick
        let innovation = (**residual - r_hat_prior).component_div(&self.scale);
        let known = residual.known();
        let said = |values: Coords| KnownCoords::from(values).only(known);
        // An innovation of zero moves no weight.
        let lesson = said(innovation).or(&Coords::zeros());
        let usable = settings.enabled
            && !frozen
            && self.adapts(&g)
            && residual.is_any_known()
            && lesson.iter().chain(g.iter()).all(|v| v.is_finite());
        let horizon = if settings.enabled && settings.horizon_memory_s > 0.0 && self.adapts(&g) {
            let forgetting = horizon::forgetting(settings.horizon_memory_s, dt_s);
            let scale = self.scale;
            self.horizon.get_or_insert_with(|| Box::new(HorizonAdapter::new(scale))).step(
                forecast,
                &correction,
                history,
                residual,
                forgetting,
                usable,
            )
        } else {
            Vec::new()
        };
        let mut gain_norm = 0.0;
        let mut reset = false;
        if usable {
            self.weights *= exp(-settings.weight_leak_per_s * dt_s);
            gain_norm = self.rls(&g, &lesson, settings);
            reset = self.detect_reset(&lesson, dt_s, settings);
        }
        // A predictor without a regime has nothing to adapt, and no bias either.
        if usable && settings.bias_s > 0.0 {
            // What the weights do not explain after they learned.
            let left = said((**residual - base).component_div(&self.scale) - self.correction(&g));
            self.bias += left.or(&Coords::zeros()) * (1.0 - exp(-dt_s / settings.bias_s));
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
            bias: self.bias.component_mul(&self.scale),
            horizon,
            reset,
            frozen: frozen || !settings.enabled,
        }
    }

    /// Whether `g` are the features of this adapter, and there are any.
    fn adapts(&self, g: &DVector<f64>) -> bool {
        g.len() == self.weights.nrows() && !g.is_empty()
    }

    /// The correction on the features `g`, bias included, in units of the scale.
    fn correction(&self, g: &DVector<f64>) -> Coords {
        if !self.adapts(g) {
            return Coords::zeros();
        }
        self.weights.tr_mul(g) + self.bias
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
#[path = "lra_tests.rs"]
mod tests;
