//! Predictors of the residual `r` (`eq:residual_dynamics`).
//!
//! In: the history of coordinates, rates and applied force. Out: a [`Forecast`] of `r` and the regime latent `g'`, then the
//! [`Adapted`](crate::tick::Adapted) estimate of the Latent Residual Adapter.

pub mod label;
pub mod history;
pub mod random_features;
pub mod knots;
#[cfg(test)]
mod waves;
pub mod arx;
mod arx_row;
pub mod arx_rows;
pub mod horizon;
pub mod lra;
pub mod foresight;
pub mod gravity;
pub mod persistence;
pub mod oracle;
pub mod extrapolated;
mod scaling;
pub mod weights;
pub mod nn;
pub mod fdt;
pub mod baselines;
pub mod learned;
pub mod trained;
pub mod failing;

use std::sync::Arc;

use dyn_clone::{DynClone, clone_trait_object};
use serde::{Deserialize, Serialize};

use crate::notation::Coords;
use crate::tick::Forecast;
use nn::kernels::Kernel;

pub use arx::ArxRls;
pub use arx_rows::ArxRows;
pub use extrapolated::Extrapolated;
pub use failing::Failing;
pub use fdt::Fdt;
pub use gravity::{Bias, Gravity, ZeroPredictor};
pub use history::History;
pub use oracle::Oracle;
pub use persistence::Persistence;
pub use random_features::RandomFeatures;

/// Horizon `k`, ticks, of a predictor whose weights do not say another one: `j = 0..=k`. After 250 ms every filter between an estimate
/// of the residual and the force on the vehicle has answered. The paper's is 6.
pub const HORIZON: usize = 25;

/// The steps `j` of a forecast whose errors tables state; a predictor with a shorter horizon has no figure for the later ones.
pub const REPORTED: [usize; 5] = [0, 3, 6, 10, 20];

/// A predictor forecasts the residual from the history; it is deterministic and never fails.
///
/// Example: a predictor that expects the mean of the residuals in its history.
///
/// ```
/// use twin_core::notation::{Coords, GRAVITY_M_S2};
/// use twin_core::residual::{HORIZON, History, Predictor};
/// use twin_core::tick::Forecast;
///
/// #[derive(Clone)]
/// struct ConstantBias;
///
/// impl Predictor for ConstantBias {
///     fn regime_len(&self) -> usize {
///         0 // the adapter learns nothing
///     }
///
///     fn history_len(&self) -> usize {
///         20
///     }
///
///     fn predict(&mut self, history: &History) -> Forecast {
///         let sum: Coords = history.iter().map(|entry| entry.residual_previous).sum();
///         let mean = sum / history.len().max(1) as f64;
///         let base = vec![mean.into(); HORIZON + 1];
///         Forecast { base, regime: Vec::new(), attention: Vec::new() }
///     }
/// }
///
/// // A payload of 300 g, which no model knows: the vehicle needs 2.94 N more along z to carry it.
/// let mut payload = Coords::zeros();
/// payload[2] = 0.3 * GRAVITY_M_S2;
/// let mut predictor = ConstantBias;
/// let mut history = History::new(predictor.history_len());
/// for _ in 0..50 {
///     history.push(Coords::zeros(), Coords::zeros(), payload, payload);
/// }
/// let forecast = predictor.predict(&history);
/// assert_eq!(forecast.base.len(), HORIZON + 1);
/// // Twenty additions round by less than 1e-12 N.
/// assert!(forecast.base.iter().all(|r_hat| (**r_hat - payload).norm() < 1e-12));
/// ```
pub trait Predictor: DynClone + Send {
    /// Width `d_k` of the regime latent, 0 if the predictor has none (then the adapter has nothing to learn from).
    fn regime_len(&self) -> usize;

    /// Number of ticks of history that it reads.
    fn history_len(&self) -> usize {
        1
    }

    /// Description of the predictor for viewers and recordings.
    fn info(&self) -> PredictorInfo {
        PredictorInfo::default()
    }

    /// Forecast for the newest entry of `history`. Non-finite input gives non-finite output, which the flight rejects.
    fn predict(&mut self, history: &History) -> Forecast;
}

clone_trait_object!(Predictor);

/// Properties of a predictor that are known before its first forecast.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictorInfo {
    /// Standard deviation of the residual per coordinate, N and N m: the unit of the adapter's z-scored innovation.
    pub scale: Coords,
    /// Horizon `k` of its forecasts, ticks.
    #[serde(default = "paper_horizon")]
    pub horizon: usize,
    /// Names of the input channels of its attention; empty if it has no attention.
    pub attends: Vec<String>,
    /// Arithmetic of its network: two flights of one seed are equal bit for bit only if this is equal too.
    pub kernel: String,
}

/// Horizon of recordings that were made before [`PredictorInfo::horizon`] existed, ticks.
fn paper_horizon() -> usize {
    6
}

impl Default for PredictorInfo {
    /// Properties of a predictor without a network.
    fn default() -> Self {
        Self {
            scale: Coords::from(NOMINAL_SCALE),
            horizon: HORIZON,
            attends: Vec::new(),
            kernel: Kernel::SCALAR.name().to_owned(),
        }
    }
}

/// Generalised gravity force of the vehicle as modelled (no payload), `g(chi)`, N and N m.
pub type GravityModel = Arc<dyn Fn(&Coords) -> Coords + Send + Sync>;

/// Standard deviation of the residual per coordinate over flights with excitation, N and N m: the unit of the innovation for predictors
/// without training data. Source: a control study with multisine excitation and 0, 200 and 400 g on another plant model, rounded.
pub const NOMINAL_SCALE: [f64; 8] = [1.44, 1.24, 1.87, 0.21, 0.62, 0.14, 0.57, 0.30];

/// The same forecast at every step of the horizon.
fn constant_forecast(base: Coords, regime: Vec<f64>) -> Forecast {
    Forecast { base: vec![base.into(); HORIZON + 1], regime, attention: Vec::new() }
}
