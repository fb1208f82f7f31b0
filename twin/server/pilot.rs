//! The one thread that flies: it takes requests between two ticks and publishes each tick. It waits for the clock, and
//! for nothing and nobody else: no socket, no disk, no watcher.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use crate::mirror::RecordingEnd;
use crate::scenario::Scenario;
use crate::server::ServerError;
use crate::server::command::{Command, Request};
use crate::server::gains::Change;
use crate::server::hub::Hub;
use crate::server::logbook::Logbook;
use crate::server::pace::{Meter, Pace, STAGES, now};
use crate::server::protocol::{EventInfo, NoticeLevel, ScenarioInfo, ServerMessage};
use crate::server::sortie::{Sortie, word};
use crate::server::telemetry::Picture;
use crate::tick::{EventKind, Tick};

/// The state is published at least this often, and the thread looks at its requests at least this often.
const STATE_PERIOD: Duration = Duration::from_millis(400);

/// Where to start and what else can be flown.
pub(super) struct Orders {
    /// First flight.
    pub scenario: Scenario,
    /// What `restart` may name.
    pub catalogue: Vec<Scenario>,
    /// Simulated seconds per second; `None` is as fast as the machine can.
    pub speed: Option<f64>,
    /// Wait for an operator.
    pub start_paused: bool,
    /// Recording.
    pub logbook: Logbook,
}

/// The thread's own state.
pub(super) struct Pilot {
    sortie: Sortie,
    catalogue: Vec<Scenario>,
    hub: Arc<Hub>,
    logbook: Logbook,
    pace: Pace,
    meter: Meter,
    paused: bool,
    steps: u32,
    changes: Vec<Change>,
    state_due: Instant,
    schema_id: u16,
}

impl Pilot {
    /// Builds the first flight and the hub that publishes it.
    ///
    /// # Errors
    /// [`ServerError`] if the scenario cannot be built.
    pub(super) fn new(orders: Orders) -> Result<Self, ServerError> {
        let Orders { scenario, catalogue, speed, start_paused, logbook } = orders;
        let sortie = Sortie::new(scenario)?;
        let infos = catalogue.iter().map(|known| ScenarioInfo {
            name: known.name.clone(),
            title: known.settings.title.clone(),
        });
        let published = sortie.published(Arc::new(infos.collect()), speed, start_paused);
        let start = now();
        let mut pilot = Self {
            sortie,
            catalogue,
            hub: Arc::new(Hub::new(published)),
            logbook,
            pace: Pace::new(speed, start),
            meter: Meter::new(start),
            paused: start_paused,
            steps: 0,
            changes: Vec::new(),
            state_due: start,
            schema_id: 1,
        };
        pilot.begin_recording()?;
        Ok(pilot)
    }

    /// Where the flight is published.
    pub(super) fn hub(&self) -> Arc<Hub> {
        Arc::clone(&self.hub)
    }

    /// Flies until `stop` is set or nobody can send requests any more.
    pub(super) fn fly(mut self, requests: &Receiver<Request>, stop: &AtomicBool) {
        self.pace = Pace::new(self.pace.speed(), now());
        while !stop.load(Ordering::Relaxed) {
            match requests.recv_timeout(self.patience()) {
                Ok(first) => {
                    self.handle(first);
                    for request in requests.try_iter() {
                        self.handle(request);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.apply_changes();
            if self.is_flying() && (self.steps > 0 || self.pace.wait(now()).is_zero()) {
                self.tick();
            }
            if now() >= self.state_due {
                self.publish_state();
            }
        }
        self.end_recording("");
    }

    fn is_flying(&self) -> bool {
        self.sortie.verdict.is_none() && (!self.paused || self.steps > 0)
    }

    /// How long requests may be waited for.
    fn patience(&self) -> Duration {
        let now = now();
        let state = self.state_due.saturating_duration_since(now);
        match (self.is_flying(), self.steps) {
            (false, _) => state,
            (true, 0) => self.pace.wait(now).min(state),
            (true, _) => Duration::ZERO,
        }
    }

    fn tick(&mut self) {
        let (mut spent, mut last) = ([Duration::ZERO; STAGES.len()], now());
        let mut lap = |stage: usize| {
            let done = now();
            spent[stage] += done - last;
            last = done;
            done
        };
        let tick = Arc::new(self.sortie.flight.tick_with(&mut |stage| {
            lap(stage as usize);
        }));
        self.sortie.next_tick = tick.index + 1;
        self.sortie.t_s = tick.measurement.t_s;
        self.steps = self.steps.saturating_sub(1);
        if let Err(error) = self.logbook.tick(&tick) {
            self.alarm(&error.to_string());
        }
        let Sortie { scene, channels, flight, .. } = &self.sortie;
        self.hub.tick(&tick, || {
            (channels.row(&tick, flight.tuning()), Arc::new(Picture::new(scene, &tick)))
        });
        self.publish_events(&tick);
        if self.sortie.task_phase != tick.phase {
            self.sortie.task_phase.clone_from(&tick.phase);
            self.state_due = now();
        }
        if let Some((verdict, reason)) = self.sortie.judge.watch(&tick) {
            self.end(word(&verdict), reason);
        }
        let done = lap(STAGES.len() - 1);
        self.pace.ticked(done);
        self.meter.count(spent);
    }

    fn end(&mut self, verdict: String, reason: String) {
        let event = EventInfo {
            tick: self.sortie.next_tick.saturating_sub(1),
            t_s: self.sortie.t_s,
            kind: EventKind::Verdict,
            text: format!("{verdict}: {reason}"),
        };
        self.publish_event_infos(vec![event]);
        self.end_recording(&format!("{verdict}: {reason}"));
        self.sortie.verdict = Some((verdict, reason));
        self.steps = 0;
        self.publish_state();
    }

    fn handle(&mut self, request: Request) {
        match request.command {
            Command::Change(change) => self.changes.push(change),
            Command::Pause(paused) => {
                self.paused = paused;
                self.steps = 0;
                self.pace = Pace::new(self.pace.speed(), now());
            }
            Command::Step(ticks) if self.sortie.verdict.is_none() => {
                self.paused = true;
                self.steps = ticks;
            }
            // An ended flight has no next tick, and a restart flies on as the flight before began.
            Command::Step(_) => {}
            Command::Speed(speed) => self.pace = Pace::new(speed, now()),
            Command::Disturb(disturbance) => self.sortie.flight.disturb(&disturbance),
            Command::Restart { seed, scenario } => self.restart(seed, scenario, request.client),
        }
        self.state_due = now();
    }

    fn apply_changes(&mut self) {
        if self.changes.is_empty() {
            return;
        }
        let changes = std::mem::take(&mut self.changes);
        let Sortie { desk, flight, next_tick, .. } = &mut self.sortie;
        let applied = desk.apply(flight, changes, *next_tick);
        let (gains, preset) = (desk.list(flight.tuning()), desk.preset(flight.tuning()));
        self.hub.publish(|published| {
            published.gains = gains;
            published.preset = preset;
            let echoes = applied.echoes.into_iter().map(ServerMessage::Gain);
            echoes.chain(applied.list.map(ServerMessage::Gains)).collect()
        });
    }

    fn restart(&mut self, seed: Option<u64>, name: Option<String>, client: Option<u64>) {
        let named = name.and_then(|name| self.catalogue.iter().find(|known| known.name == name));
        let mut scenario = named.unwrap_or(&self.sortie.scenario).clone();
        if named.is_none() || seed.is_some() {
            scenario.settings.seed = seed.unwrap_or(self.sortie.scenario.settings.seed);
        }
        match Sortie::new(scenario) {
            Ok(sortie) => self.take_off(sortie),
            Err(error) => {
                self.hub.notice(client, NoticeLevel::Error, &format!("restart refused: {error}"));
            }
        }
    }

    fn take_off(&mut self, sortie: Sortie) {
        self.end_recording("");
        self.sortie = sortie;
        self.changes.clear();
        self.steps = 0;
        // Zero is left out, so that no frame of before is taken for one of now.
        self.schema_id = self.schema_id.wrapping_add(1).max(1);
        self.pace = Pace::new(self.pace.speed(), now());
        if let Err(error) = self.begin_recording() {
            self.alarm(&error.to_string());
        }
        let scenarios = self.hub.published().scenarios;
        let mut published = self.sortie.published(scenarios, self.pace.speed(), self.paused);
        published.schema_id = self.schema_id;
        self.hub.restart(published);
    }

    fn publish_events(&self, tick: &Tick) {
        let info = |event: &crate::tick::Event| EventInfo {
            tick: tick.index,
            t_s: tick.measurement.t_s,
            kind: event.kind,
            text: event.text.clone(),
        };
        if !tick.events.is_empty() {
            self.publish_event_infos(tick.events.iter().map(info).collect());
        }
    }

    fn publish_event_infos(&self, events: Vec<EventInfo>) {
        self.hub.publish(|published| {
            published.remember(&events);
            vec![ServerMessage::Events { events }]
        });
    }

    fn publish_state(&mut self) {
        let start = now();
        let reading = self.meter.read(start);
        self.hub.publish(|published| {
            self.sortie.describe(&mut published.state, self.pace.speed(), self.paused);
            published.state.real_time_factor = reading.real_time_factor;
            published.cost_ms = reading.cost_ms;
            vec![ServerMessage::State(published.state.clone())]
        });
        self.state_due = start + STATE_PERIOD;
    }

    fn begin_recording(&mut self) -> Result<(), ServerError> {
        if self.logbook.is_wanted() {
            let info = self.sortie.scenario.recording_info(self.sortie.flight.tuning())?;
            self.logbook.begin(&info)?;
        }
        Ok(())
    }

    fn end_recording(&mut self, verdict: &str) {
        let end = RecordingEnd {
            state_hash: self.sortie.flight.state_hash(),
            verdict: verdict.to_owned(),
        };
        match self.logbook.end(end) {
            Ok(Some(said)) => {
                tracing::info!("{said}");
                self.hub.notice(None, NoticeLevel::Info, &said);
            }
            Ok(None) => {}
            Err(error) => self.alarm(&error.to_string()),
        }
    }

    /// Tells the log and everybody that something is broken, though the flight goes on.
    fn alarm(&self, text: &str) {
        tracing::error!("{text}");
        self.hub.notice(None, NoticeLevel::Error, text);
    }
}

impl Drop for Pilot {
    /// Says that nobody flies any more, also if the flight failed.
    fn drop(&mut self) {
        self.hub.landed();
    }
}
