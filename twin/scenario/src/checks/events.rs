//! Checks that an event happens or does not happen, within a time and after another event.

use std::collections::HashSet;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::{CheckError, Violation};
use twin_core::tick::{EventKind, Tick};
use twin_input::work;

/// A demand on the events of a flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventCheck {
    /// Kind of the event.
    pub kind: EventKind,
    /// A text that the sentence of the event must contain; without it any sentence counts.
    pub text: Option<String>,
    /// Whether the event must happen or must not happen.
    #[serde(default)]
    pub must: Expectation,
    /// Start of the time in which the event counts, s; the start of the flight if absent.
    pub from_s: Option<f64>,
    /// End of the time in which the event counts, s; the end of the flight if absent.
    pub by_s: Option<f64>,
    /// Only events after the first event of this kind count …
    pub after: Option<EventKind>,
    /// … whose sentence contains this text.
    pub after_text: Option<String>,
}

/// Whether an event must happen or must not happen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Expectation {
    /// The event must happen at least once.
    #[default]
    Happen,
    /// The event must never happen.
    NotHappen,
}

pub(crate) fn validate(checks: &[EventCheck]) -> Result<(), CheckError> {
    for (index, check) in checks.iter().enumerate() {
        let refuse = |key: &str, reason: &str| {
            Err(CheckError {
                key: format!("expect.events.{index}.{key}"),
                reason: reason.to_owned(),
            })
        };
        if check.after_text.is_some() && check.after.is_none() {
            return refuse("after_text", "found without `after`; name the kind of event too");
        }
        if check.from_s.unwrap_or(0.0) > check.by_s.unwrap_or(f64::INFINITY) {
            return refuse("by_s", "the window ends before it begins");
        }
    }
    Ok(())
}

/// The events so far, and the checks on them.
#[derive(Clone)]
pub(super) struct Events {
    checks: Vec<EventCheck>,
    /// Sentences of the disturbances that must happen, each exactly so.
    begins: Vec<String>,
    seen: Vec<(f64, EventKind, String)>,
}

impl Events {
    pub(super) fn new(checks: &[EventCheck], begins: Vec<String>) -> Self {
        Self { checks: checks.to_vec(), begins, seen: Vec::new() }
    }

    pub(super) fn add(&mut self, tick: &Tick) {
        if !(self.checks.is_empty() && self.begins.is_empty()) {
            let t_s = tick.measurement.t_s;
            self.seen.extend(tick.events.iter().map(|e| (t_s, e.kind, e.text.clone())));
        }
    }

    pub(super) fn finish(&self, last_s: f64) -> Vec<Violation> {
        let broken = self.checks.iter().filter_map(|check| check.broken(&self.seen, last_s));
        broken.chain(self.absent(last_s)).collect()
    }

    /// The disturbances that did not happen. A scenario may have thousands, so they are looked up and not searched.
    fn absent(&self, last_s: f64) -> impl Iterator<Item = Violation> {
        let disturbances = self.seen.iter().filter(|(_, kind, _)| *kind == EventKind::Disturbance);
        let happened: HashSet<&str> = disturbances.map(|(.., text)| text.as_str()).collect();
        work::steps(self.seen.len() + self.begins.len());
        let absent = self.begins.iter().filter(move |text| !happened.contains(text.as_str()));
        absent.filter_map(move |text| {
            let text = Some(text.clone());
            EventCheck { text, ..EventCheck::of(EventKind::Disturbance) }.broken(&[], last_s)
        })
    }
}

impl EventCheck {
    /// A check that an event of this kind happens.
    pub(crate) fn of(kind: EventKind) -> Self {
        Self {
            kind,
            text: None,
            must: Expectation::Happen,
            from_s: None,
            by_s: None,
            after: None,
            after_text: None,
        }
    }

    fn broken(&self, seen: &[(f64, EventKind, String)], last_s: f64) -> Option<Violation> {
        work::steps(seen.len());
        let fits = |wanted: EventKind, part: &Option<String>, event: &(f64, EventKind, String)| {
            event.1 == wanted && part.as_ref().is_none_or(|part| event.2.contains(part))
        };
        let begin = match self.after {
            None => Some(0),
            Some(kind) => seen
                .iter()
                .position(|event| fits(kind, &self.after_text, event))
                .map(|index| index + 1),
        };
        let in_time = |t_s: f64| {
            self.from_s.is_none_or(|from_s| t_s >= from_s)
                && self.by_s.is_none_or(|by_s| t_s <= by_s)
        };
        let of_kind = || seen.iter().filter(|event| fits(self.kind, &self.text, event));
        let hit = begin.and_then(|begin| {
            seen[begin..]
                .iter()
                .find(|event| fits(self.kind, &self.text, event) && in_time(event.0))
        });
        let (found, at_s) = match (self.must, hit) {
            (Expectation::Happen, Some(_)) | (Expectation::NotHappen, None) => return None,
            (Expectation::NotHappen, Some((t_s, _, text))) => (format!("{text:?}"), *t_s),
            (Expectation::Happen, None) => (
                match of_kind().next() {
                    Some((t_s, ..)) => format!("one at {t_s:.2} s only"),
                    None => "none".to_owned(),
                },
                self.by_s.unwrap_or(last_s).min(last_s),
            ),
        };
        let name = word(self.kind);
        let part = self.text.as_ref().map_or_else(String::new, |text| format!(" with {text:?}"));
        Some(Violation {
            what: format!("event {name}{part}"),
            name,
            value: None,
            found,
            allowed: self.allowed(),
            at_s,
        })
    }

    fn allowed(&self) -> String {
        let mut words = match self.must {
            Expectation::Happen => "at least one",
            Expectation::NotHappen => "none",
        }
        .to_owned();
        if let Some(kind) = self.after {
            let part =
                self.after_text.as_ref().map_or_else(String::new, |text| format!(" with {text:?}"));
            let _ = write!(words, " after {}{part}", word(kind));
        }
        if let Some(from_s) = self.from_s {
            let _ = write!(words, " from {from_s} s on");
        }
        if let Some(by_s) = self.by_s {
            let _ = write!(words, " by {by_s} s");
        }
        words
    }
}

/// Name of a kind in a scenario.
fn word(kind: EventKind) -> String {
    format!("{kind:?}").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(kind: EventKind) -> EventCheck {
        EventCheck::of(kind)
    }

    /// A grasp at 1 s, a reset at 2 s, a release at 3 s.
    fn seen() -> Vec<(f64, EventKind, String)> {
        vec![
            (1.0, EventKind::Grasp, "payload gripped".into()),
            (2.0, EventKind::Reset, "covariance reset".into()),
            (3.0, EventKind::Release, "payload put down".into()),
        ]
    }

    fn broken(check: &EventCheck) -> Option<(String, f64)> {
        check.broken(&seen(), 9.0).map(|broken| (broken.to_string(), broken.at_s))
    }

    #[test]
    fn what_must_happen_in_time_and_in_order_is_missed_when_it_does_not() {
        assert_eq!(broken(&check(EventKind::Reset)), None);
        let late = EventCheck { by_s: Some(1.5), ..check(EventKind::Reset) };
        let (text, at_s) = broken(&late).unwrap();
        assert!(text.contains("one at 2.00 s only") && text.contains("by 1.5 s"), "{text}");
        assert!((at_s - 1.5).abs() < f64::EPSILON, "it is missed when its time is over");
        let (text, at_s) = broken(&check(EventKind::Fault)).unwrap();
        assert!(text.contains("found none") && (at_s - 9.0).abs() < f64::EPSILON, "{text}");
        let ordered = |kind, after| EventCheck { after: Some(after), ..check(kind) };
        assert_eq!(broken(&ordered(EventKind::Release, EventKind::Grasp)), None);
        assert!(broken(&ordered(EventKind::Grasp, EventKind::Release)).is_some());
        assert!(broken(&ordered(EventKind::Release, EventKind::Fault)).is_some());
    }

    #[test]
    fn what_must_not_happen_is_told_with_the_second_at_which_it_did() {
        let never = EventCheck { must: Expectation::NotHappen, ..check(EventKind::Reset) };
        let (text, at_s) = broken(&never).unwrap();
        assert!(text.contains("covariance reset") && (at_s - 2.0).abs() < f64::EPSILON, "{text}");
        let other = EventCheck { text: Some("weights".into()), ..never.clone() };
        assert_eq!(broken(&other), None);
        let later = EventCheck { from_s: Some(2.5), ..never };
        assert_eq!(broken(&later), None);
    }
}
