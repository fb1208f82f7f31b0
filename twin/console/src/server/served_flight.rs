//! One served flight with its judge, gains and pictures; a restart replaces it as a whole.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::server::channels::{Channels, RowSource};
use crate::server::gains::GainPresets;
use crate::server::mirrored::{self, Mirrored};
use crate::server::pace::Lateness;
use crate::server::protocol::{EventInfo, FlightPhase, GainInfo, ScenarioInfo, StateInfo};
use crate::server::published::Published;
use crate::server::telemetry::Picture;
use crate::server::world::World;
use twin_core::flight::Flight;
use twin_core::notation::TICK_S;
use twin_core::source::Disturbance;
use twin_core::tick::Tick;
use twin_core::tuning::Tuning;
use twin_foreign::shadow_score::Score;
use twin_foreign::stand_in;
use twin_record::scene::Scene;
use twin_scenario::{BuildError, Judge, Scenario};

/// Number of ticks between two decompositions of the covariance; a reset also triggers one.
const SPECTRUM_TICKS: u64 = 10;

/// Phase that is shown while a live stream sends nothing.
const STREAM_LOST: &str = "stream lost";

/// One flight.
pub(super) struct ServedFlight {
    /// Scenario that is flown.
    pub scenario: Scenario,
    /// The flight.
    pub flight: Flight,
    /// Decides when the flight ends and with which verdict.
    pub judge: Judge,
    /// Gains and their presets.
    pub presets: GainPresets,
    /// Bodies to draw.
    pub scene: Arc<Scene>,
    /// Channels to plot.
    pub channels: Arc<Channels>,
    /// The recording, if one is mirrored.
    pub mirrored: Option<Arc<Mirrored>>,
    /// How its forecasts did since the last jump.
    pub score: Option<Score>,
    /// Payload, wind and effects in force.
    pub world: World,
    /// Eigenvalues of the adapter's covariance, largest first.
    spectrum: Vec<f64>,
    /// Number of the tick at which the last push ends.
    push_ends: u64,
    /// Number of the next tick.
    pub next_tick: u64,
    /// True once a tick was flown.
    has_flown: bool,
    /// Simulated time of the last tick, s.
    pub t_s: f64,
    /// Phase of the task.
    pub task_phase: String,
    /// Verdict and reason, once it ended.
    pub verdict: Option<(String, String)>,
}

impl ServedFlight {
    /// The flight of a scenario, at its first tick.
    ///
    /// # Errors
    /// [`BuildError`] if it cannot be built.
    pub(super) fn new(scenario: Scenario) -> Result<Self, BuildError> {
        let flight = scenario.build()?;
        let scene = Arc::new(scenario.scene()?);
        Ok(Self {
            judge: Judge::new(&scenario.settings),
            presets: GainPresets::new(&scenario, flight.tuning()),
            channels: Arc::new(
                Channels::new(
                    scene.rotors.len(),
                    &scenario.actuator_limits()?,
                    &flight.predictor().info(),
                )
                .with_weight(Some(scenario.weight_n()?)),
            ),
            mirrored: None,
            score: None,
            world: World::new(&scenario.settings),
            spectrum: Vec::new(),
            push_ends: 0,
            scene,
            flight,
            scenario,
            next_tick: 0,
            has_flown: false,
            t_s: 0.0,
            task_phase: String::new(),
            verdict: None,
        })
    }

    /// The shadow flight of a recording from tick `first` on, with the values `tuning`.
    ///
    /// # Errors
    /// [`BuildError`] if the recording has no such tick.
    pub(super) fn mirror(
        mirrored: &Arc<Mirrored>,
        first: usize,
        tuning: &Tuning,
    ) -> Result<Self, BuildError> {
        let flight = mirrored.shadow.flight(first, tuning).ok_or(BuildError::Unfit {
            key: "recording",
            reason: format!("has no tick {first}"),
        })?;
        let scenario = Scenario::of_recording(&mirrored.name, &mirrored.path)?;
        let scene = Arc::new(stand_in());
        Ok(Self {
            judge: Judge::new(&scenario.settings),
            presets: GainPresets::new(&scenario, flight.tuning()),
            channels: Arc::new(
                Channels::mirrored(scene.rotors.len(), mirrored.shadow.scale())
                    .with_weight(Some(mirrored.shadow.weight()))
                    .per_kilogram(mirrored.info.per_kilogram),
            ),
            mirrored: Some(Arc::clone(mirrored)),
            score: Some(Score::new(*mirrored.shadow.scale())),
            world: World::new(&scenario.settings),
            spectrum: Vec::new(),
            push_ends: 0,
            scene,
            flight,
            scenario,
            next_tick: first as u64,
            has_flown: false,
            t_s: first as f64 * TICK_S,
            task_phase: String::new(),
            verdict: None,
        })
    }

    /// The description for clients before the first tick.
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
            stages: Vec::new(),
            payload_kg: None,
            wind_m_s: [0.0; 3],
            effects_off: Vec::new(),
            twin: None,
            recording: None,
        };
        self.describe(&mut state, speed, paused);
        Published {
            schema_id: 1,
            mirror: self.mirrored.as_ref().map(|mirrored| Arc::new(mirrored.info.clone())),
            scenarios,
            scene: Arc::clone(&self.scene),
            channels: Arc::clone(self.channels.infos()),
            horizon_ticks: self.channels.horizon_ticks(),
            gains: self.gains(),
            preset: self.presets.preset(self.flight.tuning()),
            base: self.presets.base(),
            state,
            lateness: Lateness::default(),
            forks: Arc::default(),
            events: self.earlier_events(),
        }
    }

    /// The events before the first tick: a mirrored flight may start in the middle of its recording.
    fn earlier_events(&self) -> VecDeque<EventInfo> {
        let mirrored = self.mirrored.iter();
        mirrored.flat_map(|mirrored| mirrored.phases_before(self.next_tick)).collect()
    }

    /// Gains that a client can change; in a mirrored flight those of the adapter only.
    pub(super) fn gains(&self) -> Vec<GainInfo> {
        let mut gains = self.presets.list(self.flight.tuning());
        gains.retain(|gain| self.mirrored.is_none() || mirrored::acts_in_shadow(&gain.name));
        gains
    }

    /// Writes the state of the flight into `state`.
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
        if self.mirrored.as_ref().is_some_and(|mirrored| mirrored.is_lost()) {
            STREAM_LOST.clone_into(&mut state.task_phase);
        }
        // Before the first tick after a start or a seek there is no tick to compare the twin with.
        let last = self.next_tick.checked_sub(1).filter(|_| self.has_flown);
        let beside = |tick| {
            let mirrored = self.mirrored.as_ref()?;
            Some(Box::new(mirrored.beside(tick as usize, self.score.as_ref()?)))
        };
        state.twin = last.and_then(beside);
        state.verdict = verdict;
        state.reason = reason;
        self.world.describe(state);
    }

    /// Updates the state after the flight has flown `tick`.
    pub(super) fn follow(&mut self, tick: &Tick) {
        self.next_tick = tick.index + 1;
        self.has_flown = true;
        self.t_s = tick.measurement.t_s;
        self.world.advance(self.t_s);
        if let Some(score) = &mut self.score {
            score.add(tick);
        }
        if tick.index.is_multiple_of(SPECTRUM_TICKS) || tick.adapted.reset {
            self.spectrum = self.flight.covariance_spectrum();
        }
    }

    /// One sentence for each part of the recording that could not be read since the last call.
    pub(super) fn unreadable(&self) -> Vec<String> {
        self.mirrored
            .as_ref()
            .map_or_else(Vec::new, |mirrored| mirrored.shadow.playback().troubles())
    }

    /// Notes gain changes whose sliders are at rest as events of the next tick.
    pub(super) fn settle_gains(&mut self) {
        self.presets.settle(&mut self.flight, self.next_tick);
    }

    /// The row and the picture of a tick.
    pub(super) fn draw(&self, tick: &Tick) -> (Arc<[f32]>, Arc<Picture>) {
        let sample = RowSource { tick, tuning: self.flight.tuning(), spectrum: &self.spectrum };
        let picture = Picture::new(&self.scene, tick, &self.spectrum);
        (self.channels.row(&sample), Arc::new(picture))
    }

    /// Changes the world. A push that is repeated before it ends counts as one event; returns whether it did.
    pub(super) fn disturb(&mut self, disturbance: &Disturbance) -> bool {
        self.world.change(disturbance);
        if let Disturbance::Push { duration_s, .. } = disturbance {
            let goes_on = self.next_tick < self.push_ends;
            self.push_ends = self.next_tick + (duration_s / TICK_S).ceil() as u64;
            if goes_on {
                self.flight.prolong(disturbance);
                return true;
            }
        }
        self.flight.disturb(disturbance);
        false
    }
}

/// The word that a unit variant serialises to.
pub(super) fn word(value: &impl serde::Serialize) -> String {
    let text = serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned));
    text.unwrap_or_else(|| "unknown".to_owned())
}
