//! The topics of the server. Poses, rows and events become the same topics that a recording has, and each row becomes JSON.

use std::collections::BTreeMap;
use std::sync::Arc;

use foxglove::messages::{FrameTransforms, JointStates, Log, SceneUpdate};
use foxglove::{Channel, ChannelBuilder, Context, PartialMetadata, RawChannel, Schema};
use serde_json::{Map, Value, json};

use crate::server::protocol::{ChannelInfo, EventInfo};
use crate::server::published::Published;
use crate::server::telemetry::{Picture, Telemetry};
use twin_core::notation::TICK_S;
use twin_core::tick::{Contact, Pose};
use twin_record::scene::Scene;
use twin_record::views::{self, Joint};
use twin_scenario::VehicleFiles;

/// The bodies are published again after this many ticks, as in a recording.
const BODIES_PERIOD_TICKS: u64 = 100;

/// Simulated time as the protocol carries it, ns.
pub(super) fn nanoseconds(t_s: f64) -> u64 {
    (t_s.max(0.0) * 1e9).round() as u64
}

fn at(t_s: f64) -> PartialMetadata {
    PartialMetadata { log_time: Some(nanoseconds(t_s)) }
}

/// All topics of the server.
pub(super) struct Topics {
    context: Arc<Context>,
    transforms: Channel<FrameTransforms>,
    scene: Channel<SceneUpdate>,
    joints: Channel<JointStates>,
    log: Channel<Log>,
    rows: Option<Rows>,
    vehicles: Arc<BTreeMap<String, VehicleFiles>>,
    /// Names of the joints of a mirrored recording; used if the scenario has no vehicle of its own.
    recorded_joints: Vec<String>,
    flight: Option<Arc<Published>>,
    newest: Option<Arc<Picture>>,
}

/// The topic of the telemetry rows, and the indices of a row's numbers.
struct Rows {
    channel: Arc<RawChannel>,
    channels: Arc<Vec<ChannelInfo>>,
    /// Indices of the angle and the torque of both arm joints.
    joints: [[Option<usize>; 2]; 2],
}

impl Topics {
    /// Topics without messages.
    pub(super) fn new(
        context: &Arc<Context>,
        vehicles: Arc<BTreeMap<String, VehicleFiles>>,
        recorded_joints: Vec<String>,
    ) -> Self {
        Self {
            context: Arc::clone(context),
            transforms: ChannelBuilder::new("/tf").context(context).build(),
            scene: ChannelBuilder::new("/scene").context(context).build(),
            joints: ChannelBuilder::new("/joint_states").context(context).build(),
            log: ChannelBuilder::new("/log").context(context).build(),
            rows: None,
            vehicles,
            recorded_joints,
            flight: None,
            newest: None,
        }
    }

    /// Takes the description of a flight, at its begin or after the outbox was full.
    pub(super) fn begin(&mut self, published: &Arc<Published>) {
        let known = self.rows.as_ref().is_some_and(|rows| rows.channels == published.channels);
        if !known {
            if let Some(old) = self.rows.take() {
                old.channel.close();
            }
            self.rows = Rows::new(&self.context, &published.channels);
        }
        self.flight = Some(Arc::clone(published));
        self.newest = None;
        self.draw(published.state.t_s);
    }

    /// Publishes the bodies and their poses again, for a client that has just subscribed.
    pub(super) fn repeat(&self) {
        let Some(picture) = &self.newest else {
            return self.draw(self.flight.as_ref().map_or(0.0, |flight| flight.state.t_s));
        };
        self.draw(picture.t_s);
        self.place(picture);
    }

    /// Publishes events as log lines.
    pub(super) fn log(&self, events: &[EventInfo]) {
        for event in events {
            let line = views::log_line(event.t_s, event.kind, &event.text);
            self.log.log_with_meta(&line, at(event.t_s));
        }
    }

    /// Publishes rows, and the newest poses and contacts.
    pub(super) fn publish(&mut self, telemetry: &Telemetry) {
        let ticks = telemetry.first_tick..telemetry.first_tick + telemetry.rows.len() as u64;
        for (tick, row) in ticks.clone().zip(&telemetry.rows) {
            self.row(tick as f64 * TICK_S, row);
        }
        if ticks.clone().any(|tick| tick.is_multiple_of(BODIES_PERIOD_TICKS)) {
            self.draw(telemetry.picture.t_s);
        }
        self.place(&telemetry.picture);
        self.newest = Some(Arc::clone(&telemetry.picture));
    }

    fn draw(&self, t_s: f64) {
        if let Some(scene) = self.scene_to_draw().filter(|_| self.scene.has_sinks()) {
            self.scene.log_with_meta(&views::bodies_at(scene, t_s), at(t_s));
        }
    }

    fn scene_to_draw(&self) -> Option<&Scene> {
        self.flight.as_ref().map(|flight| &*flight.scene)
    }

    fn place(&self, picture: &Picture) {
        let Some(scene) = self.scene_to_draw() else { return };
        if self.transforms.has_sinks() {
            let poses = picture.poses.iter().map(pose);
            let transforms = views::transforms_at(scene, picture.t_s, poses);
            self.transforms.log_with_meta(&transforms, at(picture.t_s));
        }
        if self.scene.has_sinks() {
            let contacts = picture.contacts.iter().map(|values| {
                let [x, y, z, fx, fy, fz] = values.map(f64::from);
                Contact { point_in_world: [x, y, z], force_in_world_n: [fx, fy, fz] }
            });
            let arrows = views::contacts_at(picture.t_s, contacts);
            self.scene.log_with_meta(&arrows, at(picture.t_s));
        }
    }

    fn row(&self, t_s: f64, row: &[f32]) {
        let Some(rows) = &self.rows else { return };
        if rows.channel.has_sinks() {
            let object = nested(&rows.channels, t_s, row).to_string();
            rows.channel.log_with_meta(object.as_bytes(), at(t_s));
        }
        let names = self.joint_names();
        if !names.is_empty() && self.joints.has_sinks() {
            let known = |place: Option<usize>| {
                let value = f64::from(*row.get(place?)?);
                value.is_finite().then_some(value)
            };
            let joints = rows.joints.map(|[angle, torque]| Joint {
                position_rad: known(angle),
                velocity_rad_s: None,
                torque_n_m: known(torque),
            });
            self.joints.log_with_meta(&views::joint_states_at(names, t_s, joints), at(t_s));
        }
    }

    /// Names of the joints of the vehicle in flight, or of the mirrored recording.
    fn joint_names(&self) -> &[String] {
        let scenario = self.flight.as_ref().map(|flight| &flight.state.scenario);
        let vehicle = scenario.and_then(|scenario| self.vehicles.get(scenario));
        vehicle.map_or(&self.recorded_joints, |vehicle| &vehicle.joints)
    }
}

impl Rows {
    fn new(context: &Arc<Context>, channels: &Arc<Vec<ChannelInfo>>) -> Option<Self> {
        let place = |name: String| channels.iter().position(|info| info.name == name);
        let schema = Schema::new("twin.Telemetry", "jsonschema", schema(channels).into_bytes());
        let channel = ChannelBuilder::new("/twin/telemetry")
            .context(context)
            .message_encoding("json")
            .schema(schema)
            .build_raw()
            .inspect_err(|error| {
                tracing::error!("cannot create the topic /twin/telemetry: {error}");
            })
            .ok()?;
        let joints = [1, 2]
            .map(|joint| [format!("chi.q{joint}"), format!("joint_torque.{joint}")].map(place));
        Some(Self { channel, channels: Arc::clone(channels), joints })
    }
}

fn pose(values: &[f32; 7]) -> Option<Pose> {
    let [x, y, z, qw, qx, qy, qz] = values.map(f64::from);
    let known = values.iter().all(|value| value.is_finite());
    known.then_some(Pose { position: [x, y, z], quaternion_wxyz: [qw, qx, qy, qz] })
}

/// Group and key of a channel in the JSON object. `residual.x` is the key `x` in the group `residual`. `rotor.0` becomes the
/// single key `rotor_0`, because the path of a plot allows no key that is a number.
fn path(name: &str) -> (String, Option<&str>) {
    match name.split_once('.') {
        Some((stem, key)) if key.starts_with(|c: char| c.is_ascii_digit()) => {
            (format!("{stem}_{key}"), None)
        }
        Some((stem, key)) => (stem.to_owned(), Some(key)),
        None => (name.to_owned(), None),
    }
}

fn insert(map: &mut Map<String, Value>, name: &str, value: Value) {
    match path(name) {
        (stem, None) => {
            map.insert(stem, value);
        }
        (stem, Some(key)) => {
            if let Value::Object(inner) = map.entry(stem).or_insert_with(|| json!({})) {
                inner.insert(key.to_owned(), value);
            }
        }
    }
}

/// A row as a JSON object; an unknown number is null.
fn nested(channels: &[ChannelInfo], t_s: f64, row: &[f32]) -> Value {
    let mut map = Map::new();
    map.insert("t_s".to_owned(), json!(t_s));
    for (info, value) in channels.iter().zip(row) {
        insert(&mut map, &info.name, json!(value));
    }
    Value::Object(map)
}

/// The JSON schema of [`nested`].
fn schema(channels: &[ChannelInfo]) -> String {
    let mut map = Map::new();
    map.insert("t_s".to_owned(), json!({ "type": "number", "description": "simulated time, s" }));
    for info in channels {
        let description = format!("{}, {}", info.label, info.unit);
        let number = json!({ "type": "number", "description": description });
        insert(&mut map, &info.name, number);
    }
    let group = |value: &Value| value.get("type").is_none();
    for value in map.values_mut().filter(|value| group(value)) {
        *value = json!({ "type": "object", "properties": value.take() });
    }
    json!({ "type": "object", "properties": map }).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(name: &str) -> ChannelInfo {
        ChannelInfo {
            name: name.to_owned(),
            label: "a label".to_owned(),
            group: String::new(),
            unit: "N".to_owned(),
            row: None,
            limits: None,
            z_scale: None,
            weight: None,
        }
    }

    #[test]
    fn a_row_is_an_object_that_its_schema_describes_key_by_key() {
        let channels = ["residual.x", "residual.z", "frozen", "rotor.0"].map(channel);
        let object = nested(&channels, 0.25, &[1.5, f32::NAN, 1.0, -2.0]);
        let wanted = json!({
            "t_s": 0.25, "residual": { "x": 1.5, "z": null }, "frozen": 1.0, "rotor_0": -2.0,
        });
        assert_eq!(object, wanted);
        let schema: Value = serde_json::from_str(&schema(&channels)).expect("JSON");
        let properties = |value: &Value| value["properties"].as_object().cloned().expect("a map");
        let outer = properties(&schema);
        assert!(outer.keys().eq(object.as_object().expect("a map").keys()));
        assert!(properties(&outer["residual"]).keys().eq(["x", "z"]));
        assert_eq!(outer["rotor_0"]["type"], "number");
    }

    #[test]
    fn poses_that_nobody_knows_are_left_out() {
        assert!(pose(&[f32::NAN; 7]).is_none());
        assert!(pose(&[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]).is_some());
    }
}
