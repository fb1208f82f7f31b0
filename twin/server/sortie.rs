//! One served flight with all that belongs to it: a restart replaces it as a whole.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::flight::Flight;
use crate::mirror::scene::Scene;
use crate::scenario::{BuildError, Judge, Scenario};
use crate::server::channels::Channels;
use crate::server::gains::Desk;
use crate::server::hub::Published;
use crate::server::pace::STAGES;
use crate::server::protocol::{FlightPhase, ScenarioInfo, StateInfo};

/// One flight.
pub(super) struct Sortie {
    /// What is flown.
    pub scenario: Scenario,
    /// The flight.
    pub flight: Flight,
    /// Who ends it.
    pub judge: Judge,
    /// Its gains.
    pub desk: Desk,
    /// What to draw.
    pub scene: Arc<Scene>,
    /// What to plot.
    pub channels: Channels,
    /// Number of the next tick.
    pub next_tick: u64,
    /// Simulated time of the last tick, s.
    pub t_s: f64,
    /// Phase of the task.
    pub task_phase: String,
    /// Verdict and reason, once it ended.
    pub verdict: Option<(String, String)>,
}

impl Sortie {
    /// The flight of a scenario, at its first tick.
    ///
    /// # Errors
    /// [`BuildError`] if it cannot be built.
    pub(super) fn new(scenario: Scenario) -> Result<Self, BuildError> {
        let flight = scenario.build()?;
        let scene = Arc::new(scenario.scene()?);
        Ok(Self {
            judge: Judge::new(&scenario.settings),
            desk: Desk::new(&scenario, flight.tuning()),
            channels: Channels::new(scene.rotors.len()),
            scene,
            flight,
            scenario,
            next_tick: 0,
            t_s: 0.0,
            task_phase: String::new(),
            verdict: None,
        })
    }

    /// What clients are told before its first tick.
    pub(super) fn published(
        &self,
        scenarios: Arc<Vec<ScenarioInfo>>,
        speed: Option<f64>,
        paused: bool,
    ) -> Published {
        let mut state = StateInfo {
            phase: FlightPhase::Flying,
            speed: None,
            scenario: String::new(),
            seed: 0,
            tick: 0,
            t_s: 0.0,
            task_phase: String::new(),
            verdict: None,
            reason: None,
            real_time_factor: 0.0,
            clients: 0,
        };
        self.describe(&mut state, speed, paused);
        Published {
            schema_id: 1,
            scenarios,
            scene: Arc::clone(&self.scene),
            channels: Arc::clone(self.channels.infos()),
            gains: self.desk.list(self.flight.tuning()),
            preset: self.desk.preset(self.flight.tuning()),
            state,
            events: VecDeque::new(),
            cost_ms: [0.0; STAGES.len()],
        }
    }

    /// How the flight stands.
    pub(super) fn describe(&self, state: &mut StateInfo, speed: Option<f64>, paused: bool) {
        let (verdict, reason) = self.verdict.clone().unzip();
        state.phase = match (&verdict, paused) {
            (Some(_), _) => FlightPhase::Ended,
            (None, true) => FlightPhase::Paused,
            (None, false) => FlightPhase::Flying,
        };
        state.speed = speed;
        state.scenario.clone_from(&self.scenario.name);
        state.seed = self.scenario.settings.seed;
        state.tick = self.next_tick;
        state.t_s = self.t_s;
        state.task_phase.clone_from(&self.task_phase);
        state.verdict = verdict;
        state.reason = reason;
    }
}

/// The word a unit enum is serialised as.
pub(super) fn word(value: &impl serde::Serialize) -> String {
    let text = serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned));
    text.unwrap_or_else(|| "unknown".to_owned())
}
