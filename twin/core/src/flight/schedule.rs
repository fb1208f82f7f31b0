//! The scheduled disturbances of a flight: by time, or after a condition was met.
//!
//! In: the ticks of the flight. Out: the disturbances that are due. State: the disturbances to come.

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
    /// Disturbances by time, s; the latest is first.
    timed: Vec<(f64, Disturbance)>,
    waiting: Vec<Trigger>,
}

impl Schedule {
    pub(super) fn new(timed: Vec<(f64, Disturbance)>, waiting: Vec<Trigger>) -> Self {
        let mut schedule = Self { timed, waiting };
        schedule.sort();
        schedule
    }

    /// Removes and returns the next disturbance that is due at `now_s`.
    pub(super) fn next(&mut self, now_s: f64) -> Option<Disturbance> {
        let due = self.timed.last().is_some_and(|(at_s, _)| *at_s <= now_s);
        if due { self.timed.pop().map(|(_, disturbance)| disturbance) } else { None }
    }

    /// Schedules the disturbances of the triggers whose condition `tick` meets.
    pub(super) fn watch(&mut self, tick: &Tick) {
        let now_s = tick.measurement.t_s;
        let met = self.waiting.extract_if(.., |trigger| trigger.when.met(tick));
        let then = met.flat_map(|trigger| trigger.then);
        let before = self.timed.len();
        self.timed.extend(then.map(|(delay_s, disturbance)| (now_s + delay_s, disturbance)));
        if self.timed.len() > before {
            self.sort();
        }
    }

    /// Puts the latest first. Among equal times the first given stays last, from where it is taken first.
    fn sort(&mut self) {
        self.timed.reverse();
        self.timed.sort_by(|a, b| b.0.total_cmp(&a.0));
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
