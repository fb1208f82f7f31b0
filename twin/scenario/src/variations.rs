//! The training flights beyond the paper's: a loop that compensates moves otherwise than one that does not, and a predictor that has not
//! seen such flights forecasts a motion that does not come.
//!
//! The table stands in RESULTS.md: trained on the paper's three flights under plain PID, a line of best fit errs by 0.25 of the residual's
//! deviation 100 ms ahead on a path of B; with these flights it errs by 0.18.

/// A training flight: name, payload in g, and the overrides of `collect_200g.toml`.
pub(super) type Variation = (&'static str, u32, &'static [&'static str]);

/// No excitation: the smooth motion in which the vehicle works.
const SMOOTH: &str = "controller.multisine.tones=0";

/// Turbulence in a mean wind, without excitation, beside which the rotors would have no thrust left.
const TURBULENT: [&str; 4] =
    [SMOOTH, "wind.kind=dryden", "wind.turbulence_m_s=1.0", "wind.velocity_m_s=[3.0, 0.0, 0.0]"];

/// Control of the flights that compensate the last residual.
pub(super) const ADAPTIVE: [&str; 2] = ["controller.kind=adaptive", "gains.preset=tuned"];

/// Flights with the adaptive controller, which compensates the last residual.
pub(super) const COMPENSATED: [Variation; 5] = [
    ("collect_adaptive_0g", 0, &[]),
    ("collect_adaptive_300g", 300, &[]),
    ("collect_adaptive_100g_smooth", 100, &[SMOOTH]),
    ("collect_adaptive_500g_smooth", 500, &[SMOOTH]),
    ("collect_adaptive_400g_wind", 400, &TURBULENT),
];

/// Flights in which the controller compensates what given weights forecast.
pub(super) const FORESEEN: [Variation; 4] = [
    ("collect_foreseen_0g", 0, &[]),
    ("collect_foreseen_300g_smooth", 300, &[SMOOTH]),
    ("collect_foreseen_500g_smooth", 500, &[SMOOTH]),
    ("collect_foreseen_400g_wind", 400, &TURBULENT),
];
