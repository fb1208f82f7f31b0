//! The protocol of the stock MeshCat viewer: each frame has one command in `MessagePack`. The viewer's controls send the events
//! that Drake defined.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rmpv::Value;

use crate::server::App;
use crate::server::client::{Dialect, Frame, shown};
use crate::server::hub::Client;
use crate::server::outbox::{Message, OutboxContent};
use crate::server::protocol::{ClientMessage, ServerMessage};
use crate::server::published::Published;
use crate::server::telemetry::Picture;
use crate::server::viewers::controls::Button;
use crate::server::viewers::drawing::{Drawing, ROOT};
use crate::server::viewers::forces::ARROWS;
use crate::server::viewers::layers::LAYERS;
use crate::server::viewers::meshcat_command::{
    button, delete, picture_button, realtime_rate, set_control_value, set_property, set_target,
    show_realtime_rate, slider,
};
use crate::server::viewers::meshcat_object::{
    Mover, needle_matrix, set_line_segments, set_needle, set_object, set_transform,
};
use crate::server::viewers::pack::{self, map, numbers};
use crate::server::viewers::viewer_state::{ViewerState, understood};

/// Start of the name of a button that shows or hides a layer; its label follows.
const TOGGLE: &str = "Show / hide ";

/// Path of the camera.
pub(super) const CAMERA: &str = "/Cameras/default/rotated/<object>";

/// Position of the camera: beside the arena and above it, in the y-up frame of three.js, m.
pub(super) const CAMERA_Y_UP: [f64; 3] = [2.2, 2.0, 3.0];

/// Point at which the camera looks, in the same frame, m. The viewer of meshcat-python ignores it and looks at the origin.
pub(super) const TARGET_Y_UP: [f64; 3] = [0.5, 0.7, 0.0];

/// One connection of a MeshCat viewer.
#[derive(Default)]
pub(in crate::server) struct MeshCat {
    state: Mutex<MeshCatState>,
}

#[derive(Default)]
struct MeshCatState {
    watched: ViewerState,
    /// Commands that move the nodes, in the order of the moving nodes.
    movers: Vec<Mover>,
    pointers: Vec<Mover>,
}

/// Commands in the order in which they are sent; each becomes a frame.
#[derive(Default)]
struct Sheet(Vec<Frame>);

impl Sheet {
    fn push(&mut self, command: &Value) {
        self.push_encoded(pack::encode(command));
    }

    fn push_encoded(&mut self, command: Vec<u8>) {
        self.0.push(Frame::binary(command));
    }

    fn extend(&mut self, commands: impl Iterator<Item = Value>) {
        commands.for_each(|command| self.push(&command));
    }
}

impl Dialect for MeshCat {
    const ONE_IN_FLIGHT: bool = true;

    fn compose(&self, parcel: OutboxContent, _: &Client, now_s: f64) -> Vec<Frame> {
        let mut sheet = Sheet::default();
        let mut state = self.state();
        for message in parcel.messages {
            match message {
                Message::Hello(published) => state.begin(&published, &mut sheet),
                Message::Shared(told) => state.hear(&told.message, &mut sheet),
            }
        }
        if let Some(telemetry) = parcel.telemetry {
            state.place(&telemetry.picture, &mut sheet);
            state.watched.extend(&telemetry);
        }
        state.point(now_s, &mut sheet);
        let ViewerState { trails, layers, sliders, .. } = &mut state.watched;
        let trails = trails.due(now_s).into_iter();
        sheet.extend(trails.map(|(path, rgb, ends)| set_line_segments(path, rgb, ends)));
        let changes = layers.changes().into_iter();
        sheet.extend(changes.map(|(path, visible)| set_property(path, "visible", visible.into())));
        let overdue = sliders.overdue(now_s).into_iter();
        sheet.extend(overdue.map(|(name, value)| set_control_value(&name, value)));
        sheet.0
    }

    fn hear(&self, frame: &Frame, client: &Client, app: &App) {
        // A viewer sends text only as the answer to a command that this server never sends.
        let Frame::Binary(bytes) = frame else { return };
        let Some(event) = understood(bytes, client, app) else { return };
        let name = pack::text(&event, "name").unwrap_or_default();
        match pack::text(&event, "type") {
            Some("slider") => {
                let value = pack::get(&event, "value").and_then(Value::as_f64);
                let value = value.unwrap_or(f64::NAN);
                let value = self.state().watched.sliders.moved(name, value, app.uptime_s());
                app.obey(ClientMessage::SetGain { name: shown(name, 64), value }, client);
            }
            Some("button") => {
                if let Some(label) = name.strip_prefix(TOGGLE) {
                    self.state().watched.layers.show(label, None);
                    client.wake.notify_one();
                } else if let Some(button) = Button::named(name) {
                    app.obey(button.asks(app.hub.phase()), client);
                }
            }
            // Drake's viewer also sends events of gamepads and of the camera.
            _ => {}
        }
    }
}

impl MeshCat {
    fn state(&self) -> MutexGuard<'_, MeshCatState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MeshCatState {
    /// Draws the scene of a new flight; for a new client also sets the camera and creates the controls.
    fn begin(&mut self, published: &Published, sheet: &mut Sheet) {
        let first = self.watched.is_new();
        self.watched.begin(published);
        self.draw(sheet);
        if first {
            sheet.push(&show_realtime_rate());
            sheet.push(&set_property(CAMERA, "position", numbers(CAMERA_Y_UP)));
            sheet.push(&set_target(TARGET_Y_UP));
            sheet.push(&picture_button());
            sheet.extend(Button::ALL.iter().map(|(b, name)| button(name, b.key())));
            let layers = LAYERS.iter();
            sheet.extend(layers.map(|(label, _)| button(&format!("{TOGGLE}{label}"), None)));
            sheet.extend(published.gains.iter().map(slider));
        }
    }

    fn draw(&mut self, sheet: &mut Sheet) {
        let Drawing { parts, nodes, moving, .. } = &self.watched.drawing;
        sheet.push(&delete(ROOT));
        sheet.extend(parts.iter().map(set_object));
        sheet.extend(nodes.iter().map(|node| set_transform(&node.path, node.pose)));
        sheet.extend(ARROWS.iter().map(|(path, _, rgb, _)| set_needle(path, *rgb)));
        self.movers = moving.iter().map(|path| Mover::new(path)).collect();
        self.pointers = ARROWS.iter().map(|(path, ..)| Mover::new(path)).collect();
    }

    fn hear(&mut self, message: &ServerMessage, sheet: &mut Sheet) {
        match message {
            ServerMessage::Gain(echo) => self.watched.sliders.in_force(&echo.name, echo.value),
            ServerMessage::Gains(list) => self.watched.sliders.set(&list.gains),
            // The stock viewer ignores commands of unknown types; a program can read the reason in it.
            ServerMessage::Notice(notice) => {
                sheet.push(&map! { "type" => "notice", "text" => notice.text.as_str() });
            }
            ServerMessage::State(state) => sheet.push(&realtime_rate(state.real_time_factor)),
            _ => {}
        }
    }

    /// Moves the nodes whose poses have changed; a node with an unknown pose stays in place.
    fn place(&mut self, picture: &Picture, sheet: &mut Sheet) {
        for (node, pose) in self.watched.moved(picture) {
            sheet.push_encoded(self.movers[node].to(pose));
        }
    }

    /// Updates the arrows if an update is due.
    fn point(&mut self, now_s: f64, sheet: &mut Sheet) {
        let arrows = self.watched.forces.due(now_s).into_iter().flatten();
        for (pointer, arrow) in self.pointers.iter().zip(arrows) {
            sheet.push_encoded(pointer.to_matrix(needle_matrix(arrow)));
        }
    }
}
