//! A flight that this program recorded: its measurements are taken as they are, nothing is resampled.

use std::path::Path;

use super::effort::Effort;
use super::recorded::{ARM_ROWS, Derivation, Instant, RecordedFlight};
use super::recording::{Recording, RecordingError, read_recording};
use crate::notation::{Coords, N, ROWS};

/// Reads the recording in `path` as a flight to mirror.
///
/// # Errors
/// [`RecordingError`] if it cannot be read or holds no tick.
pub(super) fn replayed(path: &Path) -> Result<RecordedFlight, RecordingError> {
    let recording = read_recording(path)?;
    let nominal_inertia = recorded_nominal_inertia(&recording);
    let all = |values: &Coords| std::array::from_fn(|row| Some(values[row]));
    let measured = || recording.ticks.iter().map(|tick| &tick.measurement);
    Ok(RecordedFlight {
        times_s: measured().map(|m| m.t_s).collect(),
        instants: measured()
            .map(|m| Instant {
                chi: all(&m.chi),
                chi_dot: all(&m.chi_dot),
                chi_ddot: all(&m.chi_ddot),
                tau: all(&m.tau_applied),
            })
            .collect(),
        effort: Effort::Recorded,
        mass_kg: nominal_inertia.map_or(1.0, |inertia| inertia[0]),
        airborne: vec![true; recording.ticks.len()],
        acceleration: [Derivation::Recorded; 2],
        nominal_inertia,
        joint_names: joint_names(&recording),
    })
}

/// The arm's joints by the names of the URDF; recordings that do not tell them have them by the names of their rows.
fn joint_names(recording: &Recording) -> Vec<String> {
    let told = recording.metadata.get("joints").and_then(|names| serde_json::from_str(names).ok());
    told.unwrap_or_else(|| ROWS[N - ARM_ROWS..].iter().map(|row| (*row).to_owned()).collect())
}

/// `M_bar` of the gains that the recording says it was flown with, kg and kg m².
pub fn recorded_nominal_inertia(recording: &Recording) -> Option<Coords> {
    let gains: serde_json::Value = serde_json::from_str(recording.metadata.get("gains")?).ok()?;
    serde_json::from_value(gains.get("gains")?.get("nominal_inertia")?.clone()).ok()
}
