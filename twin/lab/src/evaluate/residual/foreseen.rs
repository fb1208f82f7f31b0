//! The forecasts of a variant, in standard deviations of the residual with everything on.

use serde::Serialize;

use super::foresight::MODEL_NAMES;
use super::measured::Measured;
use super::variant::Variant;
use super::windows::HORIZONS_TICKS;
use twin_core::notation::{Coords, TICK_S};

/// The forecasts at one horizon. Errors are in standard deviations of the residual with everything on.
#[derive(Clone, Debug, Serialize)]
pub struct At {
    /// Time ahead of the current tick, ms.
    pub ms: f64,
    /// RMSE over coordinates and time, by model.
    pub rmse_z: [f64; MODEL_NAMES.len()],
    /// RMSE of the long window divided by that of the short window.
    pub ratio: f64,
    /// RMSE of each coordinate, by model.
    pub rows: [Coords; MODEL_NAMES.len()],
}

/// The forecasts of a variant.
#[derive(Clone, Debug, Serialize)]
pub struct Foreseen {
    /// Which effects were on.
    pub variant: Variant,
    /// Ridge of the regressions on the short and on the long window; `None` without samples.
    pub ridge: Option<[f64; 2]>,
    /// Windows of the fit and of the test.
    pub samples: [usize; 2],
    /// Errors by horizon.
    pub horizons: Vec<At>,
}

impl Foreseen {
    /// Mean over the horizons of the ratio of the two windows.
    pub fn ratio(&self) -> f64 {
        self.horizons.iter().map(|at| at.ratio).sum::<f64>() / self.horizons.len() as f64
    }
}

/// The forecasts of `measured`, in units of `std`.
pub(super) fn foreseen(measured: &Measured, std: &Coords) -> Foreseen {
    let foresight = &measured.foresight;
    let at = |(horizon, ticks): (usize, usize)| At {
        ms: ticks as f64 * TICK_S * 1e3,
        rmse_z: std::array::from_fn(|model| foresight.rmse_z(model, horizon, std)),
        ratio: foresight.ratio(horizon, std),
        rows: foresight.rmse.map(|horizons| horizons[horizon].component_div(std)),
    };
    Foreseen {
        variant: measured.variant,
        ridge: foresight.ridge,
        samples: foresight.samples,
        horizons: HORIZONS_TICKS.into_iter().enumerate().map(at).collect(),
    }
}
