//! What clients are told of the twin that flies beside a mirrored recording.

use serde::Serialize;
use ts_rs::TS;

use twin_foreign::Light;

/// How far the twin is from a mirrored flight, having started from it some time ago under the commands that were recorded.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct TwinInfo {
    /// What flew, one sentence.
    pub says: String,
    /// How long ago it started, s.
    pub horizon_s: f64,
    /// The worst axis; `null` where force or motion is unknown.
    pub light: Option<Light>,
    /// Where the forecasts of the flight so far are better than persistence and than the mean, and where not, in words.
    pub gate: String,
    /// Whether they are better at every step; `null` without a score.
    pub gate_passed: Option<bool>,
    /// Axes that are compared.
    pub axes: Vec<TwinAxis>,
}

/// One axis of it, m or rad.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct TwinAxis {
    /// Name of the row.
    pub row: String,
    /// Twin less flight.
    pub twin: f64,
    /// The same of the twin with the residual of the half second before it started.
    pub with_residual: f64,
    /// The same of what simply went on as it moved.
    pub coasting: f64,
}
