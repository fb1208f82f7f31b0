//! One flight to its end, headless.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::metrics::Metrics;
use super::settings::TaskKind;
use super::{BuildError, Judge, Scenario, Verdict};
use crate::tick::{Event, Tick};

/// What a flight came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Scenario.
    pub scenario: String,
    /// Seed.
    pub seed: u64,
    /// How it ended.
    pub verdict: Verdict,
    /// Why, in a sentence.
    pub reason: String,
    /// Simulated duration, s.
    pub flight_s: f64,
    /// Simulated time per wall-clock time; filled in by whoever holds a clock.
    pub real_time_factor: Option<f64>,
    /// Equal for equal flights.
    pub state_hash: String,
    /// Metrics by name.
    pub metrics: BTreeMap<String, f64>,
    /// Bounds of the scenario that do not hold, a sentence each.
    pub broken_bounds: Vec<String>,
    /// The verdict is the expected one and every bound holds.
    pub passed: bool,
}

/// Flies `scenario` to its end; `watch` sees every tick.
///
/// # Errors
/// [`BuildError`] if the flight cannot be put together.
pub fn fly(scenario: &Scenario, watch: &mut dyn FnMut(&Tick)) -> Result<Report, BuildError> {
    let mut flight = scenario.build()?;
    let mut judge = Judge::new(&scenario.settings);
    let mut metrics = Metrics::default();
    loop {
        let tick = flight.tick();
        metrics.add(&tick);
        watch(&tick);
        if let Some((verdict, reason)) = judge.watch(&tick) {
            return Ok(report(
                scenario,
                metrics,
                verdict,
                reason,
                tick.measurement.t_s,
                flight.state_hash(),
            ));
        }
    }
}

fn report(
    scenario: &Scenario,
    metrics: Metrics,
    verdict: Verdict,
    reason: String,
    flight_s: f64,
    hash: u64,
) -> Report {
    let settings = &scenario.settings;
    let places = settings.task.kind == TaskKind::PickPlace;
    let metrics = metrics.finish(places.then(|| settings.task.place_position_m.into()));
    let broken_bounds = broken_bounds(settings, &metrics);
    Report {
        scenario: scenario.name.clone(),
        seed: settings.seed,
        passed: verdict == settings.expect.verdict && broken_bounds.is_empty(),
        verdict,
        reason,
        flight_s,
        real_time_factor: None,
        state_hash: format!("{hash:016x}"),
        metrics,
        broken_bounds,
    }
}

fn broken_bounds(settings: &super::Settings, metrics: &BTreeMap<String, f64>) -> Vec<String> {
    let check = |(name, bound): (&String, &super::settings::Bound)| {
        let Some(value) = metrics.get(name) else {
            let known = metrics.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            return Some(format!("bounds.{name}: the flight has no such metric; it has {known}"));
        };
        let low = bound.min.is_some_and(|min| *value < min);
        let high = bound.max.is_some_and(|max| *value > max);
        (low || high).then(|| {
            let text =
                |limit: Option<f64>| limit.map_or_else(|| "..".to_owned(), |v| format!("{v}"));
            format!("{name} is {value:.4}, allowed {} to {}", text(bound.min), text(bound.max))
        })
    };
    settings.bounds.iter().filter_map(check).collect()
}

/// The events of a tick with their time, one line each.
pub fn event_lines(tick: &Tick) -> impl Iterator<Item = String> + '_ {
    tick.events
        .iter()
        .map(|Event { kind, text }| format!("{:8.2} s  {kind:?}: {text}", tick.measurement.t_s))
}
