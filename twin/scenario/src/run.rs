//! Flies one scenario to its end without a viewer.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::checks::{Checks, Violation, range};
use super::golden::GoldenCheck;
use super::metrics::Metrics;
use super::settings::{Settings, TaskKind};
use super::{BuildError, Judge, Scenario, Verdict, demands};
use twin_core::flight::{Alteration, Flight};
use twin_core::residual::PredictorInfo;
use twin_core::tick::{Event, Tick};
use twin_input::interruption::{self, Interrupted};

/// The result of a flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed.
    pub seed: u64,
    /// The verdict on the flight.
    pub verdict: Verdict,
    /// The reason of the verdict, in a sentence.
    pub reason: String,
    /// Simulated duration, s.
    pub flight_s: f64,
    /// Simulated time per wall-clock time; a caller with a clock fills it in.
    pub real_time_factor: Option<f64>,
    /// Hash of the state, equal for equal flights.
    pub state_hash: String,
    /// Arithmetic of the predictor's network. Two flights are equal only if this is equal too.
    #[serde(default)]
    pub kernel: String,
    /// Metrics by name; an unknown metric is NaN, and `null` in JSON.
    #[serde(deserialize_with = "numbers")]
    pub metrics: BTreeMap<String, f64>,
    /// The demands of the scenario that the flight did not meet.
    pub broken: Vec<Violation>,
    /// True if no demand is broken; if the scenario declares a failure, true if that demand is broken.
    pub passed: bool,
}

/// Reads numbers in which `null` stands for NaN, because JSON has no NaN.
fn numbers<'de, D: serde::Deserializer<'de>>(from: D) -> Result<BTreeMap<String, f64>, D::Error> {
    let read = BTreeMap::<String, Option<f64>>::deserialize(from)?;
    Ok(read.into_iter().map(|(name, value)| (name, value.unwrap_or(f64::NAN))).collect())
}

/// Flies `scenario` to its end; `watch` receives every tick.
///
/// # Errors
/// [`BuildError`] if the flight cannot be assembled, or if a signal asks the program to end before the flight is over.
pub fn fly(scenario: &Scenario, watch: &mut dyn FnMut(&Tick)) -> Result<Report, BuildError> {
    let report = fly_until_signal(scenario, watch)?;
    if report.verdict == Verdict::Interrupted {
        interruption::check()?;
    }
    Ok(report)
}

/// Flies `scenario` to its end, or until a signal asks the program to end; such a flight has the verdict
/// [`Verdict::Interrupted`]. `watch` receives every tick.
///
/// # Errors
/// [`BuildError`] if the flight cannot be assembled.
pub fn fly_until_signal(
    scenario: &Scenario,
    watch: &mut dyn FnMut(&Tick),
) -> Result<Report, BuildError> {
    let mut run = Run::new(scenario)?;
    loop {
        let (tick, end) = run.tick();
        watch(&tick);
        if let Some(end) = end {
            return Ok(run.finish(end));
        }
    }
}

/// A flight with its assessment. A copy of it goes on by itself.
#[derive(Clone)]
pub struct Run {
    flight: Flight,
    assessor: Assessor,
}

impl Run {
    /// The flight of `scenario` before its first tick.
    ///
    /// # Errors
    /// [`BuildError`] if the flight cannot be assembled.
    pub fn new(scenario: &Scenario) -> Result<Self, BuildError> {
        Ok(Self { flight: scenario.build()?, assessor: Assessor::new(scenario) })
    }

    /// Number of the next tick.
    pub fn index(&self) -> u64 {
        self.flight.index()
    }

    /// Flies a tick; the second result is the verdict and its sentence once the flight is over, or once a signal asks the program to end.
    pub fn tick(&mut self) -> (Tick, Option<(Verdict, String)>) {
        let tick = self.flight.tick();
        let end = self.assessor.add(&tick).or_else(|| interrupted(&tick));
        (tick, end)
    }

    /// Replaces the alterations to come, see [`Flight::set_alterations`].
    pub fn set_alterations(&mut self, all: Vec<(f64, Alteration)>) {
        self.flight.set_alterations(all);
    }

    /// The report on the flight, which ended with this verdict and sentence.
    pub fn finish(self, end: (Verdict, String)) -> Report {
        let kernel = self.flight.predictor().info().kernel;
        Report { kernel, ..self.assessor.finish(end, self.flight.state_hash()) }
    }
}

/// The verdict on a flight that a signal ended at `tick`; `None` if there was no signal.
fn interrupted(tick: &Tick) -> Option<(Verdict, String)> {
    let Interrupted(signal) = interruption::check().err()?;
    Some((Verdict::Interrupted, format!("{signal} at {:.2} s", tick.measurement.t_s)))
}

/// Assesses a flight tick by tick and reports the result at its end.
#[derive(Clone)]
pub struct Assessor {
    scenario: String,
    settings: Settings,
    judge: Judge,
    metrics: Metrics,
    checks: Checks,
    golden: Option<GoldenCheck>,
    flight_s: f64,
}

impl Assessor {
    /// An assessor for a flight of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        let settings = scenario.settings.clone();
        Self {
            scenario: scenario.name.clone(),
            judge: Judge::new(&settings),
            metrics: Metrics::default(),
            checks: Checks::new(
                &settings.checks,
                &settings.expect.events,
                demands::begins(&settings),
            ),
            golden: settings
                .golden
                .as_ref()
                .map(|golden| GoldenCheck::new(golden, scenario.folder())),
            flight_s: 0.0,
            settings,
        }
    }

    /// Adds a tick; returns the verdict and its sentence once the flight is over.
    pub fn add(&mut self, tick: &Tick) -> Option<(Verdict, String)> {
        self.metrics.add(tick);
        self.checks.add(tick);
        if let Some(golden) = &mut self.golden {
            golden.add(tick);
        }
        self.flight_s = tick.measurement.t_s;
        self.judge.watch(tick)
    }

    /// The report of a flight that ended with this verdict and sentence; `hash` is its state hash.
    pub fn finish(self, (verdict, reason): (Verdict, String), hash: u64) -> Report {
        let Self { scenario, settings, metrics, checks, golden, flight_s, .. } = self;
        let places = settings.task.kind == TaskKind::PickPlace;
        let metrics = metrics.finish(places.then(|| settings.task.place_position_m.into()));
        let mut broken: Vec<Violation> =
            unexpected(settings.expect.verdict, verdict, &reason, flight_s).into_iter().collect();
        broken.extend(checks.finish());
        broken.extend(golden.and_then(GoldenCheck::finish));
        broken.extend(broken_bounds(&settings, &metrics, flight_s));
        // The demand that broke first is closest to the cause.
        broken.sort_by(|one, other| one.at_s.total_cmp(&other.at_s));
        let passed = match &settings.expect.fails {
            None => broken.is_empty(),
            Some(name) => broken.iter().any(|broken| broken.name == *name),
        };
        Report {
            scenario,
            seed: settings.seed,
            verdict,
            reason,
            flight_s,
            real_time_factor: None,
            state_hash: format!("{hash:016x}"),
            kernel: PredictorInfo::default().kernel,
            metrics,
            broken,
            passed,
        }
    }
}

fn unexpected(expected: Verdict, found: Verdict, reason: &str, at_s: f64) -> Option<Violation> {
    (found != expected).then(|| Violation {
        name: "verdict".to_owned(),
        what: "verdict".to_owned(),
        value: None,
        found: format!("{found} ({reason})"),
        allowed: expected.to_string(),
        at_s,
    })
}

/// Checks the bounds on metrics. Metrics are known only at the end of the flight, so the bounds break then.
fn broken_bounds(
    settings: &Settings,
    metrics: &BTreeMap<String, f64>,
    flight_s: f64,
) -> Vec<Violation> {
    let mut all = Vec::new();
    for (name, bound) in &settings.bounds {
        let value = metrics.get(name).copied();
        let kept = value.is_some_and(|value| {
            bound.min.is_none_or(|min| value >= min) && bound.max.is_none_or(|max| value <= max)
        });
        if !kept {
            let known = || metrics.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            all.push(Violation {
                name: name.clone(),
                what: format!("bounds.{name}"),
                value,
                found: value.map_or_else(
                    || format!("the flight has no such metric, it has {}", known()),
                    |value| format!("{value:.4}"),
                ),
                allowed: range(bound.min, bound.max),
                at_s: flight_s,
            });
        }
    }
    all
}

/// The events of a tick with their time, one line each.
pub fn event_lines(tick: &Tick) -> impl Iterator<Item = String> + '_ {
    tick.events
        .iter()
        .map(|Event { kind, text }| format!("{:8.2} s  {kind:?}: {text}", tick.measurement.t_s))
}
