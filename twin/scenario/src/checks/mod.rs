//! The checks of a scenario on its flight, tick by tick: signals within limits over a window, and events that happen or do not
//! happen.
//!
//! In: the `[[checks]]` and `[[expect.events]]` of a scenario, then every [`Tick`]. Out: the broken checks, each with the second
//! from which it could no longer be met. State: the samples of each window and the events so far.

mod signals;
mod statistic;
mod events;

use std::fmt::Write;

use serde::{Deserialize, Serialize};

pub use events::EventCheck;
pub(super) use events::validate as validate_events;
pub use signals::{ReadSignal, find as reader, limited_signal, names as signal_names};
pub use statistic::Statistic;

use events::Events;
use twin_core::tick::Tick;

/// Limits on a statistic of one signal over the ticks of a window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Name of the signal; [`signal_names`] lists all names.
    pub signal: String,
    /// The statistic that is limited.
    #[serde(default)]
    pub statistic: Statistic,
    /// The quantile, 0 to 1, if the statistic is `quantile`.
    pub quantile: Option<f64>,
    /// Phase of the task whose ticks count; all phases if absent.
    pub phase: Option<String>,
    /// Start of the window, s; the start of the flight if absent.
    pub from_s: Option<f64>,
    /// End of the window, s; the end of the flight if absent.
    pub to_s: Option<f64>,
    /// Largest allowed value.
    pub max: Option<f64>,
    /// Smallest allowed value.
    pub min: Option<f64>,
}

/// A demand of a scenario that its flight did not meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Violation {
    /// Name of the metric or signal, `verdict`, the kind of an event, or `state_hash`.
    pub name: String,
    /// The demand in words, with its statistic and window.
    pub what: String,
    /// The value that was found, if it is a number.
    pub value: Option<f64>,
    /// The value that was found, in words.
    pub found: String,
    /// The allowed values, in words.
    pub allowed: String,
    /// Second of the flight from which the demand could no longer be met.
    pub at_s: f64,
}

impl std::fmt::Display for Violation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { what, found, allowed, at_s, .. } = self;
        write!(f, "{what}: found {found}, allowed {allowed}, broken at {at_s:.2} s")
    }
}

/// A check that cannot be used as it is written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{reason}")]
pub struct CheckError {
    /// Dotted key of the check.
    pub key: String,
    /// The value that was found, and the allowed values.
    pub reason: String,
}

/// Refuses checks that could never be judged or could never fail.
///
/// # Errors
/// [`CheckError`] for an unknown signal, a missing or unused quantile, a missing limit, or limits or a window in the wrong order.
pub(super) fn validate(checks: &[Check]) -> Result<(), CheckError> {
    for (index, check) in checks.iter().enumerate() {
        let refuse = |key: &str, reason: String| {
            Err(CheckError { key: format!("checks.{index}.{key}"), reason })
        };
        if signals::find(&check.signal).is_none() {
            let allowed = signal_names().collect::<Vec<_>>().join(", ");
            return refuse(
                "signal",
                format!("found {:?}, expected one of {allowed}", check.signal),
            );
        }
        let wants = check.statistic == Statistic::Quantile;
        if wants != check.quantile.is_some() {
            let reason =
                "statistic = \"quantile\" needs it, 0.0..=1.0, and no other statistic takes it";
            return refuse("quantile", reason.to_owned());
        }
        if check.max.is_none() && check.min.is_none() {
            return refuse("max", "neither max nor min is given, so the check cannot fail".into());
        }
        if let (Some(min), Some(max)) = (check.min, check.max)
            && min > max
        {
            return refuse("min", format!("found {min}, which is above max = {max}"));
        }
        if check.from_s.unwrap_or(0.0) > check.to_s.unwrap_or(f64::INFINITY) {
            return refuse("to_s", "the window ends before it begins".into());
        }
    }
    Ok(())
}

/// The state of the checks of one flight.
#[derive(Clone)]
pub struct Checks {
    windows: Vec<Window>,
    events: Events,
    last_s: f64,
}

#[derive(Clone)]
struct Window {
    check: Check,
    read: ReadSignal,
    /// Samples as `(t_s, value)`: time in s, value in the unit of the signal.
    samples: Vec<(f64, f64)>,
}

impl Checks {
    /// The state of these checks at the start of a flight; a check of an unknown signal is skipped. `begins` are the sentences of the
    /// disturbances that must happen, each exactly so.
    pub fn new(checks: &[Check], events: &[EventCheck], begins: Vec<String>) -> Self {
        let window = |check: &Check| {
            let read = signals::find(&check.signal)?;
            Some(Window { check: check.clone(), read, samples: Vec::new() })
        };
        Self {
            windows: checks.iter().filter_map(window).collect(),
            events: Events::new(events, begins),
            last_s: 0.0,
        }
    }

    /// Adds a tick.
    pub fn add(&mut self, tick: &Tick) {
        let t_s = tick.measurement.t_s;
        self.last_s = t_s;
        self.events.add(tick);
        for window in &mut self.windows {
            let check = &window.check;
            let inside = check.from_s.is_none_or(|from_s| t_s >= from_s)
                && check.to_s.is_none_or(|to_s| t_s <= to_s)
                && check.phase.as_ref().is_none_or(|phase| *phase == tick.phase);
            if inside && let Some(value) = (window.read)(tick) {
                window.samples.push((t_s, value));
            }
        }
    }

    /// The broken checks in the order of the scenario: first `checks`, then `events`.
    pub fn finish(self) -> Vec<Violation> {
        let last_s = self.last_s;
        let mut broken: Vec<Violation> =
            self.windows.iter().filter_map(|window| window.broken(last_s)).collect();
        broken.extend(self.events.finish(last_s));
        broken
    }
}

/// The value of a signal at a tick; `None` if the tick has no value or the signal is unknown.
pub(super) fn signal(name: &str, tick: &Tick) -> Option<f64> {
    signals::find(name).and_then(|read| read(tick))
}

impl Window {
    fn broken(&self, last_s: f64) -> Option<Violation> {
        let Check { statistic, quantile, min, max, .. } = &self.check;
        let quantile = quantile.unwrap_or(1.0);
        let found = statistic.value(&self.samples, quantile);
        let breach = match found {
            // A window without a tick proves nothing, so the check counts as broken.
            None => Some(last_s),
            Some(_) => statistic.breach(&self.samples, quantile, *min, *max),
        };
        breach.map(|at_s| Violation {
            name: self.check.signal.clone(),
            what: self.check.words(),
            value: found,
            found: found.map_or_else(|| "no tick in the window".to_owned(), |v| format!("{v:.4}")),
            allowed: range(*min, *max),
            at_s,
        })
    }
}

impl Check {
    fn words(&self) -> String {
        let mut words = match self.quantile {
            Some(q) => format!("quantile {q} of {}", self.signal),
            None => format!("{} of {}", self.statistic.word(), self.signal),
        };
        if let Some(phase) = &self.phase {
            let _ = write!(words, " in phase {phase}");
        }
        match (self.from_s, self.to_s) {
            (None, None) => {}
            (from_s, None) => {
                let _ = write!(words, " from {} s on", from_s.unwrap_or(0.0));
            }
            (from_s, Some(to_s)) => {
                let _ = write!(words, " over {}..{to_s} s", from_s.unwrap_or(0.0));
            }
        }
        words
    }
}

/// The range from `min` to `max` in words.
pub(super) fn range(min: Option<f64>, max: Option<f64>) -> String {
    match (min, max) {
        (Some(min), Some(max)) => format!("{min} to {max}"),
        (Some(min), None) => format!("at least {min}"),
        (None, Some(max)) => format!("at most {max}"),
        (None, None) => "anything".to_owned(),
    }
}
