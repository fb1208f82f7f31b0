//! The only thread that flies. It takes requests between two ticks and publishes each tick. It waits for the clock only, and
//! never for a socket, a disk or a client.

mod planning;
mod recording;
mod recorder;
mod forking;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use crate::server::ServerError;
use crate::server::agenda::Agenda;
use crate::server::command::{Command, Request};
use crate::server::flight_recorder::FlightRecorder;
use crate::server::forks::Forks;
use crate::server::gains::Change;
use crate::server::hub::Hub;
use crate::server::mirrored::Mirrored;
use crate::server::pace::{Lateness, Meter, Pace, STAGES, now};
use crate::server::protocol::{EventInfo, NoticeLevel, ScenarioInfo, ServerMessage, StageCost};
use crate::server::served_flight::{ServedFlight, word};
use twin_core::tick::{EventKind, Tick};
use twin_scenario::Scenario;

/// The state is published at least this often, and the thread looks at its requests at least this often.
const STATE_PERIOD: Duration = Duration::from_millis(400);

/// [`STATE_PERIOD`] of a live flight. It is shorter, so that operators learn of a lost stream within half a second.
const LIVE_STATE_PERIOD: Duration = Duration::from_millis(100);

/// If the next tick of a live flight has not arrived, the thread looks for it again after this time.
const EDGE_PATIENCE: Duration = Duration::from_millis(5);

/// The first flight, and the scenarios and settings of the flights after it.
pub(super) struct PilotOptions {
    /// First flight.
    pub mission: FirstFlight,
    /// Scenarios that the command `restart` may name.
    pub catalogue: Vec<Scenario>,
    /// Simulated seconds per second; `None` is as fast as the machine can.
    pub speed: Option<f64>,
    /// Whether the first flight waits until an operator starts it.
    pub start_paused: bool,
    /// Records the flights.
    pub flight_recorder: FlightRecorder,
    /// The least time between two restarts.
    pub restart_gap: Duration,
}

/// The kind of the first flight.
pub(super) enum FirstFlight {
    /// A simulated flight of a scenario.
    Fly(Box<Scenario>),
    /// A mirrored flight.
    Mirror {
        /// The recording.
        mirrored: Arc<Mirrored>,
        /// Time of the recording at which the mirrored flight starts, s.
        start_s: f64,
    },
}

/// The state of the flying thread.
pub(super) struct Pilot {
    served: ServedFlight,
    catalogue: Vec<Scenario>,
    hub: Arc<Hub>,
    flight_recorder: FlightRecorder,
    pace: Pace,
    meter: Meter,
    lateness: Lateness,
    paused: bool,
    steps: u32,
    /// Number of ticks before the target of a seek that the thread must still fly, without pauses.
    warm_up: usize,
    changes: Vec<Change>,
    agenda: Agenda,
    forks: Forks,
    state_due: Instant,
    schema_id: u16,
}

impl Pilot {
    /// Builds the first flight and the hub that publishes it, and begins the recording.
    ///
    /// # Errors
    /// [`ServerError`] if the scenario cannot be built or the recording cannot be created.
    pub(super) fn new(orders: PilotOptions) -> Result<Self, ServerError> {
        let PilotOptions { mission, catalogue, speed, start_paused, flight_recorder, restart_gap } =
            orders;
        let (served, warm_up) = match mission {
            FirstFlight::Fly(scenario) => (ServedFlight::new(*scenario)?, 0),
            FirstFlight::Mirror { mirrored, start_s } => {
                let (first, warm_up) = mirrored.run_up(start_s);
                (ServedFlight::mirror(&mirrored, first, mirrored.shadow.tuning())?, warm_up)
            }
        };
        let infos = catalogue.iter().map(|known| ScenarioInfo {
            name: known.name.clone(),
            title: known.settings.title.clone(),
        });
        let published = served.published(Arc::new(infos.collect()), speed, start_paused);
        let start = now();
        let hub = Arc::new(Hub::new(published));
        let mut pilot = Self {
            forks: Forks::new(&hub)?,
            served,
            catalogue,
            agenda: Agenda::new(restart_gap, Arc::clone(&hub.tally)),
            hub,
            flight_recorder,
            pace: Pace::new(speed, start),
            meter: Meter::new(start),
            lateness: Lateness::default(),
            paused: start_paused,
            steps: 0,
            warm_up,
            changes: Vec::new(),
            state_due: start,
            schema_id: 1,
        };
        pilot.begin_recording()?;
        Ok(pilot)
    }

    /// The hub that publishes the flight.
    pub(super) fn hub(&self) -> Arc<Hub> {
        Arc::clone(&self.hub)
    }

    /// Flies until `stop` is set or all senders of requests are dropped. Returns whether every recording is whole.
    pub(super) fn fly(mut self, requests: &Receiver<Request>, stop: &AtomicBool) -> bool {
        self.pace = Pace::new(self.pace.speed(), now());
        while !stop.load(Ordering::Relaxed) {
            match requests.recv_timeout(self.patience()) {
                Ok(first) => {
                    self.plan(first);
                    for request in requests.try_iter() {
                        self.plan(request);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            while let Some(request) = self.agenda.next(now()) {
                self.handle(request);
            }
            self.apply_changes();
            if self.warm_up > 0 {
                self.warm_up();
            } else if self.is_flying()
                && !self.is_ahead()
                && (self.steps > 0 || self.pace.wait(now()).is_zero())
            {
                self.tick();
            }
            if now() >= self.state_due {
                self.attend();
                self.publish_state();
            }
        }
        self.end_recording(&self.landing());
        let news = self.flight_recorder.close();
        self.publish_news(news);
        !self.flight_recorder.has_failed()
    }

    /// Flies all ticks before the target of a seek. The hub wakes the clients only after the last of them.
    fn warm_up(&mut self) {
        self.hub.hold();
        for _ in 0..std::mem::take(&mut self.warm_up) {
            self.tick();
        }
        self.hub.release();
        self.pace = Pace::new(self.pace.speed(), now());
        self.publish_state();
    }

    fn is_flying(&self) -> bool {
        self.served.verdict.is_none() && (!self.paused || self.steps > 0)
    }

    /// The longest time for which the thread may wait for a request.
    fn patience(&self) -> Duration {
        let now = now();
        let state = self.state_due.saturating_duration_since(now);
        let state = self.agenda.patience(now).map_or(state, |due| due.min(state));
        match (self.is_flying(), self.steps) {
            (false, _) => state,
            _ if self.is_ahead() => EDGE_PATIENCE.min(state),
            (true, 0) => self.pace.wait(now).min(state),
            (true, _) => Duration::ZERO,
        }
    }

    fn tick(&mut self) {
        self.hub.set_ticking(true);
        self.forks.before_tick(&self.served);
        let (mut spent, mut last) = ([Duration::ZERO; STAGES.len()], now());
        self.lateness.count(self.pace.late(last));
        let mut lap = |stage: usize| {
            let done = now();
            spent[stage] += done - last;
            last = done;
            done
        };
        let tick = Arc::new(self.served.flight.tick_with(&mut |stage| {
            lap(stage as usize);
        }));
        self.served.follow(&tick);
        self.served.settle_gains();
        self.steps = self.steps.saturating_sub(1);
        if let Some(failure) = self.flight_recorder.tick(&tick) {
            self.alarm(&format!("{failure}; the flight goes on"));
            self.state_due = now();
        }
        self.hub.tick(&tick, || self.served.draw(&tick));
        self.publish_events(&tick);
        if self.served.task_phase != tick.phase {
            self.served.task_phase.clone_from(&tick.phase);
            self.state_due = now();
        }
        self.judge(&tick);
        let done = lap(STAGES.len() - 1);
        self.pace.ticked(done);
        self.meter.count(spent);
        self.hub.set_ticking(false);
    }

    fn judge(&mut self, tick: &Tick) {
        if self.served.mirrored.is_some() {
            // A mirrored flight has no verdict. At its end it pauses until somebody plays it again.
            self.paused |= tick.finished;
            self.steps *= u32::from(!tick.finished);
            self.state_due = if tick.finished { now() } else { self.state_due };
        } else if let Some((verdict, reason)) = self.served.judge.watch(tick) {
            self.end(word(&verdict), reason);
        }
    }

    fn end(&mut self, verdict: String, reason: String) {
        let event = EventInfo {
            tick: self.served.next_tick.saturating_sub(1),
            t_s: self.served.t_s,
            kind: EventKind::Verdict,
            text: format!("{verdict}: {reason}"),
        };
        self.publish_event_infos(vec![event]);
        self.end_recording(&format!("{verdict}: {reason}"));
        self.served.verdict = Some((verdict, reason));
        self.steps = 0;
        self.publish_state();
    }

    fn handle(&mut self, request: Request) {
        match request.command {
            Command::Change(change) => self.changes.push(change),
            Command::Pause(paused) => {
                if !paused && self.is_at_end() {
                    self.seek(0.0, request.client);
                }
                self.paused = paused;
                self.steps = 0;
                self.pace = Pace::new(self.pace.speed(), now());
            }
            Command::Step(ticks) if self.served.verdict.is_none() && !self.is_at_end() => {
                self.paused = true;
                self.steps = ticks;
            }
            // An ended flight has no next tick. A step must not pause it either, because a restart keeps the pause.
            Command::Step(_) => {}
            Command::Speed(speed) => self.pace = Pace::new(speed, now()),
            Command::Disturb(disturbance) => {
                let goes_on = self.served.disturb(&disturbance);
                self.forks.disturbed(self.served.next_tick, disturbance, goes_on);
            }
            Command::Fork(asked) => self.fork(asked, request.client),
            Command::NameFork { id, name } => self.change_fork(id, Some(&name), request.client),
            Command::DropFork(id) => self.change_fork(id, None, request.client),
            Command::Seek(t_s) => self.seek(t_s, request.client),
            Command::Restart { seed, scenario } => self.restart(seed, scenario, request.client),
        }
        self.state_due = now();
    }

    fn restart(&mut self, seed: Option<u64>, name: Option<String>, client: Option<u64>) {
        let named = name.and_then(|name| self.catalogue.iter().find(|known| known.name == name));
        let mut scenario = named.unwrap_or(&self.served.scenario).clone();
        if named.is_none() || seed.is_some() {
            scenario.settings.seed = seed.unwrap_or(self.served.scenario.settings.seed);
        }
        match ServedFlight::new(scenario) {
            Ok(served) => self.take_off(served),
            Err(error) => {
                self.hub.notice(client, NoticeLevel::Error, &format!("restart refused: {error}"));
            }
        }
    }

    fn take_off(&mut self, served: ServedFlight) {
        self.end_recording("");
        self.served = served;
        self.lateness = Lateness::default();
        self.changes.clear();
        self.steps = 0;
        // A new identifier lets clients tell frames of the last flight from frames of this one; zero is no identifier.
        self.schema_id = self.schema_id.wrapping_add(1).max(1);
        self.pace = Pace::new(self.pace.speed(), now());
        if let Err(error) = self.begin_recording() {
            self.alarm(&error.to_string());
        }
        self.forks.start_over();
        let (scenarios, forks) = {
            let published = self.hub.published();
            (published.scenarios, published.forks)
        };
        let mut published = self.served.published(scenarios, self.pace.speed(), self.paused);
        published.schema_id = self.schema_id;
        published.forks = forks;
        self.hub.restart(published);
    }

    fn publish_events(&self, tick: &Tick) {
        let info = |event: &twin_core::tick::Event| EventInfo {
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
        self.served.unreadable().iter().for_each(|text| self.alarm(text));
        let news = self.flight_recorder.news();
        self.publish_news(news);
        let start = now();
        let reading = self.meter.read(start);
        self.hub.publish(|published| {
            self.served.describe(&mut published.state, self.pace.speed(), self.paused);
            published.state.real_time_factor = reading.real_time_factor;
            published.lateness = self.lateness;
            published.state.recording = self.flight_recorder.status();
            published.state.stages = STAGES
                .into_iter()
                .zip(reading.cost_ms)
                .map(|(name, ms)| StageCost { name: name.to_owned(), ms })
                .collect();
            vec![ServerMessage::State(published.state.clone())]
        });
        let live = self.served.mirrored.as_ref().is_some_and(|mirrored| mirrored.is_live());
        self.state_due = start + if live { LIVE_STATE_PERIOD } else { STATE_PERIOD };
    }

    /// Writes an error to the log and shows it to all clients; the flight goes on.
    fn alarm(&self, text: &str) {
        tracing::error!("{text}");
        self.hub.notice(None, NoticeLevel::Error, text);
    }
}

impl Drop for Pilot {
    /// Tells the hub that no thread flies any more, also after a panic.
    fn drop(&mut self) {
        self.hub.landed();
    }
}
