//! Gains of the adaptive controller and its presets.

use serde::{Deserialize, Serialize};

use super::SafeSet;
use crate::notation::Coords;
use crate::tick::{InnerGains, InnerLaw};

/// Nominal inertia `M_bar` of the paper's controller table: baked into every residual, so the same in all presets, kg and kg m².
pub const NOMINAL_INERTIA: [f64; 8] = [2.0, 2.0, 2.0, 0.02, 0.02, 0.02, 0.05, 0.05];

/// Share of the delay by which the `tuned` preset looks ahead, found on paths of the A and B scenarios (RESULTS.md). The whole delay is too
/// much: a forecast contains the vehicle's answer to its own feedback, so a longer lead raises the gain of the loop until it swings.
const TUNED_LEAD: [f64; 8] = [0.3, 0.3, 0.3, 0.28, 0.28, 0.28, 0.5, 0.5];

/// Named starting points of [`Gains`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// The paper's table and nothing else.
    Literal,
    /// The table with the protections: `r_hat` low-pass, boundary layer, caps and clips.
    Paper,
    /// `Paper` with translation `Lambda` × 3, `Phi` × √3, and a compensation that looks ahead.
    #[default]
    Tuned,
}

/// Values in force of the adaptive control law (`eq:adaptive_control_law`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Recorded")]
pub struct Gains {
    /// Error slope `Phi`, 1/s.
    pub slope: Coords,
    /// Damping `Lambda`, N s/m and N m s/rad.
    pub damping: Coords,
    /// Nominal inertia `M_bar`, kg and kg m².
    pub nominal_inertia: Coords,
    /// Share of the loop's delay by which the compensation looks ahead, per coordinate ([`super::LoopDelays`]); 0 compensates the
    /// estimate of now, as the paper does.
    pub lead: Coords,
    /// Leak `nu` of the adaptive gain, 1/s.
    pub leak: f64,
    /// Adaptive gain at the start, `sigma_hat(0)`.
    pub robust_gain_initial: f64,
    /// Cap of the adaptive gain.
    pub robust_gain_cap: f64,
    /// Norm of `s` below which the robust term is linear.
    pub boundary_layer: f64,
    /// `r_hat` passes a first-order low-pass.
    pub residual_filter_on: bool,
    /// Corner of that low-pass, Hz.
    pub residual_bandwidth_hz: f64,
    /// `r_hat` and force are clipped to the safe set around the nominal gravity.
    pub clips: bool,
    /// The safe set of these clips.
    pub safe_set: SafeSet,
    /// Law on attitude.
    pub inner_law: InnerLaw,
}

impl Gains {
    /// The gains that the inner controller needs.
    pub fn rows(&self) -> InnerGains {
        InnerGains {
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
            lead: Coords::zeros(),
            leak: 2.0,
            robust_gain_initial: 0.1,
            robust_gain_cap: f64::MAX,
            boundary_layer: 1e-6,
            residual_filter_on: false,
            residual_bandwidth_hz: 5.0,
            clips: false,
            safe_set: SafeSet::default(),
            inner_law: InnerLaw::Rows,
        };
        let paper = Self {
            robust_gain_cap: 2.0,
            boundary_layer: 0.1,
            residual_filter_on: true,
            clips: true,
            ..literal
        };
        match preset {
            Preset::Literal => literal,
            Preset::Paper => paper,
            Preset::Tuned => {
                let mut tuned = paper;
                tuned.lead = Coords::from(TUNED_LEAD);
                for row in 0..3 {
                    tuned.damping[row] *= 3.0;
                    tuned.slope[row] *= 3.0_f64.sqrt();
                }
                tuned
            }
        }
    }
}

/// [`Gains`] as recordings store them. Older recordings do not contain the switch of the low-pass, which was off from 50 Hz on, used
/// the default safe set, and looked not ahead.
#[derive(Deserialize)]
struct Recorded {
    slope: Coords,
    damping: Coords,
    nominal_inertia: Coords,
    #[serde(default = "Coords::zeros")]
    lead: Coords,
    leak: f64,
    robust_gain_initial: f64,
    robust_gain_cap: f64,
    boundary_layer: f64,
    residual_filter_on: Option<bool>,
    residual_bandwidth_hz: f64,
    clips: bool,
    #[serde(default)]
    safe_set: SafeSet,
    inner_law: InnerLaw,
}

impl From<Recorded> for Gains {
    fn from(recorded: Recorded) -> Self {
        let was_on = recorded.residual_bandwidth_hz < 50.0;
        Self {
            slope: recorded.slope,
            damping: recorded.damping,
            nominal_inertia: recorded.nominal_inertia,
            lead: recorded.lead,
            leak: recorded.leak,
            robust_gain_initial: recorded.robust_gain_initial,
            robust_gain_cap: recorded.robust_gain_cap,
            boundary_layer: recorded.boundary_layer,
            residual_filter_on: recorded.residual_filter_on.unwrap_or(was_on),
            residual_bandwidth_hz: recorded.residual_bandwidth_hz,
            clips: recorded.clips,
            safe_set: recorded.safe_set,
            inner_law: recorded.inner_law,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_of_a_recording_made_before_the_switch_keep_their_low_pass() {
        for (corner_hz, on) in [(50.0, false), (5.0, true)] {
            let mut written = serde_json::to_value(Gains::preset(Preset::Paper)).unwrap();
            let table = written.as_object_mut().unwrap();
            table.remove("residual_filter_on");
            table.remove("safe_set");
            table.insert("residual_bandwidth_hz".to_owned(), corner_hz.into());
            let read: Gains = serde_json::from_value(written).unwrap();
            assert_eq!((read.residual_filter_on, read.safe_set), (on, SafeSet::default()));
        }
    }
}
