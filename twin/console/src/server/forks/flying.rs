//! The thread that flies forks, one after the other.
//!
//! It waits while the flight thread computes a tick, so it takes only what that thread leaves of the machine.

use std::sync::Arc;
use std::sync::mpsc::Receiver;

use super::Moment;
use crate::server::channels::{Channels, RowSource};
use crate::server::hub::Hub;
use crate::server::protocol::{
    ForkChange, ForkInfo, ForkMetric, ForkOutcome, ForkState, ServerMessage,
};
use twin_core::flight::snapshots::{Moment as _, Way};
use twin_core::notation::TICK_S;
use twin_scenario::fork::{Order, Plan};
use twin_scenario::metrics::Metrics;
use twin_scenario::settings::TaskKind;
use twin_scenario::{Row, Scenario, Values, metrics_side_by_side};

/// Ticks that a fork flies at most, one minute: its rows then take 6 MB.
const MOST_TICKS: usize = 6000;

/// Ticks between two messages about a fork that flies.
const TOLD_TICKS: usize = 250;

/// Ticks between two decompositions of the covariance, as in the flight itself.
const SPECTRUM_TICKS: u64 = 10;

/// A fork to fly.
pub(super) struct Job {
    /// Its identifier in the list.
    pub id: u32,
    /// The way to the moment of the fork.
    pub way: Way<Moment>,
    /// Changed keys, `key=value` each.
    pub set: Vec<String>,
    /// The scenario of the flight.
    pub scenario: Scenario,
    /// The channels of the flight.
    pub channels: Arc<Channels>,
}

/// Flies the forks that arrive until the flight thread ends.
pub(super) fn fly_all(jobs: &Receiver<Job>, hub: &Hub) {
    for job in jobs {
        let id = job.id;
        if let Err(reason) = fly(job, hub) {
            let outcome = ForkOutcome { verdict: "refused".to_owned(), reason };
            tell(hub, id, &mut Vec::new(), |info| {
                info.state = ForkState::Failed;
                info.outcome = Some(outcome);
            });
        }
    }
}

/// Updates a fork and tells all clients; false if it was dropped.
fn tell(
    hub: &Hub,
    id: u32,
    rows: &mut Vec<Arc<[f32]>>,
    change: impl FnOnce(&mut ForkInfo),
) -> bool {
    let kept = hub.forks.update(id, rows, change);
    hub.publish(|_| vec![ServerMessage::Forks { forks: hub.forks.infos() }]);
    kept
}

/// Flies a fork and then the flight as it would have gone on, and compares them.
fn fly(job: Job, hub: &Hub) -> Result<(), String> {
    let Job { id, way, set, scenario, channels } = job;
    hub.wait_for_tick();
    let moment = way.fly();
    let at_s = moment.flight().index() as f64 * TICK_S;
    let now = moment.in_force(&scenario);
    let plan = Plan::new(&now, &Order { at_s, set }).map_err(|error| error.to_string())?;
    let changed: Vec<ForkChange> = plan.changed().iter().map(ForkChange::from).collect();
    let mut fork = moment.clone();
    fork.flight_mut().set_alterations(plan.alterations().to_vec());
    let kept = tell(hub, id, &mut Vec::new(), |info| {
        info.state = ForkState::Flying;
        info.changed = changed;
    });
    if !kept {
        return Ok(());
    }
    let Some((forked, outcome)) = ahead(fork, hub, Some((id, &channels))) else { return Ok(()) };
    let Some((unchanged, _)) = ahead(moment, hub, None) else { return Ok(()) };
    let task = &scenario.settings.task;
    let place = (task.kind == TaskKind::PickPlace).then(|| task.place_position_m.into());
    let [parent, forked]: [Values; 2] = [unchanged, forked].map(|metrics| metrics.finish(place));
    let rows = metrics_side_by_side(&parent, &forked);
    tell(hub, id, &mut Vec::new(), |info| {
        info.state = ForkState::Flown;
        info.outcome = outcome;
        info.metrics = rows.iter().map(ForkMetric::from).collect();
    });
    Ok(())
}

/// Flies to the verdict or for [`MOST_TICKS`]; the rows go to the fork `shown`. `None` if it was dropped.
fn ahead(
    mut moment: Moment,
    hub: &Hub,
    shown: Option<(u32, &Channels)>,
) -> Option<(Metrics, Option<ForkOutcome>)> {
    let mut metrics = Metrics::default();
    let (mut rows, mut spectrum) = (Vec::new(), Vec::new());
    for flown in 1..=MOST_TICKS {
        hub.wait_for_tick();
        let (tick, end) = moment.fly();
        metrics.add(&tick);
        if let Some((id, channels)) = shown {
            if tick.index.is_multiple_of(SPECTRUM_TICKS) || tick.adapted.reset {
                spectrum = moment.spectrum();
            }
            let tuning = moment.flight().tuning();
            rows.push(channels.row(&RowSource { tick: &tick, tuning, spectrum: &spectrum }));
            let due = end.is_some() || flown.is_multiple_of(TOLD_TICKS) || flown == MOST_TICKS;
            let t_s = tick.measurement.t_s;
            if due && !tell(hub, id, &mut rows, |info| info.flown_s = t_s) {
                return None;
            }
        }
        if let Some((verdict, reason)) = end {
            return Some((metrics, Some(ForkOutcome { verdict: verdict.to_string(), reason })));
        }
    }
    Some((metrics, None))
}

impl From<&Row> for ForkMetric {
    fn from(row: &Row) -> Self {
        Self {
            metric: row.metric.clone(),
            value: row.value,
            parent: row.parent,
            difference: row.difference,
            judgement: row.judgement.word().to_owned(),
        }
    }
}

impl From<&twin_scenario::differences::Difference> for ForkChange {
    fn from(difference: &twin_scenario::differences::Difference) -> Self {
        let twin_scenario::differences::Difference { key, from, to } = difference.clone();
        Self { key, from, to }
    }
}
