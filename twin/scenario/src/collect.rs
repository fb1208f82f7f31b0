//! Collects training data: flies each flight, records it as MCAP and summarises it.
//!
//! In: scenarios. Out: recordings, and for each flight a [`Collected`] with its hash, its verdict and the spread of its residual.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::variations::{ADAPTIVE, COMPENSATED, FORESEEN, Variation};
use super::{BuildError, Scenario, ScenarioError, Verdict, run};
use twin_core::notation::{Coords, N};
use twin_core::tick::Tick;
use twin_input::interruption::{self, Interrupted};
use twin_input::{InputError, file};
use twin_record::{OutputError, Outputs, Recorder, RecordingEnd, RecordingError};

/// Number of ticks between two reports of progress.
const PROGRESS_TICKS: u64 = 100;

/// One flight to collect.
#[derive(Clone, Debug)]
pub struct Flight {
    /// What to fly.
    pub scenario: Scenario,
    /// File of the recording. Its name says to a training what the flight is, so it is never numbered.
    pub file: PathBuf,
}

/// Which flights are collected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Extent {
    /// The paper's: plain PID with excitation, one flight per payload.
    Paper,
    /// The paper's, and flights with the adaptive controller.
    All,
    /// Flights whose controller compensates what these weights forecast, and nothing else.
    Foreseen(PathBuf),
}

/// Flights to collect.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Folder of the scenarios `collect_{payload}g.toml` and `test_300g.toml`.
    pub scenarios: PathBuf,
    /// Folder of the recordings.
    pub out: PathBuf,
    /// Which flights.
    pub extent: Extent,
    /// Payloads of the paper's flights, g.
    pub payloads_g: Vec<u32>,
    /// Length of each flight, s.
    pub seconds: f64,
    /// Seed of the first flight; each further flight uses the next seed.
    pub seed: u64,
    /// `key=value` overrides.
    pub overrides: Vec<String>,
}

/// Reason why flights cannot be collected.
#[derive(Debug, thiserror::Error)]
pub enum CollectError {
    /// A scenario is not usable.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A flight cannot be put together.
    #[error("{scenario}: {why}")]
    Build {
        /// Scenario.
        scenario: String,
        /// Why.
        why: Box<BuildError>,
    },
    /// A recording cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The file of a recording cannot be created.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A signal asked the program to end before the flight began.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A file cannot be read.
    #[error("{}: {why}", .path.display())]
    Input {
        /// Path of the file.
        path: PathBuf,
        /// The reason.
        why: InputError,
    },
    /// A folder or file cannot be used.
    #[error("{}: {why}", .path.display())]
    File {
        /// Path of the folder or file.
        path: PathBuf,
        /// Error of the operating system.
        why: std::io::Error,
    },
}

/// Summary of a collected flight.
#[derive(Clone, Debug, Serialize)]
pub struct Collected {
    /// The recording.
    pub file: PathBuf,
    /// Scenario.
    pub scenario: String,
    /// Seed.
    pub seed: u64,
    /// Payload, kg.
    pub payload_kg: f64,
    /// Ticks recorded.
    pub ticks: u64,
    /// How the flight ended.
    pub verdict: Verdict,
    /// Reason for the verdict, in a sentence.
    pub reason: String,
    /// Hash of the flight.
    pub state_hash: String,
    /// Sha-256 of the recording.
    pub sha256: String,
    /// Mean and standard deviation of the residual, N and N m.
    pub residual: Spread,
    /// Root mean square of the position error, m.
    pub position_rmse_m: f64,
    /// Largest tilt, rad.
    pub tilt_peak_rad: f64,
    /// Share of ticks in saturation.
    pub saturation_share: f64,
    /// Ticks in which the vehicle touched something.
    pub contact_ticks: u64,
}

impl Collected {
    /// True if the flight is usable as training data: it was completed and touched nothing.
    pub fn usable(&self) -> bool {
        self.verdict == Verdict::Completed && self.contact_ticks == 0
    }
}

/// Mean and standard deviation per coordinate, of one flight or of several together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Number of ticks.
    pub count: f64,
    /// Mean, N and N m.
    pub mean: Coords,
    /// Standard deviation, N and N m.
    pub std: Coords,
}

impl Spread {
    /// Mean and standard deviation of `values`.
    fn of(values: &[Coords]) -> Self {
        let count = values.len() as f64;
        let n = count.max(1.0);
        let mean = values.iter().sum::<Coords>() / n;
        let squares = values.iter().map(|v| (v - mean).component_mul(&(v - mean))).sum::<Coords>();
        Self { count, mean, std: (squares / n).map(f64::sqrt) }
    }

    /// Mean and standard deviation over all ticks of `parts`.
    pub fn together(parts: &[Spread]) -> Spread {
        let count: f64 = parts.iter().map(|part| part.count).sum();
        let n = count.max(1.0);
        let mean = parts.iter().map(|part| part.mean * part.count).sum::<Coords>() / n;
        let square = |part: &Spread| {
            let off = part.mean - mean;
            (part.std.component_mul(&part.std) + off.component_mul(&off)) * part.count
        };
        let variance = parts.iter().map(square).sum::<Coords>() / n;
        Spread { count, mean, std: variance.map(f64::sqrt) }
    }
}

impl Plan {
    /// The paper's training flights and its test flight, then the other training flights.
    ///
    /// # Errors
    /// [`CollectError`] if a scenario is not usable.
    pub fn flights(&self) -> Result<Vec<Flight>, CollectError> {
        let strings = |keys: &[&str]| keys.iter().map(|key| (*key).to_owned()).collect();
        let paper = || {
            let names = self.payloads_g.iter().map(|g| (format!("collect_{g}g"), Some(*g)));
            names.chain([("test_300g".to_owned(), None)]).map(|(name, g)| (name, g, Vec::new()))
        };
        let varied = |variations: &[Variation], keys: &[String]| -> Vec<_> {
            let one = |(name, payload_g, own): &Variation| {
                let all = [strings(&ADAPTIVE), keys.to_vec(), strings(own)].concat();
                ((*name).to_owned(), Some(*payload_g), all)
            };
            variations.iter().map(one).collect()
        };
        let all: Vec<(String, Option<u32>, Vec<String>)> = match &self.extent {
            Extent::Paper => paper().collect(),
            Extent::All => paper().chain(varied(&COMPENSATED, &[])).collect(),
            Extent::Foreseen(weights) => {
                let keys = [
                    "predictor.kind=trained".to_owned(),
                    format!("predictor.weights={}", weights.display()),
                    "predictor.force=true".to_owned(),
                    "gains.adapter_on=0".to_owned(),
                ];
                varied(&FORESEEN, &keys)
            }
        };
        let numbered = all.into_iter().zip(self.seed..);
        numbered.map(|((name, g, keys), seed)| self.flight(&name, g, keys, seed)).collect()
    }

    /// A payload without a scenario of its own uses the scenario of 200 g.
    fn flight(
        &self,
        name: &str,
        payload_g: Option<u32>,
        keys: Vec<String>,
        seed: u64,
    ) -> Result<Flight, CollectError> {
        let own = self.scenarios.join(format!("{name}.toml"));
        let file = if own.exists() { own } else { self.scenarios.join("collect_200g.toml") };
        let mut overrides =
            vec![format!("seed={seed}"), format!("task.duration_s={:?}", self.seconds)];
        overrides.extend(payload_g.map(|g| format!("payload.mass_kg={:?}", f64::from(g) / 1000.0)));
        overrides.extend(keys);
        overrides.extend(self.overrides.iter().cloned());
        let scenario = Scenario { name: name.to_owned(), ..Scenario::load(&file, &overrides)? };
        Ok(Flight { scenario, file: self.out.join(format!("{name}.mcap")) })
    }
}

/// Flies and records `flight`; one that a signal ends has a finished recording and the verdict `interrupted`. `progress` receives the number of ticks since its last call.
///
/// # Errors
/// [`CollectError`] if the flight cannot be built or the recording cannot be written.
pub fn collect(
    flight: &Flight,
    outputs: &Outputs,
    progress: &dyn Fn(u64),
) -> Result<Collected, CollectError> {
    interruption::check()?;
    let Flight { scenario, file } = flight;
    let build = |why: BuildError| CollectError::Build {
        scenario: scenario.name.clone(),
        why: Box::new(why),
    };
    let tuning = scenario.tuning().map_err(|why| build(why.into()))?;
    let info = scenario.recording_info(&tuning).map_err(build)?;
    let recorder = Recorder::start(outputs.named_recording(file, "--out")?, &info)?;
    let mut recorder = recorder.for_flight_of(scenario.settings.planned_s());
    let mut watched = Watched::default();
    let report = run::fly_until_signal(scenario, &mut |tick| {
        watched.add(tick);
        if tick.index.is_multiple_of(PROGRESS_TICKS) {
            progress(PROGRESS_TICKS);
        }
        // The end of the recording tells whether it failed.
        let _ = recorder.record(Arc::new(tick.clone()));
    })
    .map_err(build)?;
    let state_hash = u64::from_str_radix(&report.state_hash, 16).unwrap_or_default();
    let verdict = format!("{}: {}", report.verdict, report.reason);
    let written = recorder.finish(RecordingEnd { state_hash, verdict })?;
    let metric = |name: &str| report.metrics.get(name).copied().unwrap_or(f64::NAN);
    Ok(Collected {
        sha256: sha256_of(file)?,
        file: file.clone(),
        scenario: report.scenario.clone(),
        seed: report.seed,
        payload_kg: scenario.settings.payload.mass_kg,
        ticks: written.ticks,
        verdict: report.verdict,
        reason: report.reason.clone(),
        state_hash: report.state_hash.clone(),
        residual: Spread::of(&watched.residuals),
        position_rmse_m: metric("position_rmse_m"),
        tilt_peak_rad: metric("tilt_peak_rad"),
        saturation_share: metric("saturation_share"),
        contact_ticks: watched.contact_ticks,
    })
}

/// Sha-256 of a file, in hex.
///
/// # Errors
/// [`CollectError::Input`] if it cannot be read.
pub fn sha256_of(path: &Path) -> Result<String, CollectError> {
    let failed = |why: InputError| CollectError::Input { path: path.to_owned(), why };
    let mut file = file::open(path).map_err(failed)?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        let read = std::io::Read::read(&mut file, &mut buffer).map_err(|why| failed(why.into()))?;
        if read == 0 {
            break;
        }
        hash.update(&buffer[..read]);
    }
    Ok(hash.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

/// Sums over the ticks of a flight.
#[derive(Default)]
struct Watched {
    residuals: Vec<Coords>,
    contact_ticks: u64,
}

impl Watched {
    /// Adds a tick; the first second belongs to the start and is left out.
    fn add(&mut self, tick: &Tick) {
        if tick.measurement.t_s < 1.0 {
            return;
        }
        self.residuals.push(*tick.residual);
        let touches = tick.truth.as_ref().is_some_and(|truth| truth.collision_force_n > 0.0);
        self.contact_ticks += u64::from(touches);
    }
}

/// Standard deviation of the residual in a control study, over such flights with 0, 200 and 400 g, N and N m. The study used another plant,
/// so only the order of magnitude is comparable.
pub const EXPECTED_STD: [f64; N] = twin_core::residual::NOMINAL_SCALE;

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::elementary::sin;

    #[test]
    fn the_spread_of_parts_is_that_of_the_whole() {
        let value = |i: i32| Coords::from_fn(|row, _| sin(f64::from(i) * 0.37 + row as f64));
        let all: Vec<Coords> = (0..100).map(value).collect();
        let parts = [Spread::of(&all[..30]), Spread::of(&all[30..90]), Spread::of(&all[90..])];
        let (whole, together) = (Spread::of(&all), Spread::together(&parts));
        // Tolerance for a few hundred roundings of numbers near 1.
        assert!((whole.mean - together.mean).norm() < 1e-13);
        assert!((whole.std - together.std).norm() < 1e-13);
        assert!((Spread::of(&[value(3)]).std).norm() == 0.0);
    }
}
