//! Commands of clients, checked: every value that reaches the flight is inside its limits.

use crate::server::gains::{self, Change};
use crate::server::protocol::{ClientMessage, PresetName, ScenarioInfo};
use twin_core::quantity::{self, OutOfRange};
use twin_core::source::{Disturbance, EFFECTS};
use twin_core::tuning::{Tuning, TuningError};
use twin_scenario::Preset;

/// The answer to a command that finds no room in the queue.
pub(super) const BUSY: &str = "the flight is busy; nothing was changed, try again";

/// Most keys that a fork changes: every gain and as many other settings.
const MOST_KEYS: usize = 64;

/// Longest key with its value, bytes: a list of faults as text.
const MOST_KEY_BYTES: usize = 2048;

/// A command that the flight executes between two ticks.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Command {
    /// Change gains.
    Change(Change),
    /// Pause (`true`) or resume (`false`).
    Pause(bool),
    /// Fly this number of ticks, then pause.
    Step(u32),
    /// Simulated seconds per second; `None` flies as fast as the machine can.
    Speed(Option<f64>),
    /// Restart with another seed and another scenario of the catalogue; `None` keeps the present one.
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
    /// Fork the flight.
    Fork(Asked),
    /// Name a fork.
    NameFork {
        /// Its identifier.
        id: u32,
        /// The name.
        name: String,
    },
    /// Forget the fork of this identifier.
    DropFork(u32),
}

/// A fork that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Asked {
    /// Tick before which the fork begins; `None` is the next tick.
    pub tick: Option<u64>,
    /// Changed keys, `key=value` each.
    pub set: Vec<String>,
    /// Name for people.
    pub name: String,
}

/// A command with the client that sent it; `None` for the HTTP interface.
#[derive(Clone, Debug)]
pub(super) struct Request {
    /// Client that is told about a failure.
    pub client: Option<u64>,
    /// Command of the client.
    pub command: Command,
}

/// Why a message had no effect.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum CommandError {
    /// A gain with a wrong name or value.
    #[error(transparent)]
    Gain(#[from] TuningError),
    /// `custom` is no preset that can be chosen.
    #[error(
        "preset custom refused: it is what a set of gains is called that is no preset; allowed: literal, paper, tuned"
    )]
    CustomPreset,
    /// Failures belong to a scenario, so that the flight can be repeated.
    #[error("disturb failure refused: write it into the scenario as [[faults]]")]
    Failure,
    /// A fork that changes too much at a time.
    #[error(
        "fork refused: found {keys} keys, allowed are {MOST_KEYS} of {MOST_KEY_BYTES} bytes each; write a scenario for more"
    )]
    LargeFork {
        /// Number of keys that were given.
        keys: usize,
    },
    /// A number outside its limits.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// The scenario is not in the catalogue.
    #[error("scenario {name:?} refused: not among the offered ones; allowed: {allowed}")]
    UnknownScenario {
        /// Name that was given.
        name: String,
        /// Names of the catalogue.
        allowed: String,
    },
    /// An effect that does not exist.
    #[error("effect {name:?} refused: there is no such effect; allowed: {allowed}")]
    UnknownEffect {
        /// Name that was given.
        name: String,
        /// Existing names.
        allowed: String,
    },
}

/// The command in a message; `None` for `ping`.
///
/// # Errors
/// [`CommandError`] if a name is unknown or a number is outside its limits.
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
            quantity::STEP_TICKS.check(f64::from(ticks))?;
            Command::Step(ticks)
        }
        ClientMessage::Speed { value } => {
            if let Some(factor) = value {
                quantity::SPEED.check(factor)?;
            }
            Command::Speed(value)
        }
        ClientMessage::Restart { seed, scenario } => {
            if let Some(seed) = seed {
                quantity::SEED.check(quantity::whole(i128::from(seed)))?;
            }
            if let Some(name) = &scenario {
                known_scenario(name, catalogue)?;
            }
            Command::Restart { seed, scenario }
        }
        ClientMessage::Seek { t_s } => {
            quantity::SEEK_TIME.check(t_s)?;
            Command::Seek(t_s)
        }
        ClientMessage::Fork { tick, set, name } => {
            if set.len() > MOST_KEYS || set.iter().any(|key| key.len() > MOST_KEY_BYTES) {
                return Err(CommandError::LargeFork { keys: set.len() });
            }
            Command::Fork(Asked { tick, set, name: shortened(&name) })
        }
        ClientMessage::NameFork { id, name } => Command::NameFork { id, name: shortened(&name) },
        ClientMessage::DropFork { id } => Command::DropFork(id),
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
        Disturbance::Failure { .. } => return Err(CommandError::Failure),
        Disturbance::Effect { name, .. } if !EFFECTS.contains(&name.as_str()) => {
            let allowed = EFFECTS.join(", ");
            return Err(CommandError::UnknownEffect { name: shortened(name), allowed });
        }
        _ => {}
    }
    for (quantity, value) in disturbance.numbers() {
        quantity.check(value)?;
    }
    Ok(())
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
            (r#"{"type":"restart","seed":9007199254740993}"#, "seed"),
            (r#"{"type":"restart","seed":18446744073709551615}"#, "0..=9007199254740992"),
            (r#"{"type":"set_gain","name":"slope.x","value":-1}"#, "0..=20"),
            (r#"{"type":"set_gain","name":"nose","value":1}"#, "slope.x"),
            (
                r#"{"type":"disturb","disturbance":{"kind":"payload_mass","kg":300}}"#,
                "0.001..=2 kg",
            ),
            (
                r#"{"type":"disturb","disturbance":{"kind":"wind","velocity_m_s":[0,0,99]}}"#,
                "-30..=30 m/s",
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

    /// A client's message with `value` in the field `place`, such as `disturb.push.force_n`.
    fn carrying(place: &str, value: f64) -> String {
        let segments: Vec<&str> = place.split('.').collect();
        let list = |field: &str| match field {
            "velocity_m_s" | "force_n" => format!("[0.0, 0.0, {value:?}]"),
            // A whole number is written without a decimal point.
            "ticks" | "seed" => format!("{value}"),
            _ => format!("{value:?}"),
        };
        match segments[..] {
            ["disturb", kind, field] => {
                let others = match field {
                    "force_n" => r#""duration_s":1.0,"#,
                    "duration_s" => r#""force_n":[0.0,0.0,0.0],"#,
                    _ => "",
                };
                let disturbance =
                    format!(r#"{{"kind":"{kind}",{others}"{field}":{}}}"#, list(field));
                format!(r#"{{"type":"disturb","disturbance":{disturbance}}}"#)
            }
            [kind, field] => format!(r#"{{"type":"{kind}","{field}":{}}}"#, list(field)),
            _ => panic!("{place}"),
        }
    }

    #[test]
    fn a_client_is_held_to_the_range_of_every_number_it_may_send() {
        let mut places = 0;
        for quantity in quantity::all() {
            for place in quantity.messages {
                let [min, max] = [quantity.min, quantity.max];
                for value in [min, max] {
                    let text = carrying(place, value);
                    assert!(matches!(checked(&text), Ok(Some(_))), "{text}: {:?}", checked(&text));
                }
                // A whole number below zero is refused by its type, and beyond 2^53 there are only even doubles.
                let beyond = if *place == "restart.seed" {
                    vec![max + 2.0]
                } else {
                    vec![min - 1.0, max + 1.0]
                };
                for value in beyond {
                    let text = carrying(place, value);
                    let error = checked(&text).expect_err(&text).to_string();
                    assert!(error.contains(quantity.name), "{text}: {error}");
                    assert!(error.contains(&quantity.range()), "{text}: {error}");
                }
                places += 1;
            }
        }
        assert_eq!(places, 8, "payload mass, wind, push (two), step, speed, seed, seek");
    }

    #[test]
    fn a_scenario_is_held_to_the_same_ranges_as_a_client() {
        for quantity in quantity::all() {
            for place in quantity.messages {
                let Some(field) =
                    place.strip_prefix("disturb.").and_then(|place| place.split('.').next_back())
                else {
                    continue;
                };
                let path = ["disturbances", "0", field].map(str::to_owned);
                let bounds = quantity::at(&path).expect(place);
                assert_eq!(bounds, quantity::Bounds { quantity, or_none: false }, "{place}");
            }
        }
    }
}
