//! A flight that this program recorded: its measurements are taken as they are, nothing is resampled.

use std::path::Path;

use super::effort::Effort;
use super::recorded::{ARM_ROWS, Derivation, Instant, RecordedFlight};
use super::recording::{Recording, RecordingError, read_recording};
use crate::notation::{Coords, N, ROWS};
use crate::tick::Measurement;

/// Reads the recording in `path` as a flight to mirror.
///
/// # Errors
/// [`RecordingError`] if it cannot be read or holds no tick.
pub(super) fn replayed(path: &Path) -> Result<RecordedFlight, RecordingError> {
    let recording = read_recording(path)?;
    let measured = || recording.ticks.iter().map(|tick| &tick.measurement);
    Ok(as_recorded(
        measured().map(|m| m.t_s).collect(),
        measured().map(|m| instant(m, recording.is_mirrored())).collect(),
        recorded_nominal_inertia(&recording),
        joint_names(recording.metadata.get("joints").map(String::as_str)),
    ))
}

/// A flight as it was recorded, under this `M_bar` and with these joints.
pub(super) fn as_recorded(
    times_s: Vec<f64>,
    instants: Vec<Instant>,
    nominal_inertia: Option<Coords>,
    joint_names: Vec<String>,
) -> RecordedFlight {
    RecordedFlight {
        airborne: vec![true; instants.len()],
        times_s,
        instants,
        effort: Effort::Recorded,
        mass_kg: nominal_inertia.map_or(1.0, |inertia| inertia[0]),
        acceleration: [Derivation::Recorded; 2],
        airborne_above: 0.0,
        nominal_inertia,
        joint_names,
    }
}

impl From<&Measurement> for Instant {
    fn from(measurement: &Measurement) -> Self {
        let all = |values: &Coords| std::array::from_fn(|row| Some(values[row]));
        Self {
            chi: all(&measurement.chi),
            chi_dot: all(&measurement.chi_dot),
            chi_ddot: all(&measurement.chi_ddot),
            tau: all(&measurement.tau_applied),
        }
    }
}

/// The tick that was measured; of a `mirrored` flight what is not a number is unknown.
pub(super) fn instant(measurement: &Measurement, mirrored: bool) -> Instant {
    let mut instant = Instant::from(measurement);
    if mirrored {
        let Instant { chi, chi_dot, chi_ddot, tau } = &mut instant;
        for values in [chi, chi_dot, chi_ddot, tau] {
            values.iter_mut().for_each(|value| *value = value.filter(|v| v.is_finite()));
        }
    }
    instant
}

/// The arm's joints by the names of the URDF, as the metadata `joints` tells them; recordings that do not tell them have them by
/// the names of their rows.
pub(super) fn joint_names(told: Option<&str>) -> Vec<String> {
    let told = told.and_then(|names| serde_json::from_str(names).ok());
    told.unwrap_or_else(|| ROWS[N - ARM_ROWS..].iter().map(|row| (*row).to_owned()).collect())
}

/// `M_bar` of the gains that the recording says it was flown with, kg and kg m².
pub fn recorded_nominal_inertia(recording: &Recording) -> Option<Coords> {
    nominal_inertia(recording.metadata.get("gains")?)
}

/// `M_bar` of gains as JSON, kg and kg m².
pub(super) fn nominal_inertia(gains: &str) -> Option<Coords> {
    let gains: serde_json::Value = serde_json::from_str(gains).ok()?;
    serde_json::from_value(gains.get("gains")?.get("nominal_inertia")?.clone()).ok()
}
