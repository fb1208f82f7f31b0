//! The scheduled disturbances of a flight: by time, or after a condition was met.
//!
//! In: the ticks of the flight. Out: the disturbances that are due. State: the disturbances to come.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::source::Disturbance;
use crate::tick::{EventKind, Tick};

/// Disturbances that start when a condition is first met.
#[derive(Clone, Debug, PartialEq)]
pub struct Trigger {
    /// The condition.
    pub when: Condition,
    /// The disturbances, each with its delay after the condition was met, s.
    pub then: Vec<(f64, Disturbance)>,
}

/// The condition of a trigger: all given parts must hold in one tick.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Condition {
    /// The task is in this phase.
    pub phase: Option<String>,
    /// An event of this kind occurs …
    pub event: Option<EventKind>,
    /// … whose sentence contains this text.
    pub text: Option<String>,
}

impl Condition {
    /// Whether `tick` meets the condition.
    pub fn met(&self, tick: &Tick) -> bool {
        let phase = self.phase.as_ref().is_none_or(|phase| *phase == tick.phase);
        let event = self.event.is_none_or(|kind| {
            let told = |text: &str| self.text.as_ref().is_none_or(|part| text.contains(part));
            tick.events.iter().any(|event| event.kind == kind && told(&event.text))
        });
        phase && event
    }
}

/// The disturbances to come.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    timed: BinaryHeap<Timed>,
    /// Number of disturbances that were scheduled so far.
    scheduled: u64,
    waiting: Vec<Trigger>,
}

/// A disturbance with its time. The earliest is the greatest, and among equal times the one that was scheduled first.
#[derive(Clone, Debug)]
struct Timed {
    at_s: f64,
    number: u64,
    disturbance: Disturbance,
}

impl Ord for Timed {
    fn cmp(&self, other: &Self) -> Ordering {
        other.at_s.total_cmp(&self.at_s).then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Timed {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Timed {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Timed {}

impl Schedule {
    pub(super) fn new(timed: Vec<(f64, Disturbance)>, waiting: Vec<Trigger>) -> Self {
        let mut schedule = Self { timed: BinaryHeap::new(), scheduled: 0, waiting };
        for (at_s, disturbance) in timed {
            schedule.add(at_s, disturbance);
        }
        schedule
    }

    /// Adds disturbances by time, s, and triggers.
    pub(super) fn extend(&mut self, timed: Vec<(f64, Disturbance)>, waiting: Vec<Trigger>) {
        for (at_s, disturbance) in timed {
            self.add(at_s, disturbance);
        }
        self.waiting.extend(waiting);
    }

    /// Removes and returns the next disturbance that is due at `now_s`.
    pub(super) fn next(&mut self, now_s: f64) -> Option<Disturbance> {
        let due = self.timed.peek().is_some_and(|timed| timed.at_s <= now_s);
        if due { self.timed.pop().map(|timed| timed.disturbance) } else { None }
    }

    /// Schedules the disturbances of the triggers whose condition `tick` meets.
    pub(super) fn watch(&mut self, tick: &Tick) {
        let now_s = tick.measurement.t_s;
        let met: Vec<Trigger> =
            self.waiting.extract_if(.., |trigger| trigger.when.met(tick)).collect();
        for (delay_s, disturbance) in met.into_iter().flat_map(|trigger| trigger.then) {
            self.add(now_s + delay_s, disturbance);
        }
    }

    fn add(&mut self, at_s: f64, disturbance: Disturbance) {
        self.timed.push(Timed { at_s, number: self.scheduled, disturbance });
        self.scheduled += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use crate::tick::Event;

    fn mass(kg: f64) -> Disturbance {
        Disturbance::PayloadMass { kg }
    }

    fn due(schedule: &mut Schedule, now_s: f64) -> Vec<Disturbance> {
        std::iter::from_fn(|| schedule.next(now_s)).collect()
    }

    fn tick(phase: &str, events: Vec<Event>) -> Tick {
        Tick { phase: phase.to_owned(), events, ..fixture::tick(0) }
    }

    #[test]
    fn what_is_due_comes_in_the_order_of_time_and_only_once() {
        let mut schedule =
            Schedule::new(vec![(2.0, mass(0.2)), (1.0, mass(0.1)), (1.0, mass(0.15))], Vec::new());
        assert_eq!(due(&mut schedule, 0.5), []);
        assert_eq!(due(&mut schedule, 1.0), [mass(0.1), mass(0.15)]);
        assert_eq!(due(&mut schedule, 9.0), [mass(0.2)]);
        assert_eq!(due(&mut schedule, 9.0), []);
    }

    #[test]
    fn equal_times_keep_their_order_when_a_trigger_adds_one() {
        let when = Condition::default();
        let timed = vec![(2.0, mass(0.1)), (2.0, mass(0.2))];
        let there = tick("lift", Vec::new());
        let then = vec![(2.0 - there.measurement.t_s, mass(0.3))];
        let mut schedule = Schedule::new(timed, vec![Trigger { when, then }]);
        schedule.watch(&there);
        assert_eq!(due(&mut schedule, 2.0), [mass(0.1), mass(0.2), mass(0.3)]);
    }

    #[test]
    fn a_trigger_fires_once_and_everything_of_it_counts_from_there() {
        let when = Condition { phase: Some("transport".to_owned()), ..Condition::default() };
        let then = vec![(0.5, mass(0.4)), (1.5, mass(0.3))];
        let mut schedule = Schedule::new(vec![(1.0, mass(0.1))], vec![Trigger { when, then }]);
        schedule.watch(&tick("lift", Vec::new()));
        assert_eq!(due(&mut schedule, 10.0), [mass(0.1)]);
        let there = tick("transport", Vec::new());
        let t_s = there.measurement.t_s;
        schedule.watch(&there);
        schedule.watch(&there);
        assert_eq!(due(&mut schedule, t_s + 0.4), []);
        assert_eq!(due(&mut schedule, t_s + 0.5), [mass(0.4)]);
        assert_eq!(due(&mut schedule, t_s + 9.0), [mass(0.3)]);
    }

    #[test]
    fn a_condition_wants_all_that_it_names_in_one_tick() {
        let when = Condition {
            phase: Some("lift".to_owned()),
            event: Some(EventKind::Grasp),
            text: Some("gripped".to_owned()),
        };
        let grasp = || vec![Event::new(EventKind::Grasp, "payload gripped")];
        assert!(when.met(&tick("lift", grasp())));
        assert!(!when.met(&tick("transport", grasp())));
        assert!(!when.met(&tick("lift", Vec::new())));
        assert!(!when.met(&tick("lift", vec![Event::new(EventKind::Grasp, "lost")])));
    }
}
