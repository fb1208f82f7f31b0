//! Decides which changes of gains become events. A dragged slider changes its gain fifty times but makes two events: one at
//! the start of the drag and one where the slider comes to rest.

use std::collections::BTreeMap;

use twin_core::elementary::{log10, powi};
use twin_core::tuning::Tuning;

/// A gain that has not changed for this long has come to rest, ticks.
const REST_TICKS: u64 = 50;

/// After an event a gain makes no event at once for this long, ticks; its later changes wait until it comes to rest.
const QUIET_TICKS: u64 = 100;

/// The recent changes of one gain.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    /// Value at the last event.
    told: f64,
    told_at: u64,
    now: f64,
    changed_at: u64,
}

/// The gains that changed recently, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct GainEvents {
    entries: BTreeMap<String, Entry>,
}

impl GainEvents {
    /// Takes a change of the gain `name` at `tick`; returns the text of the event if one is due at once.
    pub(super) fn change(&mut self, name: &str, [from, to]: [f64; 2], tick: u64) -> Option<String> {
        if let Some(entry) = self.entries.get_mut(name) {
            (entry.now, entry.changed_at) = (to, tick);
            return None;
        }
        let entry = Entry { told: to, told_at: tick, now: to, changed_at: tick };
        self.entries.insert(name.to_owned(), entry);
        Some(sentence(name, from, to))
    }

    /// Texts of the events of all gains that have come to rest before `tick`, each with the first tick that flew with the value; forgets
    /// gains without recent changes.
    pub(super) fn settle(&mut self, tick: u64) -> Vec<String> {
        let mut said = Vec::new();
        for (name, entry) in &mut self.entries {
            let rests = tick.saturating_sub(entry.changed_at) >= REST_TICKS;
            if rests && entry.now.to_bits() != entry.told.to_bits() {
                let since = entry.changed_at;
                said.push(format!("{} since tick {since}", sentence(name, entry.told, entry.now)));
                (entry.told, entry.told_at) = (entry.now, tick);
            }
        }
        self.entries.retain(|_, entry| {
            entry.now.to_bits() != entry.told.to_bits()
                || tick.saturating_sub(entry.told_at) < QUIET_TICKS
        });
        said
    }
}

fn sentence(name: &str, from: f64, to: f64) -> String {
    let parameters = Tuning::parameters();
    let label = parameters.iter().find(|parameter| parameter.name == name);
    let label = label.map_or(name, |parameter| parameter.label.as_str());
    format!("{label} ({name}) {} -> {}", short(from), short(to))
}

/// Rounds to six significant digits.
fn short(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = powi(10_f64, 5 - log10(value.abs()).floor() as i32);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_told_at_its_start_and_where_it_ends() {
        let mut gain_events = GainEvents::default();
        let mut said = Vec::new();
        let value = |step: u64| 3.5 + step as f64 * 0.1;
        for tick in 0..400_u64 {
            if tick.is_multiple_of(2) && tick < 100 {
                let step = tick / 2;
                said.extend(gain_events.change("damping.z", [value(step), value(step + 1)], tick));
            }
            said.extend(gain_events.settle(tick));
        }
        assert_eq!(
            said,
            ["Λ z (damping.z) 3.5 -> 3.6", "Λ z (damping.z) 3.6 -> 8.5 since tick 98"]
        );
        assert_eq!(gain_events, GainEvents::default(), "a gain at rest is forgotten");
    }

    #[test]
    fn two_gains_are_told_apart_and_a_value_that_comes_back_is_told_once() {
        let mut gain_events = GainEvents::default();
        assert!(gain_events.change("leak", [2.0, 3.0], 0).is_some());
        assert!(gain_events.change("forgetting", [0.99, 0.98], 0).is_some());
        assert_eq!(gain_events.change("leak", [3.0, 4.0], 10), None);
        assert_eq!(gain_events.change("leak", [4.0, 3.0], 20), None);
        assert!((20..300).all(|tick| gain_events.settle(tick).is_empty()));
    }
}
