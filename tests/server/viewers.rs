//! The protocols of the stock viewers on the wire, written by hand: clients that join late, slow and hostile clients, and one set of
//! gains for all of them.

use std::net::{SocketAddr, TcpStream};

use rmpv::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use super::console::{Console, api, http, serve};
use crate::patience::{PATIENCE, Patience};

pub(super) struct Viewer {
    socket: WebSocket<TcpStream>,
    /// Whether messages arrive in viser's frames, which hold several messages.
    framed: bool,
}

impl Viewer {
    fn connect(address: SocketAddr, path: &str, origin: Option<&str>) -> Result<Self, u16> {
        let stream = TcpStream::connect(address).expect("the server listens");
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut request = format!("ws://{address}{path}").into_client_request().unwrap();
        if path == "/viser" {
            let protocol = "viser-v1.1.1".parse().unwrap();
            request.headers_mut().insert("Sec-WebSocket-Protocol", protocol);
        }
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Self { socket, framed: path == "/viser" }),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
                Err(response.status().as_u16())
            }
            Err(other) => panic!("{other}"),
        }
    }

    pub(super) fn meshcat(address: SocketAddr) -> Self {
        Self::connect(address, "/", None).expect("a connection")
    }

    fn viser(address: SocketAddr) -> Self {
        Self::connect(address, "/viser", None).expect("a connection")
    }

    fn send(&mut self, value: &Value) {
        let mut bytes = Vec::new();
        rmpv::encode::write_value(&mut bytes, value).unwrap();
        self.socket.send(Message::binary(bytes)).expect("the server reads");
    }

    /// The messages of the next frame, of either protocol; if the connection was closed, its code and reason.
    fn next(&mut self) -> Result<Vec<Value>, Option<(u16, String)>> {
        match self.socket.read() {
            Ok(Message::Binary(bytes)) if !self.framed => {
                Ok(vec![rmpv::decode::read_value(&mut &bytes[..]).expect("MessagePack")])
            }
            Ok(Message::Binary(bytes)) => {
                let length =
                    |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
                let packed = &bytes[16..16 + length(8)];
                let inner = zstd::bulk::decompress(packed, length(0)).expect("zstd");
                let map = rmpv::decode::read_value(&mut &inner[..]).expect("MessagePack");
                Ok(field(&map, "messages").as_array().expect("messages").clone())
            }
            Ok(Message::Close(frame)) => {
                Err(frame.map(|frame| (u16::from(frame.code), frame.reason.to_string())))
            }
            Ok(_) => Ok(Vec::new()),
            Err(tungstenite::Error::Io(error))
                if error.kind() == std::io::ErrorKind::WouldBlock =>
            {
                panic!("nothing arrived for {PATIENCE:?}")
            }
            Err(_) => Err(None),
        }
    }

    /// All messages up to and including the first for which `fits` is true.
    pub(super) fn until(&mut self, fits: impl Fn(&Value) -> bool) -> Vec<Value> {
        let (patience, mut seen) = (Patience::new(), Vec::new());
        while patience.lasts() {
            for message in self.next().expect("the connection stays open") {
                let found = fits(&message);
                seen.push(message);
                if found {
                    return seen;
                }
            }
        }
        panic!("not within {PATIENCE:?}");
    }

    fn until_closed(&mut self) -> Option<(u16, String)> {
        loop {
            if let Err(why) = self.next() {
                return why;
            }
        }
    }
}

pub(super) fn field<'a>(map: &'a Value, key: &str) -> &'a Value {
    const NIL: &Value = &Value::Nil;
    let entries = map.as_map().map_or(&[][..], Vec::as_slice);
    entries.iter().find(|(name, _)| name.as_str() == Some(key)).map_or(NIL, |(_, value)| value)
}

pub(super) fn is(message: &Value, kind: &str) -> bool {
    field(message, "type").as_str() == Some(kind)
}

fn map(entries: &[(&str, Value)]) -> Value {
    Value::Map(entries.iter().map(|(key, value)| (Value::from(*key), value.clone())).collect())
}

fn slider(name: &str, value: f64) -> Value {
    map(&[("type", "slider".into()), ("name", name.into()), ("value", value.into())])
}

fn gui(uuid: &str, value: Value) -> Value {
    let updates = map(&[("value", value)]);
    map(&[("type", "GuiUpdateMessage".into()), ("uuid", uuid.into()), ("updates", updates)])
}

fn gain(address: SocketAddr, name: &str) -> f64 {
    let gains = api(address, "/api/gains");
    let found = gains["gains"].as_array().unwrap().iter().find(|gain| gain["name"] == name);
    found.expect(name)["value"].as_f64().unwrap()
}

#[test]
fn a_late_joiner_is_told_every_body_every_slider_and_the_newest_poses() {
    let running = serve();
    let address = running.address();
    let mut console = Console::connect(address);
    let hello = console.message("hello");
    while console.frame().after() < 30 {}
    console.send(r#"{"type":"pause","paused":true}"#);
    console.message_that("state", |state| state["phase"] == "paused");
    let gains = hello["gains"].as_array().unwrap().len();
    let bodies = hello["scene"]["bodies"].as_array().unwrap();

    let mut meshcat = Viewer::meshcat(address);
    // The pose of the reference is the last message of a paused flight.
    let ghost =
        |m: &Value| is(m, "set_transform") && field(m, "path").as_str() == Some("/twin/reference");
    let mut seen = meshcat.until(ghost);
    seen.extend(meshcat.until(ghost));
    let sliders = seen.iter().filter(|m| is(m, "set_control") && *field(m, "value") != Value::Nil);
    assert_eq!(sliders.count(), gains);
    // The names of static bodies may not be valid paths.
    for body in bodies.iter().filter(|body| body["moving"] == true) {
        let path = format!("/twin/{}", body["name"].as_str().unwrap());
        let moved = |m: &&Value| is(m, "set_transform") && field(m, "path").as_str() == Some(&path);
        // The server sends the initial pose and the present pose.
        assert_eq!(seen.iter().filter(moved).count(), 2, "{path}");
    }

    let mut viser = Viewer::viser(address);
    let seen = viser.until(|m| is(m, "ReplayDoneMessage"));
    assert_eq!(seen.iter().filter(|m| is(m, "GuiSliderMessage")).count(), gains);
    assert!(seen.iter().filter(|m| is(m, "FrameMessage")).count() > bodies.len());
}

#[test]
fn a_slider_of_each_viewer_reaches_the_gains_and_the_other_clients() {
    let running = serve();
    let address = running.address();
    let mut console = Console::connect(address);
    let (mut meshcat, mut viser) = (Viewer::meshcat(address), Viewer::viser(address));
    meshcat.until(|m| is(m, "set_control"));
    viser.until(|m| is(m, "ReplayDoneMessage"));

    meshcat.send(&slider("slope.x", 1.5));
    console.message_that("gain", |echo| echo["name"] == "slope.x" && echo["value"] == 1.5);
    assert!((gain(address, "slope.x") - 1.5).abs() < f64::EPSILON);
    let told = viser
        .until(|m| is(m, "GuiUpdateMessage") && field(m, "uuid").as_str() == Some("gain.slope.x"));
    assert_eq!(field(field(told.last().unwrap(), "updates"), "value").as_f64(), Some(1.5));

    viser.send(&gui("gain.slope.y", 2.5.into()));
    console.message_that("gain", |echo| echo["name"] == "slope.y" && echo["value"] == 2.5);
    let shows = |name: &'static str, value: f64| {
        move |m: &Value| {
            is(m, "set_control_value")
                && field(m, "name").as_str() == Some(name)
                && field(m, "value").as_f64() == Some(value)
                && *field(m, "invoke_callback") == Value::Boolean(false)
        }
    };
    meshcat.until(shows("slope.y", 2.5));
    console.send(r#"{"type":"set_gain","name":"slope.z","value":3.5}"#);
    meshcat.until(shows("slope.z", 3.5));

    meshcat.send(&map(&[("type", "button".into()), ("name", "Pause / Continue".into())]));
    console.message_that("state", |state| state["phase"] == "paused");
    viser.send(&gui("button.Pause / Continue", true.into()));
    console.message_that("state", |state| state["phase"] == "flying");
    viser.send(&gui("scenario", "a_300g_slow".into()));
    console.message_that("hello", |hello| hello["scenario"] == "a_300g_slow");
}

fn visibility<'a>(message: &'a Value, path: &str) -> Option<&'a Value> {
    let hides =
        is(message, "set_property") && field(message, "property").as_str() == Some("visible");
    let meshcat = hides && field(message, "path").as_str() == Some(path);
    let viser = is(message, "SetSceneNodeVisibilityMessage")
        && field(message, "name").as_str() == Some(path);
    match (meshcat, viser) {
        (true, _) => Some(field(message, "value")),
        (_, true) => Some(field(message, "visible")),
        _ => None,
    }
}

#[test]
fn trails_follow_the_flight_within_a_bounded_number_of_points() {
    let running = serve();
    let flown = "/twin/trails/flown";
    let mut meshcat = Viewer::meshcat(running.address());
    let drawn =
        |m: &Value| is(m, "set_object") && field(m, "path").as_str() == Some("/twin/trails/flown");
    let mut lengths = Vec::new();
    for _ in 0..3 {
        let seen = meshcat.until(drawn);
        let object = field(seen.last().unwrap(), "object");
        let geometry = &field(object, "geometries").as_array().unwrap()[0];
        let position = field(field(field(geometry, "data"), "attributes"), "position");
        let (kind, bytes) = field(position, "array").as_ext().expect("a typed array");
        assert_eq!((kind, bytes.len() % 24), (0x17, 0), "two ends of three f32 each");
        lengths.push(bytes.len());
    }
    // Ten points a second, and at most 300 of them.
    assert!(lengths.is_sorted_by(|a, b| a < b) && lengths[2] <= 299 * 24, "{lengths:?}");

    let mut viser = Viewer::viser(running.address());
    viser.until(|m| is(m, "LineSegmentsMessage") && field(m, "name").as_str() == Some(flown));
    // A line has two changing properties, ends and colours; an arrow has one, its foot and tip; the marks of the path are two arrays.
    for (name, changed) in [
        (flown, 2),
        ("/twin/forces/residual", 1),
        ("/twin/forces/estimate", 1),
        ("/twin/trails/attitude", 2),
    ] {
        let changes =
            |m: &Value| is(m, "SceneNodeUpdateMessage") && field(m, "name").as_str() == Some(name);
        let seen = viser.until(changes);
        let updates = field(seen.last().unwrap(), "updates");
        assert!(updates.as_map().is_some_and(|map| map.len() == changed), "{name}: {updates}");
    }
}

#[test]
fn a_layer_hidden_in_a_viewer_stays_hidden_there_after_a_restart_and_shown_elsewhere() {
    let running = serve();
    let address = running.address();
    let (mut meshcat, mut viser) = (Viewer::meshcat(address), Viewer::viser(address));
    meshcat.until(|m| is(m, "set_control"));
    viser.until(|m| is(m, "ReplayDoneMessage"));
    let hidden = |path| move |m: &Value| visibility(m, path) == Some(&Value::Boolean(false));

    let press = |name: &str| map(&[("type", "button".into()), ("name", name.into())]);
    meshcat.send(&press("Show / hide trails"));
    meshcat.until(hidden("/twin/trails"));
    viser.send(&gui("show.reference", false.into()));
    let seen = viser.until(hidden("/twin/reference"));
    assert!(seen.iter().all(|m| visibility(m, "/twin/trails").is_none()));

    meshcat.send(&press("Restart"));
    meshcat.until(|m| is(m, "delete"));
    meshcat.until(hidden("/twin/trails"));
    viser.until(hidden("/twin/reference"));
    viser.send(&gui("show.reference", true.into()));
    viser.until(|m| visibility(m, "/twin/reference") == Some(&Value::Boolean(true)));
}

#[test]
fn refused_values_go_back_to_the_slider_and_change_nothing() {
    let running = serve();
    let address = running.address();
    let (mut meshcat, mut viser) = (Viewer::meshcat(address), Viewer::viser(address));
    let old = gain(address, "slope.x");
    for refused in [f64::NAN, f64::INFINITY, -1.0, 1e300] {
        meshcat.send(&slider("slope.x", refused));
        meshcat.until(|m| is(m, "notice"));
        meshcat.until(|m| is(m, "set_control_value") && field(m, "value").as_f64() == Some(old));
    }
    viser.send(&gui("gain.slope.x", "much".into()));
    viser.until(|m| is(m, "NotificationShowMessage"));
    viser.until(|m| is(m, "GuiUpdateMessage") && field(m, "uuid").as_str() == Some("gain.slope.x"));
    for nonsense in [Value::Nil, 3.into(), slider("nose", 1.0), gui("gain.nose", 1.into())] {
        meshcat.send(&nonsense);
        viser.send(&nonsense);
    }
    for unknown in [gui("button.self-destruct", true.into()), gui("scenario", "../x".into())] {
        viser.send(&unknown);
    }
    assert_eq!(gain(address, "slope.x").to_bits(), old.to_bits());
    assert_eq!(api(address, "/api/state")["scenario"], "hover");
}

#[test]
fn broken_long_and_too_many_messages_end_their_own_connection_with_a_reason() {
    let running = serve();
    let address = running.address();
    let mut console = Console::connect(address);
    for path in ["/", "/viser"] {
        let open = || Viewer::connect(address, path, None).expect("a connection");
        for broken in [vec![0xC1], vec![0xDF, 0xFF, 0xFF, 0xFF, 0xFF], vec![0x91; 60_000]] {
            let mut viewer = open();
            viewer.socket.send(Message::binary(broken)).unwrap();
            let (code, reason) = viewer.until_closed().expect("a reason");
            assert_eq!(code, 1007, "{reason}");
        }
        let mut viewer = open();
        let _ = viewer.socket.send(Message::binary(vec![0; 65 * 1024]));
        if let Some((code, reason)) = viewer.until_closed() {
            assert_eq!(code, 1009, "{reason}");
        }
        let mut viewer = open();
        let mut bytes = Vec::new();
        rmpv::encode::write_value(&mut bytes, &slider("slope.x", 1.0)).unwrap();
        for _ in 0..5000 {
            if viewer.socket.send(Message::binary(bytes.clone())).is_err() {
                break;
            }
        }
        if let Some((code, reason)) = viewer.until_closed() {
            assert_eq!(code, 1008, "{reason}");
        }
    }
    let start = console.frame().after();
    while console.frame().after() < start + 20 {}
}

#[test]
fn foreign_pages_wrong_protocols_and_absent_viewers_are_answered_plainly() {
    let running = serve();
    let address = running.address();
    for path in ["/", "/viser"] {
        let foreign = Viewer::connect(address, path, Some("http://evil.example"));
        assert_eq!(foreign.err(), Some(403), "{path}");
        let own = format!("http://{address}");
        assert!(Viewer::connect(address, path, Some(&own)).is_ok(), "{path}");
    }
    // Without the sub-protocol a browser would close the connection; so does the server.
    assert_eq!(Viewer::connect(address, "/viser/", None).err(), Some(400));
    for path in ["/meshcat/", "/meshcat/main.min.js", "/viser"] {
        let (status, answer) = http(address, &format!("GET {path}"), "", "");
        assert_eq!(status, 404);
        assert!(answer.contains("twin viewers fetch"), "{answer}");
    }
    assert_eq!(http(address, "GET /meshcat/..%2f..%2fetc/passwd", "", "").0, 404);
}

#[test]
fn viewers_that_read_nothing_do_not_delay_the_flight() {
    let running = serve();
    let address = running.address();
    let _stalled: Vec<Viewer> =
        (0..4).flat_map(|_| [Viewer::meshcat(address), Viewer::viser(address)]).collect();
    let mut live = Viewer::meshcat(address);
    live.until(|m| is(m, "set_control"));
    let mut console = Console::connect(address);
    let first = console.frame();
    let mut last = console.frame();
    while last.after() < first.after() + 300 {
        last = console.frame();
        assert_eq!(last.gap, 0);
    }
    live.until(|m| is(m, "set_transform"));
    assert_eq!(api(address, "/api/state")["clients"], 10);
}
