//! Flies a draw, in this process and in the real program, and says how it ended.

use std::cell::RefCell;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::Command;

use twin_core::tick::Tick;
use twin_scenario::{Assessor, Scenario, Verdict};

use super::draw::{Draw, FLIGHT_S};

/// Ticks after which a flight must have its verdict: its time limit, and a few for rounding.
const LAST_TICK: u64 = (FLIGHT_S * 100.0) as u64 + 5;

/// How a draw ended.
#[derive(Debug)]
pub(super) enum Outcome {
    /// It was flown to a verdict.
    Flown(Verdict),
    /// The program refused the scenario, with these words.
    Refused(String),
    /// The program panicked.
    Panicked(String),
    /// A command or a value that the loop acts on was not finite.
    NotFinite(String),
    /// The flight did not end.
    Endless,
    /// The program ended otherwise than the flight in this process.
    Program(String),
}

impl Outcome {
    pub(super) fn is_failure(&self) -> bool {
        !matches!(self, Self::Flown(_) | Self::Refused(_))
    }

    /// Failures of one kind have one cause, so far as this test can tell.
    pub(super) fn kind(&self) -> String {
        match self {
            Self::Panicked(message) => message.split(':').take(3).collect::<Vec<_>>().join(":"),
            Self::NotFinite(_) => "not finite".to_owned(),
            Self::Program(_) => "program".to_owned(),
            other => format!("{:?}", std::mem::discriminant(other)),
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flown(verdict) => write!(f, "flown: {verdict}"),
            Self::Refused(words) => write!(f, "refused: {words}"),
            Self::Panicked(message) => write!(f, "panicked: {message}"),
            Self::NotFinite(what) => write!(f, "{what}"),
            Self::Endless => write!(f, "no verdict after {LAST_TICK} ticks"),
            Self::Program(what) => write!(f, "the program: {what}"),
        }
    }
}

/// A folder for the drawn scenarios. A scenario is removed once its flight has ended, so after an abort the culprits are still there.
pub(super) struct Folder(PathBuf);

impl Folder {
    pub(super) fn new(path: &Path) -> Self {
        // Scenarios of an earlier run that was aborted are of no use any more.
        let _ = std::fs::remove_dir_all(path);
        std::fs::create_dir_all(path).expect("a folder for temporary files");
        Self(path.to_owned())
    }

    fn write(&self, draw: &Draw) -> PathBuf {
        let file = self.0.join(format!("draw_{}.toml", draw.number));
        std::fs::write(&file, draw.toml()).expect("a temporary file");
        file
    }
}

/// Flies `draw` in this process.
pub(super) fn fly(folder: &Folder, draw: &Draw) -> Outcome {
    let file = folder.write(draw);
    let outcome = catch_unwind(AssertUnwindSafe(|| fly_file(&file)));
    // A file that stays does not matter.
    let _ = std::fs::remove_file(&file);
    outcome.unwrap_or_else(|_| Outcome::Panicked(PANIC.take()))
}

thread_local! {
    /// Place and message of the last panic of this thread.
    static PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// A panic hook: keeps place and message for [`Outcome::Panicked`] instead of printing them.
pub(super) fn remember_panic(panic: &std::panic::PanicHookInfo<'_>) {
    PANIC.set(panic.to_string());
}

fn fly_file(file: &Path) -> Outcome {
    let scenario = match Scenario::load(file, &[]) {
        Ok(scenario) => scenario,
        Err(error) => return refused(&error),
    };
    let mut flight = match scenario.build() {
        Ok(flight) => flight,
        Err(error) => return refused(&error),
    };
    if let Err(error) = scenario.recording_info(flight.tuning()) {
        return refused(&error);
    }
    let mut assessor = Assessor::new(&scenario);
    for _ in 0..LAST_TICK {
        let tick = flight.tick();
        if let Some(what) = not_finite(&tick) {
            return Outcome::NotFinite(what);
        }
        if let Some(end) = assessor.add(&tick) {
            let report = assessor.finish(end, flight.state_hash());
            return Outcome::Flown(report.verdict);
        }
    }
    Outcome::Endless
}

/// A refusal; without words it would be a failure.
fn refused(error: &dyn fmt::Display) -> Outcome {
    Outcome::Refused(error.to_string())
}

/// The first value past the guards that is not finite, in words. The true state may be anything: the verdict `non_finite` tells it.
fn not_finite(tick: &Tick) -> Option<String> {
    let measured = &tick.measurement;
    let parts: [(&str, bool); 5] = [
        ("the measurement", measured.chi.is_finite() && measured.chi_dot.is_finite()),
        ("the set-point", tick.setpoint.force_in_world_n.iter().all(|x| x.is_finite())),
        ("the estimate in the set-point", tick.setpoint.r_hat.iter().all(|x| x.is_finite())),
        ("a rotor command", tick.actuators.rotor_thrust_n.iter().all(|x| x.is_finite())),
        ("a joint torque", tick.actuators.joint_torque_n_m.iter().all(|x| x.is_finite())),
    ];
    let broken = parts.iter().find(|(_, finite)| !finite);
    broken.map(|(what, _)| format!("{what} is not finite at tick {}", tick.index))
}

/// Flies `draw` in the real program, whose exit code must fit `outcome`: 0 or 1 after a flight, 2 after a refusal, and never a signal.
pub(super) fn run_program(folder: &Folder, draw: &Draw, outcome: &Outcome) -> Outcome {
    let file = folder.write(draw);
    let output = Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(["fly", "--headless", "--json"])
        .arg(&file)
        .output()
        .expect("the program starts");
    let _ = std::fs::remove_file(&file);
    let code = output.status.code();
    let json = serde_json::from_slice::<serde_json::Value>(&output.stdout).ok();
    let verdict = json.as_ref().and_then(|json| json["verdict"].as_str());
    match (outcome, code) {
        (Outcome::Refused(words), Some(2)) => Outcome::Refused(words.clone()),
        (Outcome::Flown(flown), Some(0 | 1)) if verdict == Some(&flown.to_string()) => {
            Outcome::Flown(*flown)
        }
        _ => Outcome::Program(format!(
            "{outcome}, but exit code {code:?}, verdict {verdict:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        )),
    }
}
