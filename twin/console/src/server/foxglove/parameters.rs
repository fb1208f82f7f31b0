//! Gains as Foxglove's parameters.

use std::sync::Arc;

use foxglove::websocket::{
    AnyClient, GetParametersResponder, Parameter, ParameterHandler, ParameterValue,
    SetParametersResponder,
};

use crate::server::App;
use crate::server::client::shown;
use crate::server::command::{self, Request};
use crate::server::hub::Client;
use crate::server::mirrored;
use crate::server::protocol::{ClientMessage, GainInfo, NoticeLevel};

/// Most parameters of one request that are handled. There are fewer gains than this.
const MOST_PARAMETERS: usize = 256;

/// Longest name that is handled, characters.
const NAME_CHARACTERS: usize = 64;

/// Answers requests of Foxglove's clients to get and set gains.
pub(super) struct Gains {
    app: Arc<App>,
    /// Its outbox takes the notices about refused gains.
    bridge: Arc<Client>,
}

impl Gains {
    pub(super) fn new(app: Arc<App>, bridge: Arc<Client>) -> Self {
        Self { app, bridge }
    }

    /// Asks the flight to set the gain `name` to `value`.
    ///
    /// # Errors
    /// A sentence if the gain is refused.
    fn ask(&self, name: &str, value: f64) -> Result<(), String> {
        let message = ClientMessage::SetGain { name: shown(name, NAME_CHARACTERS), value };
        if let Some(why) = mirrored::refusal(&message, self.app.mirrored) {
            return Err(why.to_owned());
        }
        let command = command::check(message, &self.app.scenarios, &self.app.tuning)
            .map_err(|error| error.to_string())?;
        match command {
            Some(command) => self
                .app
                .ask(Request { client: Some(self.bridge.id), command })
                .map_err(str::to_owned),
            None => Ok(()),
        }
    }
}

/// The gains with their values in force, as Foxglove's parameters.
pub(super) fn parameters(gains: &[GainInfo]) -> Vec<Parameter> {
    gains.iter().map(|gain| Parameter::float64(&gain.name, gain.value)).collect()
}

impl ParameterHandler for Gains {
    fn get(
        &self,
        _: AnyClient,
        names: Vec<String>,
        _: Option<String>,
        responder: GetParametersResponder,
    ) {
        let mut found = parameters(&self.app.hub.published().gains);
        found.retain(|gain| names.is_empty() || names.contains(&gain.name));
        responder.respond(found);
    }

    /// Answers an accepted gain with its new value and a refused gain with the value in force. When a gain takes effect, the
    /// publisher tells the subscribers.
    fn set(
        &self,
        _: AnyClient,
        parameters: Vec<Parameter>,
        _: Option<String>,
        responder: SetParametersResponder,
    ) {
        let in_force = self.app.hub.published().gains;
        let mut answer = Vec::new();
        for Parameter { name, value, .. } in parameters.into_iter().take(MOST_PARAMETERS) {
            let value = number(value.as_ref());
            match self.ask(&name, value) {
                Ok(()) => answer.push(Parameter::float64(name, value)),
                Err(why) => {
                    self.bridge.notice(NoticeLevel::Warning, why);
                    let known = in_force.iter().find(|gain| gain.name == name);
                    answer.extend(known.map(|gain| Parameter::float64(&gain.name, gain.value)));
                }
            }
        }
        responder.respond(answer);
    }
}

/// The number that was sent; NaN, which every gain refuses, for a value of another kind.
fn number(value: Option<&ParameterValue>) -> f64 {
    match value {
        Some(ParameterValue::Float64(value)) => *value,
        Some(ParameterValue::Integer(value)) => *value as f64,
        _ => f64::NAN,
    }
}
