//! Gains of the adaptive controller and its presets.

use serde::{Deserialize, Serialize};

use super::SafeSet;
use crate::notation::Coords;
use crate::tick::{InnerLaw, RowGains};

/// Nominal inertia `M_bar` of the paper's controller table: baked into every residual, so the same in all presets, kg and kg m².
pub const NOMINAL_INERTIA: [f64; 8] = [2.0, 2.0, 2.0, 0.02, 0.02, 0.02, 0.05, 0.05];

/// Named starting points of [`Gains`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// The paper's table and nothing else.
    Literal,
    /// The table with the protections: `r_hat` low-pass, boundary layer, caps and clips.
    Paper,
    /// `Paper` with translation `Lambda` × 3 and `Phi` × √3.
    #[default]
    Tuned,
}

/// Values in force of the adaptive control law (`eq:adaptive_control_law`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// Error slope `Phi`, 1/s.
    pub slope: Coords,
    /// Damping `Lambda`, N s/m and N m s/rad.
    pub damping: Coords,
    /// Nominal inertia `M_bar`, kg and kg m².
    pub nominal_inertia: Coords,
    /// Leak `nu` of the adaptive gain, 1/s.
    pub leak: f64,
    /// Adaptive gain at the start, `sigma_hat(0)`.
    pub robust_gain_initial: f64,
    /// Cap of the adaptive gain.
    pub robust_gain_cap: f64,
    /// Norm of `s` below which the robust term is linear.
    pub boundary_layer: f64,
    /// Corner of the first-order low-pass on `r_hat`, Hz; at or above 50 Hz (Nyquist of the tick) it is off.
    pub residual_bandwidth_hz: f64,
    /// `r_hat` and force are clipped to the safe set around the nominal gravity.
    pub clips: bool,
    /// That set; older recordings were flown with the default.
    #[serde(default)]
    pub safe_set: SafeSet,
    /// Law on attitude.
    pub inner_law: InnerLaw,
}

impl Gains {
    /// The part the inner rows need.
    pub fn rows(&self) -> RowGains {
        RowGains {
            law: self.inner_law,
            slope: self.slope,
            damping: self.damping,
            nominal_inertia: self.nominal_inertia,
            boundary_layer: self.boundary_layer,
        }
    }

    /// The gains of `preset` (`tab:controller_params`).
    pub fn preset(preset: Preset) -> Self {
        let literal = Self {
            slope: Coords::from([1.0, 1.0, 1.5, 1.1, 1.1, 1.0, 1.2, 1.2]),
            damping: Coords::from([2.0, 2.0, 3.5, 1.5, 1.5, 1.2, 3.0, 3.0]),
            nominal_inertia: Coords::from(NOMINAL_INERTIA),
            leak: 2.0,
            robust_gain_initial: 0.1,
            robust_gain_cap: f64::MAX,
            boundary_layer: 1e-6,
            residual_bandwidth_hz: 50.0,
            clips: false,
            safe_set: SafeSet::default(),
            inner_law: InnerLaw::Rows,
        };
        let paper = Self {
            robust_gain_cap: 2.0,
            boundary_layer: 0.1,
            residual_bandwidth_hz: 5.0,
            clips: true,
            ..literal
        };
        match preset {
            Preset::Literal => literal,
            Preset::Paper => paper,
            Preset::Tuned => {
                let mut tuned = paper;
                for row in 0..3 {
                    tuned.damping[row] *= 3.0;
                    tuned.slope[row] *= 3.0_f64.sqrt();
                }
                tuned
            }
        }
    }
}
