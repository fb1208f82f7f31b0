//! The controls of a viewer: a slider for each gain of the flight, and the buttons.
//!
//! A slider shows the value in force. If the server refused a slider's value, or if another client changed the gain, the server
//! moves the slider to the value in force. It does not move a slider while the operator drags it.

use std::collections::BTreeMap;

use crate::server::protocol::{ClientMessage, FlightPhase, GainInfo, PresetName};
use twin_core::source::Disturbance;

/// The server corrects a slider when the operator has not moved it for this long, s.
const HANDS_OFF_S: f64 = 0.3;

/// A slider computes its last position from its step. A value that exceeds the limit by a few roundings means the limit. The
/// tolerance is this fraction of the slider's range.
const ROUNDING: f64 = 1e-9;

/// A button of a viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Button {
    /// Pauses the flight, or continues a paused one.
    Pause,
    /// Flies one tick.
    Step,
    /// Starts the flight anew.
    Restart,
    /// Sets all gains to the values of a preset.
    Preset(PresetName),
    /// Drops the payload.
    DropPayload,
}

impl Button {
    /// All buttons with their captions, which are also their names.
    pub(super) const ALL: [(Self, &'static str); 7] = [
        (Self::Pause, "Pause / Continue"),
        (Self::Step, "Step"),
        (Self::Restart, "Restart"),
        (Self::Preset(PresetName::Literal), "Preset literal"),
        (Self::Preset(PresetName::Paper), "Preset paper"),
        (Self::Preset(PresetName::Tuned), "Preset tuned"),
        (Self::DropPayload, "Drop payload"),
    ];

    /// The key that presses the button, as browsers name keys. It is the same key as in the console.
    pub(super) fn key(self) -> Option<&'static str> {
        match self {
            Self::Pause => Some("Space"),
            Self::Step => Some("Period"),
            Self::Restart => Some("KeyR"),
            Self::Preset(_) | Self::DropPayload => None,
        }
    }

    /// The button called `name`.
    pub(super) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|(_, known)| *known == name).map(|(button, _)| button)
    }

    /// The request that the button makes to a flight in `phase`.
    pub(super) fn asks(self, phase: FlightPhase) -> ClientMessage {
        match self {
            Self::Pause => ClientMessage::Pause { paused: phase != FlightPhase::Paused },
            Self::Step => ClientMessage::Step { ticks: 1 },
            Self::Restart => ClientMessage::Restart { seed: None, scenario: None },
            Self::Preset(name) => ClientMessage::Preset { name },
            Self::DropPayload => ClientMessage::Disturb { disturbance: Disturbance::DropPayload },
        }
    }
}

/// The keys that move the slider of a gain down and up by a step, as browsers name keys. Only the reset threshold and the
/// forgetting factor have keys, because operators turn them while they watch the adapter.
pub(super) fn slider_keys(gain: &str) -> Option<[&'static str; 2]> {
    match gain {
        "reset_threshold" => Some(["BracketLeft", "BracketRight"]),
        "forgetting" => Some(["Minus", "Equal"]),
        _ => None,
    }
}

#[derive(Clone, Copy, Debug)]
struct Slider {
    in_force: f64,
    shown: f64,
    moved_s: f64,
    limits: [f64; 2],
}

/// The sliders of one client, by the name of their gain.
#[derive(Clone, Debug, Default)]
pub(super) struct Sliders {
    sliders: BTreeMap<String, Slider>,
}

impl Sliders {
    /// Whether the client has got no sliders yet.
    pub(super) fn is_empty(&self) -> bool {
        self.sliders.is_empty()
    }

    /// Takes the gains and their values in force. The client shows a new gain with the value in force.
    pub(super) fn set(&mut self, gains: &[GainInfo]) {
        for gain in gains {
            let new = Slider {
                in_force: gain.value,
                shown: gain.value,
                moved_s: f64::NEG_INFINITY,
                limits: [gain.min, gain.max],
            };
            let slider = self.sliders.entry(gain.name.clone()).or_insert(new);
            slider.in_force = gain.value;
        }
    }

    /// Notes that a gain took effect.
    pub(super) fn in_force(&mut self, name: &str, value: f64) {
        if let Some(slider) = self.sliders.get_mut(name) {
            slider.in_force = value;
        }
    }

    /// Notes that the client moved a slider to `value` at `now_s`; returns the value without rounding errors at the limits.
    pub(super) fn moved(&mut self, name: &str, value: f64, now_s: f64) -> f64 {
        let Some(slider) = self.sliders.get_mut(name) else { return value };
        slider.shown = value;
        slider.moved_s = now_s;
        let [min, max] = slider.limits;
        let rounding = ROUNDING * (max - min);
        let close = value >= min - rounding && value <= max + rounding;
        if close { value.clamp(min, max) } else { value }
    }

    /// Names and values in force of the sliders that show another value. The caller must send them, because they count as corrected.
    pub(super) fn overdue(&mut self, now_s: f64) -> Vec<(String, f64)> {
        let mut overdue = Vec::new();
        for (name, slider) in &mut self.sliders {
            let differs = slider.shown.to_bits() != slider.in_force.to_bits();
            if differs && now_s - slider.moved_s >= HANDS_OFF_S {
                slider.shown = slider.in_force;
                overdue.push((name.clone(), slider.in_force));
            }
        }
        overdue
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(name: &str, value: f64) -> GainInfo {
        GainInfo {
            name: name.to_owned(),
            label: String::new(),
            group: String::new(),
            unit: String::new(),
            help: String::new(),
            min: 0.0,
            max: 0.3,
            step: 0.1,
            value,
            preset_value: value,
        }
    }

    fn sliders() -> Sliders {
        let mut sliders = Sliders::default();
        sliders.set(&[gain("a", 0.1), gain("b", 0.2)]);
        sliders
    }

    #[test]
    fn a_change_of_somebody_else_is_shown_once() {
        let mut sliders = sliders();
        assert!(sliders.overdue(0.0).is_empty());
        sliders.in_force("b", 0.3);
        assert_eq!(sliders.overdue(0.0), [("b".to_owned(), 0.3)]);
        assert!(sliders.overdue(1.0).is_empty());
    }

    #[test]
    fn a_slider_under_the_hand_is_left_alone_and_agrees_afterwards() {
        let mut sliders = sliders();
        sliders.moved("a", 0.15, 1.0);
        sliders.in_force("a", 0.12);
        assert!(sliders.overdue(1.2).is_empty());
        sliders.in_force("a", 0.15);
        assert!(sliders.overdue(2.0).is_empty());
    }

    #[test]
    fn a_refused_value_goes_back_also_if_it_is_no_number() {
        for refused in [7.0, f64::NAN, f64::INFINITY] {
            let mut sliders = sliders();
            assert_eq!(sliders.moved("a", refused, 1.0).to_bits(), refused.to_bits());
            assert!(sliders.overdue(1.1).is_empty());
            assert_eq!(sliders.overdue(1.5), [("a".to_owned(), 0.1)]);
        }
    }

    #[test]
    fn three_steps_of_a_tenth_mean_the_limit_and_unknown_names_are_not_kept() {
        let mut sliders = sliders();
        let beyond = 0.1 * 3.0;
        assert!(beyond > 0.3);
        assert_eq!(sliders.moved("a", beyond, 0.0).to_bits(), 0.3_f64.to_bits());
        sliders.moved("nose", 1.0, 0.0);
        assert_eq!(sliders.sliders.len(), 2);
    }

    #[test]
    fn every_button_is_found_by_its_name_and_pause_asks_for_the_other_state() {
        for (button, name) in Button::ALL {
            assert_eq!(Button::named(name), Some(button));
        }
        let asked = |phase| match Button::Pause.asks(phase) {
            ClientMessage::Pause { paused } => paused,
            other => panic!("{other:?}"),
        };
        assert!(asked(FlightPhase::Flying) && !asked(FlightPhase::Paused));
    }
}
