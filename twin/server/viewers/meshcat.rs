//! The stock MeshCat viewer: `MessagePack` commands, one a frame; its controls answer with Drake's events.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::extract::ws::Message as Frame;
use rmpv::Value;

use crate::mirror::scene::Scene;
use crate::server::App;
use crate::server::client::{Dialect, shown};
use crate::server::hub::{Client, Published};
use crate::server::outbox::{Message, Parcel};
use crate::server::protocol::{ClientMessage, ServerMessage};
use crate::server::viewers::controls::{Button, Sliders};
use crate::server::viewers::drawing::{Drawing, ROOT};
use crate::server::viewers::layers::{LAYERS, Layers};
use crate::server::viewers::meshcat_command::{
    button, delete, realtime_rate, set_control_value, set_property, show_realtime_rate, slider,
};
use crate::server::viewers::meshcat_object::{set_line_segments, set_object, set_transform};
use crate::server::viewers::pack::{self, map, numbers};
use crate::server::viewers::trail::Trails;

/// Most of a message's fault that a reason repeats, characters.
const REASON_CHARACTERS: usize = 80;

/// Start of the name of a button that shows or hides a layer; its label follows.
const TOGGLE: &str = "Show / hide ";

/// Path of the camera.
pub(super) const CAMERA: &str = "/Cameras/default/rotated/<object>";

/// Where the camera stands: beside the arena and above it, in the y-up frame of three.js, m.
pub(super) const CAMERA_Y_UP: [f64; 3] = [2.2, 2.0, 3.0];

/// One connection.
#[derive(Default)]
pub(in crate::server) struct MeshCat {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    drawing: Drawing,
    sliders: Sliders,
    layers: Layers,
    trails: Trails,
    /// Poses that the viewer was told, in the order of the moving nodes.
    told: Vec<[f32; 7]>,
}

impl Dialect for MeshCat {
    const GAP: Duration = Duration::from_millis(5);
    const ONE_IN_FLIGHT: bool = true;

    fn compose(&self, parcel: Parcel, _: &Client, now_s: f64) -> Vec<Frame> {
        let mut commands = Vec::new();
        let mut state = self.state();
        for message in parcel.messages {
            match message {
                Message::Hello(published) => state.begin(&published, &mut commands),
                Message::Told(told) => match &told.message {
                    ServerMessage::Gain(echo) => state.sliders.in_force(&echo.name, echo.value),
                    ServerMessage::Gains(list) => state.sliders.set(&list.gains),
                    // The stock viewer ignores types it does not know; programs may want the reason.
                    ServerMessage::Notice(notice) => {
                        commands.push(map! { "type" => "notice", "text" => notice.text.as_str() });
                    }
                    ServerMessage::State(state) => {
                        commands.push(realtime_rate(state.real_time_factor));
                    }
                    _ => {}
                },
            }
        }
        if let Some(telemetry) = parcel.telemetry {
            state.place(&telemetry.picture, &mut commands);
            state.trails.extend(&telemetry);
        }
        let trails = state.trails.due(now_s).into_iter();
        commands.extend(trails.map(|(path, rgb, ends)| set_line_segments(path, rgb, ends)));
        for (path, visible) in state.layers.changes() {
            commands.push(set_property(path, "visible", visible.into()));
        }
        for (name, value) in state.sliders.overdue(now_s) {
            commands.push(set_control_value(&name, value));
        }
        commands.iter().map(|command| Frame::binary(pack::encode(command))).collect()
    }

    fn hear(&self, frame: &Frame, client: &Client, app: &App) {
        // Text is an answer to a command that is never sent here.
        let Frame::Binary(bytes) = frame else { return };
        let event = match pack::decode(bytes) {
            Ok(event) => event,
            Err(why) => {
                let why = shown(&why, REASON_CHARACTERS);
                client.close(1007, format!("message not understood: {why}"));
                return;
            }
        };
        let name = pack::text(&event, "name").unwrap_or_default();
        match pack::text(&event, "type") {
            Some("slider") => {
                let value = pack::get(&event, "value").and_then(Value::as_f64);
                let value =
                    self.state().sliders.moved(name, value.unwrap_or(f64::NAN), app.uptime_s());
                app.obey(ClientMessage::SetGain { name: shown(name, 64), value }, client);
            }
            Some("button") => {
                if let Some(label) = name.strip_prefix(TOGGLE) {
                    self.state().layers.show(label, None);
                    client.wake.notify_one();
                } else if let Some(button) = Button::named(name) {
                    app.obey(button.asks(app.hub.phase()), client);
                }
            }
            // Drake's viewers also send gamepad and camera events.
            _ => {}
        }
    }
}

impl MeshCat {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Everything from nothing, or after a restart the new scene.
    fn begin(&mut self, published: &Published, commands: &mut Vec<Value>) {
        let first = self.sliders.is_empty();
        self.draw(&published.scene, commands);
        if first {
            commands.push(show_realtime_rate());
            commands.push(set_property(CAMERA, "position", numbers(CAMERA_Y_UP)));
            commands.extend(Button::ALL.iter().map(|(b, name)| button(name, b.key())));
            commands
                .extend(LAYERS.iter().map(|(label, _)| button(&format!("{TOGGLE}{label}"), None)));
            commands.extend(published.gains.iter().map(slider));
        }
        self.sliders.set(&published.gains);
        self.layers.drawn_anew();
        self.trails = Trails::new(&published.channels);
    }

    fn draw(&mut self, scene: &Scene, commands: &mut Vec<Value>) {
        self.drawing = Drawing::new(scene);
        commands.push(delete(ROOT));
        commands.extend(self.drawing.parts.iter().map(set_object));
        let nodes = self.drawing.nodes.iter();
        commands.extend(nodes.map(|node| set_transform(&node.path, node.pose)));
        self.told = vec![[f32::NAN; 7]; self.drawing.moving.len()];
    }

    /// Moves what has moved; what is in no known place stays.
    fn place(&mut self, picture: &crate::server::telemetry::Picture, commands: &mut Vec<Value>) {
        for ((path, pose), told) in self.drawing.poses(picture).zip(&mut self.told) {
            let known = pose.iter().all(|value| value.is_finite());
            if known && pose.map(f32::to_bits) != told.map(f32::to_bits) {
                commands.push(set_transform(path, pose));
                *told = pose;
            }
        }
    }
}
