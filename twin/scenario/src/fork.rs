//! Forks of a flight: at an instant the flight is copied whole, some keys change, and the copy flies to its own end.
//!
//! In: a scenario and the forks that are asked for. Out: the reports of the flight and of its forks, and a scenario that repeats each fork
//! from its start. State: the copies, until they have flown.

use serde::Serialize;

use super::differences::{Difference, differences};
use super::judged::{Row, Values, side_by_side};
use super::metrics::Metrics;
use super::run::Run;
use super::settings::{Changed, TaskKind};
use super::{BuildError, Report, Scenario, ScenarioError, Verdict, changes};
use twin_core::flight::Alteration;
use twin_core::notation::TICK_S;
use twin_core::tick::Tick;

/// Forks of one flight at a time.
pub const MOST_FORKS: usize = 6;

/// A fork that is asked for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Order {
    /// Time of the fork, s: it begins with the first tick at or after it.
    pub at_s: f64,
    /// The changed keys, `key=value` each.
    pub set: Vec<String>,
}

/// Why a flight cannot be forked.
#[derive(Debug, thiserror::Error)]
pub enum ForkError {
    /// More forks than allowed.
    #[error("{asked} forks asked for, at most {MOST_FORKS} are flown; drop some")]
    TooMany {
        /// Number of forks that were asked for.
        asked: usize,
    },
    /// The instant is no time of a flight.
    #[error(
        "fork at {at_s} s: a flight begins at 0 s; choose a time from 0 s to the end of the flight"
    )]
    BeforeStart {
        /// Time that was asked for, s.
        at_s: f64,
    },
    /// The flight was over before the instant.
    #[error(
        "fork at {at_s} s: the flight ended at {end_s:.2} s ({verdict}: {reason}); choose an earlier instant"
    )]
    AfterEnd {
        /// Time that was asked for, s.
        at_s: f64,
        /// Time of the last tick, s.
        end_s: f64,
        /// Verdict on the flight.
        verdict: Verdict,
        /// Its reason.
        reason: String,
    },
    /// A changed key is refused.
    #[error("fork at {at_s} s: {reason}")]
    Refused {
        /// Time that was asked for, s.
        at_s: f64,
        /// Why.
        reason: String,
    },
    /// The flight cannot be assembled.
    #[error(transparent)]
    Build(#[from] BuildError),
}

/// A flight and its forks.
#[derive(Debug)]
pub struct Forked {
    /// The flight that was forked.
    pub parent: Report,
    /// The forks in the order in which they were asked for; none if a signal ended the flight.
    pub forks: Vec<Fork>,
}

/// A fork that has flown.
#[derive(Debug)]
pub struct Fork {
    /// The fork as it was asked for.
    pub order: Order,
    /// The keys that differ from those of the flight.
    pub changed: Vec<Difference>,
    /// A scenario that repeats the fork from the start of the flight.
    pub scenario: Scenario,
    /// The report on the whole flight, the part before the fork included.
    pub report: Report,
    /// The metrics from the fork on, beside those of the flight over its own time from there on.
    pub rows: Vec<Row>,
}

/// A fork that is checked and ready to begin.
pub struct Plan {
    order: Order,
    /// A scenario that repeats the fork.
    scenario: Scenario,
    alterations: Vec<(f64, Alteration)>,
    changed: Vec<Difference>,
}

impl Plan {
    /// Checks an order for a flight of `scenario`, and builds what it changes.
    ///
    /// # Errors
    /// [`ForkError`] for an instant before the start, for keys that are refused, and for parts that cannot be built.
    pub fn new(scenario: &Scenario, order: &Order) -> Result<Self, ForkError> {
        let at_s = order.at_s;
        if !(at_s.is_finite() && at_s >= 0.0) {
            return Err(ForkError::BeforeStart { at_s });
        }
        let refused = |error: ScenarioError| ForkError::Refused { at_s, reason: error.to_string() };
        let demanding_nothing = without_demands(scenario);
        let repeats = repeating(&demanding_nothing, order);
        let after = changes::after_each(&repeats).map_err(refused)?;
        let before = changes::after_each(&demanding_nothing).map_err(refused)?;
        let at_fork = |changed: Vec<(f64, Scenario)>| {
            let last = changed.into_iter().take_while(|(time, _)| *time <= at_s).last();
            last.map_or_else(
                || changes::without_changes(&demanding_nothing.settings),
                |(_, s)| s.settings,
            )
        };
        Ok(Self {
            order: order.clone(),
            changed: differences(&at_fork(before), &at_fork(after)),
            alterations: changes::alterations(&repeats)?,
            scenario: repeats,
        })
    }

    /// The alterations of the flight from the fork on, each with its time, s; [`Run::set_alterations`] takes them.
    pub fn alterations(&self) -> &[(f64, Alteration)] {
        &self.alterations
    }

    /// The keys that differ from those of the flight.
    pub fn changed(&self) -> &[Difference] {
        &self.changed
    }

    /// A scenario that repeats the fork from the start of the flight.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Whether the fork begins with the tick `index`.
    fn is_due(&self, index: u64) -> bool {
        index as f64 * TICK_S >= self.order.at_s
    }
}

/// `scenario` without bounds, checks and expected events, which belong to the flight that is forked and say nothing about a fork.
fn without_demands(scenario: &Scenario) -> Scenario {
    let mut free = scenario.clone();
    let settings = &mut free.settings;
    settings.bounds.clear();
    settings.checks.clear();
    settings.golden = None;
    settings.sweep = None;
    settings.expect.fails = None;
    settings.expect.events.clear();
    free
}

/// A scenario that repeats a fork of `parent` from its start.
fn repeating(parent: &Scenario, order: &Order) -> Scenario {
    let mut scenario = parent.clone();
    let changes = &mut scenario.settings.changes;
    let place = changes.partition_point(|change| change.at_s <= order.at_s);
    changes.insert(place, Changed { at_s: order.at_s, set: order.set.clone() });
    scenario
}

impl Forked {
    /// Whether a signal ended one of the flights.
    pub fn was_interrupted(&self) -> bool {
        let forks = self.forks.iter().map(|fork| fork.report.verdict);
        forks.chain([self.parent.verdict]).any(|verdict| verdict == Verdict::Interrupted)
    }
}

/// The plans of forks of `scenario`.
///
/// # Errors
/// [`ForkError`] if there are too many of them, or if one is refused.
pub fn plans(scenario: &Scenario, orders: &[Order]) -> Result<Vec<Plan>, ForkError> {
    if orders.len() > MOST_FORKS {
        return Err(ForkError::TooMany { asked: orders.len() });
    }
    orders.iter().map(|order| Plan::new(scenario, order)).collect()
}

/// Flies `scenario` to its end and then each fork of it. `watch` receives every tick with the numbers of the flights that have it: 0 is the
/// flight itself, 1 the first fork. A fork has the ticks of the flight before it.
///
/// # Errors
/// [`ForkError`] if the flight cannot be assembled, or if it is over before a fork; then no fork is flown.
pub fn fly_forked(
    scenario: &Scenario,
    plans: Vec<Plan>,
    watch: &mut dyn FnMut(&[usize], &Tick),
) -> Result<Forked, ForkError> {
    let mut run = Run::new(scenario)?;
    let mut waiting: Vec<(usize, Plan)> = (1..).zip(plans).collect();
    let mut begun: Vec<Begun> = Vec::new();
    let end = loop {
        for (number, plan) in waiting.extract_if(.., |(_, plan)| plan.is_due(run.index())) {
            begun.push(Begun { number, plan, run: run.clone(), parent: Metrics::default() });
        }
        let (tick, end) = run.tick();
        for begun in &mut begun {
            begun.parent.add(&tick);
        }
        let flights: Vec<usize> =
            std::iter::once(0).chain(waiting.iter().map(|(number, _)| *number)).collect();
        watch(&flights, &tick);
        if let Some(end) = end {
            break end;
        }
    };
    let mut forked = Forked { parent: run.finish(end), forks: Vec::new() };
    if forked.was_interrupted() {
        return Ok(forked);
    }
    if let Some((_, plan)) = waiting.first() {
        let Report { verdict, reason, flight_s: end_s, .. } = forked.parent;
        return Err(ForkError::AfterEnd { at_s: plan.order.at_s, end_s, verdict, reason });
    }
    begun.sort_by_key(|begun| begun.number);
    for begun in begun {
        let number = begun.number;
        forked.forks.push(begun.fly(&mut |tick| watch(&[number], tick)));
        if forked.was_interrupted() {
            break;
        }
    }
    Ok(forked)
}

/// The copy of a flight at a fork, and the metrics of the original from there on.
struct Begun {
    number: usize,
    plan: Plan,
    run: Run,
    parent: Metrics,
}

impl Begun {
    /// Flies the fork to its end.
    fn fly(self, watch: &mut dyn FnMut(&Tick)) -> Fork {
        let Self { plan, mut run, parent, .. } = self;
        let Plan { order, mut scenario, alterations, changed } = plan;
        run.set_alterations(alterations);
        let mut since = Metrics::default();
        let end = loop {
            let (tick, end) = run.tick();
            since.add(&tick);
            watch(&tick);
            if let Some(end) = end {
                break end;
            }
        };
        let report = run.finish(end);
        let settings = &mut scenario.settings;
        settings.title = format!("{}, forked at {} s", settings.title, order.at_s);
        settings.expect.verdict = report.verdict;
        let task = &scenario.settings.task;
        let place = (task.kind == TaskKind::PickPlace).then(|| task.place_position_m.into());
        let [parent, since]: [Values; 2] = [parent, since].map(|metrics| metrics.finish(place));
        Fork { rows: side_by_side(&parent, &since), order, changed, scenario, report }
    }
}
