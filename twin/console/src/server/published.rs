//! The description of the flight, which every new client receives.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::server::forks::ForkList;
use crate::server::pace::Lateness;
use crate::server::protocol::{
    ChannelInfo, EVENTS_KEPT, EventInfo, GainInfo, Hello, MirrorInfo, PROTOCOL_VERSION, PresetName,
    ScenarioInfo, ServerMessage, StateInfo,
};
use crate::server::quantity_info;
use twin_core::notation::TICK_S;
use twin_core::source::EFFECTS;
use twin_record::scene::Scene;

/// The description of the flight in its current state.
#[derive(Clone, Debug)]
pub(super) struct Published {
    /// Identifier of the telemetry rows that `channels` describes.
    pub schema_id: u16,
    /// Scenarios that a restart may name.
    pub scenarios: Arc<Vec<ScenarioInfo>>,
    /// The recording that is mirrored; `None` in a simulated flight.
    pub mirror: Option<Arc<MirrorInfo>>,
    /// Bodies and shapes to draw.
    pub scene: Arc<Scene>,
    /// Channels of a row, in their order.
    pub channels: Arc<Vec<ChannelInfo>>,
    /// How far the predictor looks into the future, ticks.
    pub horizon_ticks: u32,
    /// Gains with their values in force.
    pub gains: Vec<GainInfo>,
    /// Preset in force.
    pub preset: PresetName,
    /// State of the flight.
    pub state: StateInfo,
    /// Preset that was chosen last; the `preset_value` of a gain is the gain's value in this preset.
    pub base: PresetName,
    /// Histogram of the delays of ticks.
    pub lateness: Lateness,
    /// The forks of the flight.
    pub forks: Arc<ForkList>,
    /// The last events, oldest first.
    pub events: VecDeque<EventInfo>,
}

impl Published {
    /// The message `hello` for the client `client_id`.
    pub(super) fn hello(&self, client_id: u64) -> ServerMessage {
        ServerMessage::Hello(Box::new(Hello {
            protocol: PROTOCOL_VERSION,
            schema_id: self.schema_id,
            client_id,
            scenario: self.state.scenario.clone(),
            scenarios: self.scenarios.to_vec(),
            tick_s: TICK_S,
            horizon_ticks: self.horizon_ticks,
            quantities: quantity_info::list(),
            effects: EFFECTS.map(str::to_owned).to_vec(),
            mirror: self.mirror.as_deref().cloned(),
            scene: (*self.scene).clone(),
            channels: self.channels.to_vec(),
            gains: self.gains.clone(),
            preset: self.preset,
            state: self.state.clone(),
            events: self.events.iter().cloned().collect(),
            forks: self.forks.infos(),
        }))
    }

    /// Adds events and drops the oldest beyond [`EVENTS_KEPT`].
    pub(super) fn remember(&mut self, events: &[EventInfo]) {
        self.events.extend(events.iter().cloned());
        while self.events.len() > EVENTS_KEPT {
            self.events.pop_front();
        }
    }
}
