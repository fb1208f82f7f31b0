//! The only place that changes the values in force of a served flight.
//!
//! A change is checked on arrival ([`check`]) and waits for the end of the tick. Then it is applied, noted in the flight (and so recorded)
//! and echoed with the first tick that uses it. Of several changes of one gain the last one counts.

use crate::server::gain_events::GainEvents;
use crate::server::protocol::{GainEcho, GainInfo, GainList, PresetName};
use twin_core::flight::Flight;
use twin_core::quantity::Quantity;
use twin_core::tick::{Event, EventKind};
use twin_core::tuning::{Tuning, TuningError};
use twin_scenario::{Preset, Scenario};

const PRESETS: [(Preset, PresetName, &str); 3] = [
    (Preset::Literal, PresetName::Literal, "literal"),
    (Preset::Paper, PresetName::Paper, "paper"),
    (Preset::Tuned, PresetName::Tuned, "tuned"),
];

/// Largest number of gains whose changes between two ticks are reported by name.
const MOST_SENTENCES: usize = 3;

/// A gain whose name and value were checked; only [`check`] makes one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CheckedGain {
    name: String,
    value: f64,
}

impl CheckedGain {
    /// Name of the gain.
    pub(super) fn name(&self) -> &str {
        &self.name
    }
}

/// A change that is applied at the end of the tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Change {
    /// One gain.
    Gain(CheckedGain),
    /// All gains.
    Preset(Preset),
}

/// Changes that took effect.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Applied {
    /// One echo for every gain that was set or that a preset changed.
    pub echoes: Vec<GainEcho>,
    /// The list of all gains if a preset was applied, because their preset values are new.
    pub list: Option<GainList>,
}

/// Checks the name and the value of a gain by trying it on a copy of `tuning`.
///
/// # Errors
/// [`TuningError`] for an unknown name and for a value that is not finite or out of range.
pub(super) fn check(tuning: &Tuning, name: String, value: f64) -> Result<CheckedGain, TuningError> {
    let mut copy = *tuning;
    copy.set(&name, value)?;
    Ok(CheckedGain { name, value })
}

/// The preset with this name; `None` for `custom`.
pub(super) fn preset(name: PresetName) -> Option<Preset> {
    PRESETS.iter().find(|(_, known, _)| *known == name).map(|(preset, ..)| *preset)
}

/// The presets of a flight, the preset chosen last, and the events about changes.
pub(super) struct GainPresets {
    presets: [Tuning; PRESETS.len()],
    chosen: usize,
    gain_events: GainEvents,
}

impl GainPresets {
    /// The presets of a flight that starts with `tuning`.
    pub(super) fn new(scenario: &Scenario, tuning: &Tuning) -> Self {
        let presets = PRESETS.map(|(preset, ..)| within_ranges(&scenario.preset_tuning(preset)));
        let tuning = within_ranges(tuning);
        let differences = |preset: &Tuning| changed(preset, &tuning).count();
        let nearest = (0..presets.len()).min_by_key(|&index| differences(&presets[index]));
        Self { presets, chosen: nearest.unwrap_or_default(), gain_events: GainEvents::default() }
    }

    /// The preset chosen last.
    pub(super) fn base(&self) -> PresetName {
        PRESETS[self.chosen].1
    }

    /// Notes an event for every gain whose slider was at rest before `next_tick`.
    pub(super) fn settle(&mut self, flight: &mut Flight, next_tick: u64) {
        for text in self.gain_events.settle(next_tick) {
            flight.note(Event::new(EventKind::Gain, text));
        }
    }

    /// Every gain with its value in force.
    pub(super) fn list(&self, tuning: &Tuning) -> Vec<GainInfo> {
        let tuning = within_ranges(tuning);
        Tuning::parameters()
            .into_iter()
            .map(|parameter| GainInfo {
                value: shown(&tuning, &parameter.name),
                preset_value: shown(&self.presets[self.chosen], &parameter.name),
                name: parameter.name,
                label: parameter.label,
                group: parameter.group.to_owned(),
                unit: parameter.quantity.unit.to_owned(),
                help: parameter.quantity.help.to_owned(),
                min: parameter.quantity.min,
                max: parameter.quantity.max,
                step: parameter.quantity.step,
            })
            .collect()
    }

    /// The preset with the same values; `Custom` if none has them.
    pub(super) fn preset(&self, tuning: &Tuning) -> PresetName {
        let tuning = within_ranges(tuning);
        let same = self.presets.iter().position(|preset| *preset == tuning);
        same.map_or(PresetName::Custom, |index| PRESETS[index].1)
    }

    /// Applies the changes that arrived since the last tick, in their order of arrival.
    pub(super) fn apply(
        &mut self,
        flight: &mut Flight,
        changes: Vec<Change>,
        next_tick: u64,
    ) -> Applied {
        let before = *flight.tuning();
        let mut tuning = before;
        let (mut named, mut preset_applied) = (Vec::new(), false);
        for change in changes {
            match change {
                Change::Gain(CheckedGain { name, value }) => {
                    // `set` was already checked on arrival; if it fails now, nothing is changed.
                    if tuning.set(&name, value).is_ok() && !named.contains(&name) {
                        named.push(name);
                    }
                }
                Change::Preset(preset) => {
                    named.extend(self.choose(preset, &mut tuning));
                    preset_applied = true;
                }
            }
        }
        flight.set_tuning(tuning);
        for text in self.sentences([&before, &tuning], &named, preset_applied, next_tick) {
            flight.note(Event::new(EventKind::Gain, text));
        }
        let preset = self.preset(&tuning);
        let echoes = named
            .into_iter()
            .map(|name| GainEcho { value: shown(&tuning, &name), name, tick: next_tick, preset })
            .collect();
        let list =
            preset_applied.then(|| GainList { gains: self.list(&tuning), preset, tick: next_tick });
        Applied { echoes, list }
    }

    /// Applies a preset and returns the names of the gains that it changed.
    fn choose(&mut self, preset: Preset, tuning: &mut Tuning) -> Vec<String> {
        self.chosen =
            PRESETS.iter().position(|(known, ..)| *known == preset).unwrap_or(self.chosen);
        let before = std::mem::replace(tuning, self.presets[self.chosen]);
        changed(&before, tuning).collect()
    }

    /// Sentences for the events that are noted at once about changed gains.
    fn sentences(
        &mut self,
        [before, after]: [&Tuning; 2],
        named: &[String],
        preset_applied: bool,
        next_tick: u64,
    ) -> Vec<String> {
        let differs =
            |name: &&String| shown(before, name).to_bits() != shown(after, name).to_bits();
        let changed: Vec<&String> = named.iter().filter(differs).collect();
        if preset_applied {
            self.gain_events = GainEvents::default();
            return vec![format!(
                "preset {} ({} gains changed)",
                PRESETS[self.chosen].2,
                changed.len()
            )];
        }
        if changed.len() > MOST_SENTENCES {
            let names: Vec<&str> = changed.iter().map(|name| name.as_str()).collect();
            return vec![format!("{} gains changed: {}", names.len(), names.join(", "))];
        }
        changed
            .into_iter()
            .filter_map(|name| {
                self.gain_events.change(name, [shown(before, name), shown(after, name)], next_tick)
            })
            .collect()
    }
}

/// Names of the gains whose values differ.
fn changed(one: &Tuning, other: &Tuning) -> impl Iterator<Item = String> {
    let (one, other) = (*one, *other);
    let names = Tuning::parameters().into_iter().map(|parameter| parameter.name);
    names.filter(move |name| shown(&one, name).to_bits() != shown(&other, name).to_bits())
}

/// The value of `name` in `tuning`; NaN if there is no such gain.
fn shown(tuning: &Tuning, name: &str) -> f64 {
    tuning.get(name).unwrap_or(f64::NAN)
}

/// The same values, limited to their ranges: a preset may disable a cap with a value beyond its range.
fn within_ranges(tuning: &Tuning) -> Tuning {
    let mut inside = *tuning;
    for parameter in Tuning::parameters() {
        let Quantity { min, max, .. } = *parameter.quantity;
        let value = inside.get(&parameter.name).map(|value| value.clamp(min, max));
        if let Some(Err(error)) = value.map(|value| inside.set(&parameter.name, value)) {
            tracing::warn!("a value in force is not usable: {error}");
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::control::Gains;
    use twin_core::notation::Coords;
    use twin_core::residual::lra;

    fn tuning(preset: Preset) -> Tuning {
        Tuning { gains: Gains::preset(preset), adapter: lra::Settings::default() }
    }

    fn presets() -> GainPresets {
        GainPresets {
            presets: PRESETS.map(|(preset, ..)| within_ranges(&tuning(preset))),
            chosen: 2,
            gain_events: GainEvents::default(),
        }
    }

    #[test]
    fn names_and_values_are_checked_on_arrival() {
        assert!(check(&tuning(Preset::Paper), "slope.x".to_owned(), 2.0).is_ok());
        for value in [f64::NAN, f64::INFINITY, -0.5, 1e30] {
            assert!(matches!(
                check(&tuning(Preset::Paper), "slope.x".to_owned(), value),
                Err(TuningError::OutOfRange(_))
            ));
        }
        assert!(matches!(
            check(&tuning(Preset::Paper), "slope.nose".to_owned(), 1.0),
            Err(TuningError::UnknownName { .. })
        ));
    }

    #[test]
    fn each_preset_is_recognised_and_one_changed_value_makes_it_custom() {
        for (preset, name, _) in PRESETS {
            let mut values = tuning(preset);
            assert_eq!(presets().preset(&values), name);
            values.gains.slope = Coords::repeat(0.123);
            assert_eq!(presets().preset(&values), PresetName::Custom);
        }
    }

    #[test]
    fn every_listed_value_can_be_sent_back() {
        let presets = presets();
        for (preset, ..) in PRESETS {
            for gain in presets.list(&tuning(preset)) {
                for value in [gain.value, gain.preset_value] {
                    assert!(
                        check(&tuning(Preset::Paper), gain.name.clone(), value).is_ok(),
                        "{} = {value}",
                        gain.name
                    );
                }
            }
        }
    }

    #[test]
    fn choosing_a_preset_names_exactly_the_gains_that_differ() {
        let mut values = tuning(Preset::Tuned);
        let mut names = presets().choose(Preset::Paper, &mut values);
        names.sort();
        // The tuned preset is the paper's with translation and lead changed.
        let lead = twin_core::notation::COORDINATE_NAMES.map(|row| format!("lead.{row}"));
        let translation = ["x", "y", "z"]
            .iter()
            .flat_map(|row| [format!("damping.{row}"), format!("slope.{row}")]);
        let mut wanted: Vec<String> = lead.into_iter().chain(translation).collect();
        wanted.sort();
        assert_eq!(names, wanted);
        assert_eq!(values, tuning(Preset::Paper));
    }
}
