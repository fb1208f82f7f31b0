//! The protocol of the stock viser client. A frame to the client has many messages; a frame from the client has one `MessagePack`
//! message.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rmpv::Value;

use crate::server::App;
use crate::server::client::{Dialect, Frame, refuse_data, shown};
use crate::server::hub::Client;
use crate::server::outbox::{Message, OutboxContent};
use crate::server::protocol::{ClientMessage, EventInfo, ServerMessage};
use crate::server::published::Published;
use crate::server::socket::code;
use crate::server::telemetry::Telemetry;
use crate::server::viewers::attitude_marks::AttitudeMarks;
use crate::server::viewers::chart::History;
use crate::server::viewers::controls::Button;
use crate::server::viewers::pack::{self, map, numbers};
use crate::server::viewers::viewer_state::{ViewerState, understood};
use crate::server::viewers::viser_frame::Batch;
use crate::server::viewers::viser_move::Mover;
use crate::server::viewers::viser_panel::{self as panel, BUTTON, CHARTS, GAIN, SCENARIO, SHOW};
use crate::server::viewers::viser_scene as scene;
use twin_core::tick::EventKind;

/// The least time between two updates of the charts, s. It is long because an update sends the whole curves.
const CHART_PERIOD_S: f64 = 0.25;

/// Most notifications in a second. The rest is dropped, because notifications cover the scene.
const MOST_NOTIFICATIONS: u32 = 3;

/// Position of the camera, and the point at which it looks, in the world, m.
pub(super) const CAMERA_M: [f64; 3] = [2.6, -3.2, 2.2];
pub(super) const LOOK_AT_M: [f64; 3] = [0.5, 0.0, 0.7];

/// One connection of a viser client.
#[derive(Default)]
pub(in crate::server) struct Viser {
    state: Mutex<ViserState>,
}

#[derive(Default)]
struct ViserState {
    watched: ViewerState,
    /// Messages that move the nodes, in the order of the moving nodes.
    movers: Vec<Mover>,
    waymarks: AttitudeMarks,
    histories: Vec<History>,
    charts_stale: bool,
    charts_due_s: f64,
    notifications: u64,
    /// Second of the last notification, and the number of notifications in this second.
    recent: (f64, u32),
}

impl Dialect for Viser {
    const ONE_IN_FLIGHT: bool = true;

    fn compose(&self, parcel: OutboxContent, _: &Client, now_s: f64) -> Vec<Frame> {
        let mut batch = Batch::default();
        let mut state = self.state();
        for message in parcel.messages {
            match message {
                Message::Hello(published) => state.begin(&published, &mut batch),
                Message::Shared(told) => state.hear(&told.message, now_s, &mut batch),
            }
        }
        if let Some(telemetry) = parcel.telemetry {
            state.place(&telemetry, &mut batch);
        }
        if state.charts_stale && now_s >= state.charts_due_s {
            state.plot(&mut batch);
            state.charts_due_s = now_s + CHART_PERIOD_S;
        }
        let trails = state.watched.trails.due(now_s);
        if !trails.is_empty()
            && let Some(marks) = state.waymarks.news()
        {
            scene::update_marks(marks, &mut batch);
        }
        for (path, rgb, ends) in trails {
            scene::update_line(path, rgb, ends, &mut batch);
        }
        if let Some(arrows) = state.watched.forces.due(now_s) {
            scene::update_arrows(arrows, &mut batch);
        }
        for (path, visible) in state.watched.layers.changes() {
            batch.push(&scene::show(path, visible));
        }
        for (name, value) in state.watched.sliders.overdue(now_s) {
            batch.push(&panel::update(&format!("{GAIN}{name}"), "value", value.into()));
        }
        if batch.is_empty() { Vec::new() } else { vec![Frame::binary(batch.encode(now_s))] }
    }

    fn hear(&self, frame: &Frame, client: &Client, app: &App) {
        let Frame::Binary(bytes) = frame else {
            return refuse_data(code::UNSUPPORTED, "text, expected a binary message", client, app);
        };
        let Some(message) = understood(bytes, client, app) else { return };
        // The client also sends messages about its camera, clicks and drags.
        if pack::text(&message, "type") == Some("GuiUpdateMessage") {
            let id = pack::text(&message, "uuid").unwrap_or_default();
            let value = pack::get(&message, "updates").and_then(|map| pack::get(map, "value"));
            if let (Some(label), Some(visible)) =
                (id.strip_prefix(SHOW), value.and_then(Value::as_bool))
            {
                self.state().watched.layers.show(label, Some(visible));
                client.wake.notify_one();
                return;
            }
            if let Some(asked) = self.asked(id, value, app) {
                app.obey(asked, client);
            }
        }
    }
}

impl Viser {
    fn state(&self) -> MutexGuard<'_, ViserState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The request of an element of the panel that has a new `value`; `None` for an unknown element.
    fn asked(&self, id: &str, value: Option<&Value>, app: &App) -> Option<ClientMessage> {
        if let Some(name) = id.strip_prefix(GAIN) {
            let value = value.and_then(Value::as_f64).unwrap_or(f64::NAN);
            let value = self.state().watched.sliders.moved(name, value, app.uptime_s());
            return Some(ClientMessage::SetGain { name: shown(name, 64), value });
        }
        if let Some(name) = id.strip_prefix(BUTTON) {
            return Button::named(name).map(|button| button.asks(app.hub.phase()));
        }
        let scenario = value.and_then(Value::as_str).filter(|_| id == SCENARIO)?;
        Some(ClientMessage::Restart { seed: None, scenario: Some(shown(scenario, 64)) })
    }
}

impl ViserState {
    /// Draws the scene of a new flight; for a new client also sets the camera and builds the panel.
    fn begin(&mut self, published: &Published, batch: &mut Batch) {
        let first = self.watched.is_new();
        if first {
            for (kind, key, value) in [
                ("SetCameraPositionMessage", "position", CAMERA_M),
                ("SetCameraLookAtMessage", "look_at", LOOK_AT_M),
            ] {
                batch.push(&map! { "type" => kind, key => numbers(value), "initial" => true });
            }
            batch.push(&scene::light());
            panel::build(published, batch);
        } else {
            scene::erase(&self.watched.drawing, batch);
            batch.push(&panel::update(SCENARIO, "value", published.state.scenario.as_str().into()));
        }
        self.watched.begin(published);
        scene::draw(&self.watched.drawing, batch);
        scene::draw_live(batch);
        let moving = self.watched.drawing.moving.iter();
        self.movers = moving.map(|path| Mover::new(path)).collect();
        self.waymarks = AttitudeMarks::new(&published.channels);
        let history = |chart: &panel::Chart| {
            let names: Vec<&str> = chart.series.iter().map(|(name, ..)| *name).collect();
            History::new(&names, &published.channels)
        };
        self.histories = CHARTS.iter().map(history).collect();
        self.charts_stale = true;
        if first {
            batch.push(&map! { "type" => "ReplayDoneMessage" });
        }
    }

    fn hear(&mut self, message: &ServerMessage, now_s: f64, batch: &mut Batch) {
        match message {
            ServerMessage::State(state) => {
                batch.push(&panel::update_status(&panel::status(state)));
            }
            ServerMessage::Gain(echo) => self.watched.sliders.in_force(&echo.name, echo.value),
            ServerMessage::Gains(list) => self.watched.sliders.set(&list.gains),
            ServerMessage::Events { events } => {
                for event in events {
                    self.announce(event, now_s, batch);
                }
            }
            ServerMessage::Notice(notice) => {
                self.notify("not done", &notice.text, "orange", now_s, batch);
            }
            ServerMessage::Hello(_)
            | ServerMessage::Forks { .. }
            | ServerMessage::Pong { .. }
            | ServerMessage::Reset {} => {}
        }
    }

    fn announce(&mut self, event: &EventInfo, now_s: f64, batch: &mut Batch) {
        let (title, colour) = match event.kind {
            EventKind::Reset => ("covariance reset", "orange"),
            EventKind::Fault => ("fault", "red"),
            EventKind::Verdict => ("end of the flight", "blue"),
            _ => return,
        };
        let body = format!("t = {:.2} s: {}", event.t_s, event.text);
        self.notify(title, &body, colour, now_s, batch);
    }

    fn notify(&mut self, title: &str, body: &str, colour: &str, now_s: f64, batch: &mut Batch) {
        let (second, count) = self.recent;
        self.recent = if now_s.floor() > second { (now_s.floor(), 1) } else { (second, count + 1) };
        if self.recent.1 <= MOST_NOTIFICATIONS {
            self.notifications += 1;
            batch.push(&panel::notification(self.notifications, title, body, colour));
        }
    }

    /// Moves the nodes whose poses have changed, and adds the rows to trails, arrows, marks and charts.
    fn place(&mut self, telemetry: &Telemetry, batch: &mut Batch) {
        for (node, pose) in self.watched.moved(&telemetry.picture) {
            self.movers[node].place(pose, batch);
        }
        self.watched.extend(telemetry);
        self.waymarks.extend(telemetry);
        for history in &mut self.histories {
            self.charts_stale |= history.extend(telemetry);
        }
    }

    fn plot(&mut self, batch: &mut Batch) {
        for (chart, history) in CHARTS.iter().zip(&self.histories) {
            let columns = history.columns().into_iter();
            let data = columns.map(|column| batch.array("<f8", pack::f64_bytes(column))).collect();
            batch.push(&panel::update(chart.id, "data", Value::Array(data)));
        }
        self.charts_stale = false;
    }
}
