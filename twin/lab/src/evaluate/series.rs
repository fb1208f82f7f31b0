//! Recordings on which predictors are replayed and scored, and the statistics that z-score them.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use twin_core::elementary::squared;
use twin_core::notation::{Coords, N};
use twin_core::residual::weights::WeightsError;
use twin_core::tick::{Adaptation, Tick};
use twin_foreign::recorded_nominal_inertia;
use twin_record::{RecordingError, read_recording};

/// Ticks before this time belong to the start, while histories fill and filters settle, s.
pub(super) const SCORED_FROM_S: f64 = 2.0;

/// Reason why a table cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording does not say with which `M_bar` its residual was formed.
    #[error("{}: it does not say which nominal inertia it was flown with; record it with this version", .0.display())]
    NoInertia(PathBuf),
    /// The residuals of two recordings cannot be compared.
    #[error("{}: M_bar is {found:?}, that of the other recordings {expected:?}", .path.display())]
    Inertia {
        /// The recording.
        path: PathBuf,
        /// Its `M_bar`.
        found: Vec<f64>,
        /// `M_bar` of the other recordings.
        expected: Vec<f64>,
    },
    /// A recording has no tick that can be scored or learned from.
    #[error(
        "{}: none of its {ticks} ticks can be scored: in {following} the reference follows the measurement, as in a mirrored flight; in {held} adaptation is held, as in contact and on the ground; {early} are in the first {SCORED_FROM_S} s, while filters settle; {faulty} have a fault. Name a flight of this program that flies free, such as one of `twin collect`",
        .path.display()
    )]
    NothingUsable {
        /// The recording.
        path: PathBuf,
        /// Number of its ticks.
        ticks: usize,
        /// Number of ticks whose reference follows the measurement.
        following: usize,
        /// Number of ticks in which adaptation is held.
        held: usize,
        /// Number of ticks with a fault.
        faulty: usize,
        /// Number of ticks before `SCORED_FROM_S`.
        early: usize,
    },
    /// A folder contains no training recordings.
    #[error("{}: no recording collect_*.mcap in it; make some: twin collect --out {}", .0.display(), .0.display())]
    NoTraining(PathBuf),
    /// A file of weights is not usable.
    #[error("{}: {why}", .path.display())]
    Weights {
        /// The file.
        path: PathBuf,
        /// Reason.
        why: WeightsError,
    },
    /// A file cannot be read or written.
    #[error("{}: {why}", .path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        why: std::io::Error,
    },
    /// A line of the table does not exist.
    #[error("{name:?} is no row of the table; there are {known}")]
    UnknownRow {
        /// Name that was given.
        name: String,
        /// Existing names.
        known: String,
    },
    /// The vehicle of the recording cannot be built.
    #[error(transparent)]
    Scenario(#[from] twin_scenario::ScenarioError),
    /// The flight cannot be built.
    #[error(transparent)]
    Build(#[from] twin_scenario::BuildError),
}

/// One tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplayTick {
    /// Simulated time, s.
    pub t_s: f64,
    /// Coordinates, m and rad.
    pub chi: Coords,
    /// Rates.
    pub chi_dot: Coords,
    /// Applied force at this tick, N and N m.
    pub tau: Coords,
    /// Residual at this tick, N and N m.
    pub residual: Coords,
    /// True if the residual may be used for training and scoring: no contact, no fault.
    pub usable: bool,
}

/// Refuses a flight without a usable tick, whose scores would be those of nothing.
fn some_usable(path: &Path, ticks: &[Tick]) -> Result<(), EvaluateError> {
    let scored =
        |tick: &Tick| ReplayTick::from(tick).usable && tick.measurement.t_s >= SCORED_FROM_S;
    if ticks.iter().any(scored) {
        return Ok(());
    }
    let count = |which: fn(&Tick) -> bool| ticks.iter().filter(|tick| which(tick)).count();
    Err(EvaluateError::NothingUsable {
        path: path.to_owned(),
        ticks: ticks.len(),
        following: count(|tick| tick.reference.follows_measurement),
        held: count(|tick| tick.reference.adaptation != Adaptation::Free),
        faulty: count(|tick| tick.fault.is_some()),
        early: count(|tick| tick.measurement.t_s < SCORED_FROM_S),
    })
}

impl From<&Tick> for ReplayTick {
    fn from(tick: &Tick) -> Self {
        Self {
            t_s: tick.measurement.t_s,
            chi: *tick.measurement.chi,
            chi_dot: *tick.measurement.chi_dot,
            tau: *tick.measurement.tau_applied,
            residual: *tick.residual,
            usable: tick.reference.adaptation == Adaptation::Free
                && !tick.reference.follows_measurement
                && tick.fault.is_none(),
        }
    }
}

/// SHA-256 of `samples`, in hex.
fn hash(samples: &[ReplayTick]) -> String {
    let mut hash = Sha256::new();
    for ReplayTick { t_s, chi, chi_dot, tau, residual, usable } in samples {
        let numbers = [chi, chi_dot, tau, residual].into_iter().flat_map(|part| part.iter());
        for number in std::iter::once(t_s).chain(numbers) {
            hash.update(number.to_le_bytes());
        }
        hash.update([u8::from(*usable)]);
    }
    hash.finalize().iter().fold(String::new(), |text, byte| format!("{text}{byte:02x}"))
}

/// A recorded flight.
#[derive(Clone, Debug)]
pub struct Series {
    /// The recording.
    pub file: PathBuf,
    /// SHA-256 of its ticks, in hex: equal for every recording of the same flight, however its chunks are cut.
    pub sha256: String,
    /// Seed of the flight.
    pub seed: String,
    /// `M_bar` with which its residual was formed, kg and kg m².
    pub m_bar: Coords,
    /// Its ticks.
    pub samples: Vec<ReplayTick>,
}

impl Series {
    /// Reads a recording of this program.
    ///
    /// # Errors
    /// [`EvaluateError`] if the recording cannot be read, does not say its `M_bar` or has no usable tick.
    pub fn read(path: &Path) -> Result<Self, EvaluateError> {
        let recording = read_recording(path)?;
        some_usable(path, &recording.ticks)?;
        let samples: Vec<ReplayTick> = recording.ticks.iter().map(ReplayTick::from).collect();
        Ok(Self {
            file: path.to_owned(),
            sha256: hash(&samples),
            seed: recording.metadata.get("seed").cloned().unwrap_or_default(),
            m_bar: recorded_nominal_inertia(&recording)
                .ok_or_else(|| EvaluateError::NoInertia(path.to_owned()))?,
            samples,
        })
    }

    /// The training recordings in `folder`, `collect_*.mcap` by name.
    ///
    /// # Errors
    /// [`EvaluateError`] if the folder contains no recording, one cannot be read, or they differ in `M_bar`.
    pub fn read_training(folder: &Path) -> Result<Vec<Self>, EvaluateError> {
        let entries = std::fs::read_dir(folder).map_err(|why| match why.kind() {
            std::io::ErrorKind::NotFound => EvaluateError::NoTraining(folder.to_owned()),
            _ => EvaluateError::File { path: folder.to_owned(), why },
        })?;
        let mut paths: Vec<PathBuf> =
            entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
        paths.retain(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("collect_") && name.ends_with(".mcap")
        });
        paths.sort();
        if paths.is_empty() {
            return Err(EvaluateError::NoTraining(folder.to_owned()));
        }
        let all =
            paths.iter().map(|path| Self::read(path)).collect::<Result<Vec<_>, EvaluateError>>()?;
        all.iter().try_for_each(|series| series.compare(&all[0]))?;
        Ok(all)
    }

    /// Checks that both residuals were formed with the same `M_bar`.
    ///
    /// # Errors
    /// [`EvaluateError::Inertia`] if they differ.
    pub fn compare(&self, other: &Self) -> Result<(), EvaluateError> {
        if self.m_bar == other.m_bar {
            return Ok(());
        }
        let list = |m: &Coords| m.iter().copied().collect();
        let (found, expected) = (list(&self.m_bar), list(&other.m_bar));
        Err(EvaluateError::Inertia { path: self.file.clone(), found, expected })
    }
}

/// Means and standard deviations over the training flights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Mean of each input channel `chi`, `chi_dot`, `tau_{t-1}`.
    pub input_mean: Vec<f64>,
    /// Standard deviation of each input channel.
    pub input_std: Vec<f64>,
    /// Mean of the residual per coordinate, N and N m.
    pub output_mean: Coords,
    /// Standard deviation of the residual per coordinate, N and N m.
    pub output_std: Coords,
}

/// Standard deviation below which a channel counts as constant.
const LEAST_STD: f64 = 1e-9;

impl Statistics {
    /// Statistics over the usable ticks of `flights`.
    pub fn of(flights: &[Series]) -> Self {
        let mut rows: Vec<[f64; 4 * N]> = Vec::new();
        for flight in flights {
            for (before, now) in flight.samples.iter().zip(flight.samples.iter().skip(1)) {
                if now.usable {
                    rows.push(row(before, now));
                }
            }
        }
        let n = rows.len().max(1) as f64;
        let mean: Vec<f64> =
            (0..4 * N).map(|i| rows.iter().map(|row| row[i]).sum::<f64>() / n).collect();
        let std: Vec<f64> = (0..4 * N)
            .map(|i| {
                let square: f64 = rows.iter().map(|row| squared(row[i] - mean[i])).sum();
                let std = (square / n).sqrt();
                if std > LEAST_STD { std } else { 1.0 }
            })
            .collect();
        Self {
            input_mean: mean[..3 * N].to_vec(),
            input_std: std[..3 * N].to_vec(),
            output_mean: Coords::from_column_slice(&mean[3 * N..]),
            output_std: Coords::from_column_slice(&std[3 * N..]),
        }
    }
}

/// Inputs and residual of a tick.
pub(super) fn row(before: &ReplayTick, now: &ReplayTick) -> [f64; 4 * N] {
    let parts = [&now.chi, &now.chi_dot, &before.tau, &now.residual];
    std::array::from_fn(|i| parts[i / N][i % N])
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::fixture;

    #[test]
    fn a_flight_without_a_usable_tick_is_refused_with_the_reasons() {
        let mut ticks: Vec<Tick> = (0..5).map(fixture::tick).collect();
        for (tick, t_s) in ticks.iter_mut().zip(0_u8..) {
            tick.measurement.t_s = SCORED_FROM_S + f64::from(t_s);
            tick.reference.follows_measurement = false;
            tick.reference.adaptation = Adaptation::Free;
            tick.fault = None;
        }
        let path = Path::new("flight.mcap");
        assert!(some_usable(path, &ticks).is_ok());
        ticks[..3].iter_mut().for_each(|tick| tick.reference.follows_measurement = true);
        assert!(some_usable(path, &ticks).is_ok(), "two are left");
        ticks[3].measurement.t_s = SCORED_FROM_S / 2.0;
        ticks[4].measurement.t_s = SCORED_FROM_S / 2.0;
        assert!(some_usable(path, &ticks).is_err(), "two are early");
        ticks[2..].iter_mut().for_each(|tick| tick.reference.adaptation = Adaptation::Held);
        let words = some_usable(path, &ticks).unwrap_err().to_string();
        for part in [
            "flight.mcap: none of its 5",
            "in 3 the reference",
            "in 3 adaptation",
            "2 are in the first 2 s",
            "0 have a fault",
        ] {
            assert!(words.contains(part), "{part:?} is not in {words:?}");
        }
        assert!(some_usable(path, &[]).is_err(), "an empty flight has none");
    }
}
