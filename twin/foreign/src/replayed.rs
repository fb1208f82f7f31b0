//! A flight that this program recorded: its measurements are read unchanged and are not resampled.

use std::path::Path;

use serde::{Deserialize, Deserializer};

use super::effort::Effort;
use super::phases::Yardsticks;
use super::recorded::{ARM_ROWS, Derivation, RecordedFlight, RecordedTick};
use twin_core::notation::{COORDINATE_NAMES, Coords, KnownCoords, N};
use twin_core::tick::Measurement;
use twin_record::recording::{Recording, RecordingError, read_recording};

/// Reads the recording in `path` as a flight to mirror.
///
/// # Errors
/// [`RecordingError`] if the file cannot be read or contains no tick.
pub(super) fn replayed(path: &Path) -> Result<RecordedFlight, RecordingError> {
    let recording = read_recording(path)?;
    let measured = || recording.ticks.iter().map(|tick| &tick.measurement);
    Ok(as_recorded(
        measured().map(|m| m.t_s).collect(),
        measured().map(|m| instant(m, recording.is_mirrored())).collect(),
        measured().map(|m| m.airborne).collect(),
        recorded_nominal_inertia(&recording),
        joint_names(recording.metadata.get("joints").map(String::as_str)),
    ))
}

/// A flight from its measurements, with its nominal inertia `M_bar` in kg and kg m² and the names of its joints.
pub(super) fn as_recorded(
    times_s: Vec<f64>,
    instants: Vec<RecordedTick>,
    airborne: Vec<bool>,
    nominal_inertia: Option<Coords>,
    joint_names: Vec<String>,
) -> RecordedFlight {
    RecordedFlight {
        times_s,
        instants,
        airborne,
        effort: Effort::Recorded,
        mass_kg: nominal_inertia.map_or(1.0, |inertia| inertia[0]),
        acceleration: [Derivation::Recorded; 2],
        spans: Vec::new(),
        yardsticks: Yardsticks::default(),
        nominal_inertia,
        joint_names,
    }
}

/// The recorded tick. A value that is not a number is unknown in a `mirrored` flight, and NaN in any other.
pub(super) fn instant(measurement: &Measurement, mirrored: bool) -> RecordedTick {
    let rows = |values: &KnownCoords| std::array::from_fn(|row| values.get(row));
    RecordedTick {
        chi: or_fault(rows(&measurement.chi), mirrored),
        chi_dot: or_fault(rows(&measurement.chi_dot), mirrored),
        chi_ddot: or_fault(rows(&measurement.chi_ddot), mirrored),
        tau: or_fault(rows(&measurement.tau_applied), mirrored),
    }
}

/// A simulated flight has no unknown values: a value that is not a number is a fault there, and the loop must detect it as one.
fn or_fault(rows: [Option<f64>; N], mirrored: bool) -> [Option<f64>; N] {
    if mirrored { rows } else { rows.map(|value| value.or(Some(f64::NAN))) }
}

/// Motion and force of a recorded tick, the only data that a mirror needs.
#[derive(Clone, Debug, Default)]
pub(super) struct Moved {
    /// Time, s.
    pub(super) t_s: f64,
    /// The tick. A value that is not a number is unknown in a `mirrored` flight, and NaN in any other.
    pub(super) instant: RecordedTick,
    /// The vehicle flew, according to its source.
    pub(super) airborne: bool,
}

/// JSON of a measurement; `null` stands for a value that is not a number.
#[derive(Deserialize)]
struct Text {
    // Without this attribute a missing field would be read as `null`.
    #[serde(deserialize_with = "number")]
    t_s: Option<f64>,
    chi: [Option<f64>; N],
    chi_dot: [Option<f64>; N],
    chi_ddot: [Option<f64>; N],
    tau_applied: [Option<f64>; N],
    // Only mirrored flights have this field.
    airborne: Option<bool>,
}

/// JSON of a whole tick, from which only the measurement is read.
#[derive(Deserialize)]
struct WholeText {
    measurement: Text,
}

fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    Option::deserialize(deserializer)
}

impl Moved {
    /// Reads the JSON of a measurement or of a whole tick. The numbers equal those of the full records, and the rest is not read.
    pub(super) fn from_json(
        text: &[u8],
        is_whole_tick: bool,
        mirrored: bool,
    ) -> Result<Self, serde_json::Error> {
        let read = if is_whole_tick {
            serde_json::from_slice::<WholeText>(text)?.measurement
        } else {
            serde_json::from_slice::<Text>(text)?
        };
        let instant = RecordedTick {
            chi: or_fault(read.chi, mirrored),
            chi_dot: or_fault(read.chi_dot, mirrored),
            chi_ddot: or_fault(read.chi_ddot, mirrored),
            tau: or_fault(read.tau_applied, mirrored),
        };
        let t_s = read.t_s.unwrap_or(f64::NAN);
        Ok(Self { t_s, instant, airborne: read.airborne.unwrap_or(true) })
    }
}

/// Names of the arm's joints in the URDF, from the metadata `joints`. In a recording without this metadata the joints have the names of
/// their coordinates.
pub(super) fn joint_names(told: Option<&str>) -> Vec<String> {
    let told = told.and_then(|names| serde_json::from_str(names).ok());
    told.unwrap_or_else(|| {
        COORDINATE_NAMES[N - ARM_ROWS..].iter().map(|row| (*row).to_owned()).collect()
    })
}

/// Nominal inertia `M_bar` of the gains in the metadata of the recording, kg and kg m².
pub fn recorded_nominal_inertia(recording: &Recording) -> Option<Coords> {
    nominal_inertia(recording.metadata.get("gains")?)
}

/// Nominal inertia `M_bar` from gains in JSON, kg and kg m².
pub(super) fn nominal_inertia(gains: &str) -> Option<Coords> {
    let gains: serde_json::Value = serde_json::from_str(gains).ok()?;
    serde_json::from_value(gains.get("gains")?.get("nominal_inertia")?.clone()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_record::{fixture, lossless};

    #[test]
    fn what_is_read_of_the_text_alone_is_what_the_record_says_bit_for_bit() {
        let bits = |instant: &RecordedTick| {
            let all = [instant.chi, instant.chi_dot, instant.chi_ddot, instant.tau];
            all.map(|values| values.map(|value| value.map(f64::to_bits)))
        };
        for (mirrored, hole) in [(false, 0.25), (false, f64::NAN), (true, 0.25), (true, f64::NAN)] {
            let mut tick = fixture::tick(3);
            tick.measurement.chi[1] = hole;
            tick.measurement.tau_applied[7] = hole;
            tick.measurement.chi_ddot[0] = f64::from_bits(0x3FB9_9999_9999_999A);
            let whole = serde_json::to_vec(&tick).unwrap();
            let alone = serde_json::to_vec(&tick.measurement).unwrap();
            let record: Measurement = lossless::from_json(&alone).unwrap();
            for (text, is_whole_tick) in [(whole, true), (alone, false)] {
                let moved = Moved::from_json(&text, is_whole_tick, mirrored).unwrap();
                assert_eq!(bits(&moved.instant), bits(&instant(&record, mirrored)), "{hole}");
                assert_eq!(moved.t_s.to_bits(), record.t_s.to_bits());
            }
        }
    }

    #[test]
    fn text_that_is_no_measurement_is_an_error() {
        let mut tick = serde_json::to_value(&fixture::tick(0).measurement).unwrap();
        tick.as_object_mut().unwrap().remove("t_s");
        for text in ["", "{", "null", "[]", r#"{"t_s":1.0}"#, &tick.to_string()] {
            assert!(Moved::from_json(text.as_bytes(), false, false).is_err(), "{text}");
        }
    }
}
