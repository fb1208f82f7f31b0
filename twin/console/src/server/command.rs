//! What a client asks, checked: everything that reaches the flight is inside its limits.

use crate::server::gains::{self, Change};
use crate::server::protocol::{ClientMessage, PresetName, ScenarioInfo};
use twin_core::source::Disturbance;
use twin_core::tuning::{Tuning, TuningError};
use twin_scenario::Preset;

/// Ticks of one `step` at most.
const MOST_STEPS: u32 = 1000;

/// Allowed speed factors.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// Largest payload, kg.
const MOST_PAYLOAD_KG: f64 = 2.0;

/// Strongest wind along one axis, m/s.
const MOST_WIND_M_S: f64 = 25.0;

/// Strongest push along one axis, N.
const MOST_PUSH_N: f64 = 100.0;

/// Longest push, s.
const LONGEST_PUSH_S: f64 = 10.0;

/// Latest time of a recording, s.
const LATEST_S: f64 = 1e6;

/// Effects that can be switched.
pub(super) const EFFECTS: [&str; 5] =
    ["rotor_drag", "body_drag", "ground_effect", "downwash", "wind"];

/// Something for the flight to do between two ticks.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Command {
    /// Change gains.
    Change(Change),
    /// Stop or resume.
    Pause(bool),
    /// Fly so many ticks, then pause.
    Step(u32),
    /// Simulated seconds per second; `None` is as fast as the machine can.
    Speed(Option<f64>),
    /// Start anew with a seed and a scenario out of the catalogue; `None` keeps the one in use.
    Restart {
        /// Seed.
        seed: Option<u64>,
        /// Name.
        scenario: Option<String>,
    },
    /// Change the world.
    Disturb(Disturbance),
    /// Go to a time of a recording, s.
    Seek(f64),
}

/// A command with the client that sent it; `None` for the HTTP interface.
#[derive(Clone, Debug)]
pub(super) struct Request {
    /// Who hears if it fails.
    pub client: Option<u64>,
    /// What to do.
    pub command: Command,
}

/// Why a message had no effect.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum CommandError {
    /// A gain with a wrong name or value.
    #[error(transparent)]
    Gain(#[from] TuningError),
    /// `custom` is no preset.
    #[error(
        "preset custom refused: it is what a set of gains is called that is no preset; allowed: literal, paper, tuned"
    )]
    CustomPreset,
    /// Failures belong to a scenario, where they can be flown again.
    #[error("disturb failure refused: write it into the scenario as [[faults]]")]
    Failure,
    /// A number outside its limits.
    #[error("{what} = {found} refused: expected a finite value in {min}..={max} {unit}")]
    OutOfRange {
        /// Name of the number.
        what: &'static str,
        /// What was asked for.
        found: f64,
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
        /// Unit.
        unit: &'static str,
    },
    /// A scenario that was not offered.
    #[error("scenario {name:?} refused: not among the offered ones; allowed: {allowed}")]
    UnknownScenario {
        /// What was asked for.
        name: String,
        /// What exists.
        allowed: String,
    },
    /// An effect that does not exist.
    #[error("effect {name:?} refused: there is no such effect; allowed: {allowed}")]
    UnknownEffect {
        /// What was asked for.
        name: String,
        /// What exists.
        allowed: String,
    },
}

/// The command in a message; `ping` is none.
///
/// # Errors
/// [`CommandError`] if a name is unknown or a number outside its limits.
pub(super) fn check(
    message: ClientMessage,
    catalogue: &[ScenarioInfo],
    tuning: &Tuning,
) -> Result<Option<Command>, CommandError> {
    let command = match message {
        ClientMessage::Ping { .. } => return Ok(None),
        ClientMessage::SetGain { name, value } => {
            Command::Change(Change::Gain(gains::check(tuning, name, value)?))
        }
        ClientMessage::Preset { name } => Command::Change(Change::Preset(preset(name)?)),
        ClientMessage::Pause { paused } => Command::Pause(paused),
        ClientMessage::Step { ticks } => {
            within("step.ticks", f64::from(ticks), 1.0, f64::from(MOST_STEPS), "ticks")?;
            Command::Step(ticks)
        }
        ClientMessage::Speed { value } => {
            if let Some(factor) = value {
                within(
                    "speed.value",
                    factor,
                    *SPEEDS.start(),
                    *SPEEDS.end(),
                    "times real time, or null",
                )?;
            }
            Command::Speed(value)
        }
        ClientMessage::Restart { seed, scenario } => {
            if let Some(name) = &scenario {
                known_scenario(name, catalogue)?;
            }
            Command::Restart { seed, scenario }
        }
        ClientMessage::Seek { t_s } => {
            within("seek.t_s", t_s, 0.0, LATEST_S, "s")?;
            Command::Seek(t_s)
        }
        ClientMessage::Disturb { disturbance } => {
            harmless(&disturbance)?;
            Command::Disturb(disturbance)
        }
    };
    Ok(Some(command))
}

fn preset(name: PresetName) -> Result<Preset, CommandError> {
    gains::preset(name).ok_or(CommandError::CustomPreset)
}

fn known_scenario(name: &str, catalogue: &[ScenarioInfo]) -> Result<(), CommandError> {
    if catalogue.iter().any(|known| known.name == name) {
        return Ok(());
    }
    let allowed = catalogue.iter().map(|known| known.name.as_str()).collect::<Vec<_>>().join(", ");
    Err(CommandError::UnknownScenario { name: shortened(name), allowed })
}

fn harmless(disturbance: &Disturbance) -> Result<(), CommandError> {
    match disturbance {
        Disturbance::PayloadMass { kg } => {
            within("payload mass", *kg, 0.001, MOST_PAYLOAD_KG, "kg")
        }
        Disturbance::Wind { velocity_m_s } => velocity_m_s
            .iter()
            .try_for_each(|&v| within("wind", v, -MOST_WIND_M_S, MOST_WIND_M_S, "m/s")),
        Disturbance::Push { force_n, duration_s } => {
            force_n.iter().try_for_each(|&f| within("push", f, -MOST_PUSH_N, MOST_PUSH_N, "N"))?;
            within("push duration", *duration_s, 0.0, LONGEST_PUSH_S, "s")
        }
        Disturbance::DropPayload => Ok(()),
        Disturbance::Effect { name, .. } if EFFECTS.contains(&name.as_str()) => Ok(()),
        Disturbance::Failure { .. } => Err(CommandError::Failure),
        Disturbance::Effect { name, .. } => {
            Err(CommandError::UnknownEffect { name: shortened(name), allowed: EFFECTS.join(", ") })
        }
    }
}

fn within(
    what: &'static str,
    found: f64,
    min: f64,
    max: f64,
    unit: &'static str,
) -> Result<(), CommandError> {
    if found.is_finite() && found >= min && found <= max {
        return Ok(());
    }
    Err(CommandError::OutOfRange { what, found, min, max, unit })
}

fn shortened(name: &str) -> String {
    name.chars().take(64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(text: &str) -> Result<Option<Command>, CommandError> {
        let tuning = Tuning {
            gains: twin_core::control::Gains::preset(Preset::Tuned),
            adapter: twin_core::residual::lra::Settings::default(),
        };
        let catalogue = [ScenarioInfo { name: "hover".to_owned(), title: "Hover".to_owned() }];
        check(serde_json::from_str(text).expect(text), &catalogue, &tuning)
    }

    #[test]
    fn usable_messages_become_commands() {
        assert_eq!(checked(r#"{"type":"pause","paused":true}"#), Ok(Some(Command::Pause(true))));
        assert_eq!(checked(r#"{"type":"speed","value":null}"#), Ok(Some(Command::Speed(None))));
        assert_eq!(checked(r#"{"type":"step","ticks":3}"#), Ok(Some(Command::Step(3))));
        assert_eq!(checked(r#"{"type":"ping","t":3}"#), Ok(None));
        let restart = Command::Restart { seed: Some(4), scenario: Some("hover".to_owned()) };
        assert_eq!(checked(r#"{"type":"restart","seed":4,"scenario":"hover"}"#), Ok(Some(restart)));
        let push = r#"{"type":"disturb","disturbance":{"kind":"push","force_n":[5,0,0],"duration_s":0.5}}"#;
        assert!(matches!(checked(push), Ok(Some(Command::Disturb(Disturbance::Push { .. })))));
    }

    #[test]
    fn unusable_values_are_refused_with_what_is_allowed() {
        let refused = [
            (r#"{"type":"step","ticks":0}"#, "1..=1000"),
            (r#"{"type":"step","ticks":4000000000}"#, "1..=1000"),
            (r#"{"type":"speed","value":0}"#, "0.01..=100"),
            (r#"{"type":"speed","value":-1}"#, "0.01..=100"),
            (r#"{"type":"preset","name":"custom"}"#, "literal, paper, tuned"),
            (r#"{"type":"restart","scenario":"../../etc/passwd"}"#, "allowed: hover"),
            (r#"{"type":"set_gain","name":"slope.x","value":-1}"#, "0..=20"),
            (r#"{"type":"set_gain","name":"nose","value":1}"#, "slope.x"),
            (
                r#"{"type":"disturb","disturbance":{"kind":"payload_mass","kg":300}}"#,
                "0.001..=2 kg",
            ),
            (
                r#"{"type":"disturb","disturbance":{"kind":"wind","velocity_m_s":[0,0,99]}}"#,
                "-25..=25 m/s",
            ),
            (
                r#"{"type":"disturb","disturbance":{"kind":"effect","name":"gravity","on":false}}"#,
                "rotor_drag",
            ),
            (
                r#"{"type":"disturb","disturbance":{"kind":"push","force_n":[0,0,1e9],"duration_s":1}}"#,
                "100 N",
            ),
        ];
        for (text, allowed) in refused {
            let error = checked(text).expect_err(text).to_string();
            assert!(error.contains(allowed), "{text}: {error}");
        }
    }
}
