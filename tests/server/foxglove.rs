//! Foxglove's protocol on the wire: the advertised channels, a transform that MeshCat also gets, and gains as parameters.

use std::net::SocketAddr;

use foxglove::Decode;
use foxglove::messages::SceneUpdate;
use serde_json::{Value, json};
use tungstenite::Message;

use super::console::{Console, api, options};
use super::foxglove_client::Foxglove;
use super::viewers::{Viewer, field, is};
use twin_console::server::{Running, spawn};

/// Poses reach both protocols as f32: at 10 m that is 1e-6 m.
const POSE_TOLERANCE_M: f64 = 1e-5;

fn serve() -> (Running, SocketAddr, SocketAddr) {
    let mut options = options();
    options.foxglove_port = Some(0);
    let running = spawn(options).expect("free ports");
    let (address, foxglove) = (running.address(), running.foxglove_address().expect("a port"));
    (running, address, foxglove)
}

#[test]
fn foxglove_is_told_what_there_is_and_that_gains_are_parameters_and_time_is_the_flights() {
    let (_running, _, address) = serve();
    let mut client = Foxglove::connect(address);
    let info = client.op("serverInfo");
    assert_eq!(info["name"], "twin");
    let capabilities = info["capabilities"].as_array().unwrap();
    for wanted in ["parameters", "parametersSubscribe", "time"] {
        assert!(capabilities.contains(&wanted.into()), "{info}");
    }
    for (topic, schema, encoding) in [
        ("/tf", "foxglove.FrameTransforms", "protobuf"),
        ("/scene", "foxglove.SceneUpdate", "protobuf"),
        ("/joint_states", "foxglove.JointStates", "protobuf"),
        ("/log", "foxglove.Log", "protobuf"),
        ("/twin/telemetry", "twin.Telemetry", "json"),
    ] {
        while !client.advertised.iter().any(|channel| channel["topic"] == topic) {
            client.next();
        }
        let channel = client.advertised.iter().find(|channel| channel["topic"] == topic).unwrap();
        assert_eq!(
            (&channel["schemaName"], &channel["encoding"]),
            (&schema.into(), &encoding.into())
        );
    }
    client.subscribe("/twin/telemetry", 7);
    let rows: Vec<(u64, Value)> = (0..30)
        .map(|_| client.data(7))
        .map(|(log_time_ns, payload)| (log_time_ns, serde_json::from_slice(&payload).unwrap()))
        .collect();
    // Every tick of 10 ms, each with its own time.
    for pair in rows.windows(2) {
        assert_eq!(pair[1].0 - pair[0].0, 10_000_000);
    }
    let last = &rows[29];
    assert!((last.1["t_s"].as_f64().unwrap() * 1e9 - last.0 as f64).abs() < 1.0);
    assert!(last.1["chi"]["z"].is_f64() && last.1["rotor_0"].is_f64(), "{}", last.1);
}

#[test]
fn a_late_subscriber_to_a_paused_flight_sees_it_where_meshcat_does() {
    let (_running, address, foxglove) = serve();
    let mut console = Console::connect(address);
    while console.frame().after() < 30 {}
    console.send(r#"{"type":"pause","paused":true}"#);
    console.message_that("state", |state| state["phase"] == "paused");

    let mut client = Foxglove::connect(foxglove);
    client.subscribe("/tf", 1);
    let (_, told) = client.transforms(1);
    client.subscribe("/scene", 2);
    let scene = SceneUpdate::decode(&client.data(2).1[..]).expect("foxglove.SceneUpdate");
    assert!(scene.entities.len() >= told.transforms.len() && told.transforms.len() > 5);

    let mut meshcat = Viewer::meshcat(address);
    for transform in &told.transforms {
        assert_eq!(transform.parent_frame_id, "world");
        let path = format!("/twin/{}", transform.child_frame_id);
        let moved =
            |m: &rmpv::Value| is(m, "set_transform") && field(m, "path").as_str() == Some(&path);
        // The server sends the initial pose and the present pose. A new connection for each body makes their order irrelevant.
        let mut seen = meshcat.until(moved);
        seen.extend(meshcat.until(moved));
        let (_, bytes) = field(seen.last().unwrap(), "matrix").as_ext().expect("a typed array");
        let number = |k: usize| f32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
        let found = transform.translation.unwrap();
        for (k, value) in [found.x, found.y, found.z].into_iter().enumerate() {
            let wanted = f64::from(number(12 + k));
            assert!((value - wanted).abs() < POSE_TOLERANCE_M, "{path}: {value} {wanted}");
        }
        meshcat = Viewer::meshcat(address);
    }
}

#[test]
fn a_gain_set_from_foxglove_is_in_force_for_everybody_and_a_refused_one_is_answered_with_the_old() {
    let (_running, address, foxglove) = serve();
    let mut client = Foxglove::connect(foxglove);
    let mut console = Console::connect(address);
    client.send(&json!({ "op": "getParameters", "parameterNames": [], "id": "all" }));
    let all = client.json(|said| said["op"] == "parameterValues" && said["id"] == "all");
    let gains = api(address, "/api/gains");
    assert_eq!(
        all["parameters"].as_array().unwrap().len(),
        gains["gains"].as_array().unwrap().len()
    );

    let subscribe = json!({ "op": "subscribeParameterUpdates", "parameterNames": ["slope.x"] });
    client.send(&subscribe);
    let set = |value: Value, id: &str| {
        let parameter = json!({ "name": "slope.x", "value": value, "type": "float64" });
        json!({ "op": "setParameters", "parameters": [parameter], "id": id })
    };
    client.send(&set(1.5.into(), "set"));
    let answer = client.json(|said| said["op"] == "parameterValues" && said["id"] == "set");
    assert_eq!(answer["parameters"][0]["value"], 1.5);
    console.message_that("gain", |echo| echo["name"] == "slope.x" && echo["value"] == 1.5);
    let in_force = |address| {
        let gains = api(address, "/api/gains");
        let gains = gains["gains"].as_array().unwrap().clone();
        gains.into_iter().find(|gain| gain["name"] == "slope.x").unwrap()["value"].clone()
    };
    assert_eq!(in_force(address), 1.5);

    // A subscriber is informed of a gain, whoever sets it.
    console.send(r#"{"type":"set_gain","name":"slope.x","value":2.5}"#);
    client.json(|said| {
        let told = &said["parameters"][0];
        said["op"] == "parameterValues" && told["name"] == "slope.x" && told["value"] == 2.5
    });
    client.send(&set(1e300.into(), "too much"));
    let answer = client.json(|said| said["id"] == "too much");
    assert_eq!(answer["parameters"][0]["value"], 2.5);
    assert_eq!(in_force(address), 2.5);
}

#[test]
fn foxglove_clients_that_read_nothing_do_not_delay_the_flight_and_a_restart_begins_a_new_session() {
    let (_running, address, foxglove) = serve();
    let mut stalled: Vec<Foxglove> = (0..4).map(|_| Foxglove::connect(foxglove)).collect();
    for client in &mut stalled {
        for (id, topic) in ["/tf", "/scene", "/twin/telemetry"].into_iter().enumerate() {
            client.subscribe(topic, id as u32);
        }
    }
    let mut live = Foxglove::connect(foxglove);
    let first = live.op("serverInfo")["sessionId"].clone();
    live.subscribe("/tf", 1);
    let mut console = Console::connect(address);
    let start = console.frame().after();
    let mut last = console.frame();
    while last.after() < start + 300 {
        last = console.frame();
        assert_eq!(last.gap, 0);
    }
    // Older ticks waited in the socket; the newest tick is much later than the first seconds.
    let before = loop {
        let (time, _) = live.transforms(1);
        if time >= 2_000_000_000 {
            break time;
        }
    };
    console.send(r#"{"type":"restart","seed":null,"scenario":null}"#);
    let second = live.op("serverInfo")["sessionId"].clone();
    assert_ne!(first, second);
    while live.transforms(1).0 >= before {}
}

#[test]
fn a_server_that_stops_closes_the_connection_in_order() {
    let (running, _, foxglove) = serve();
    let mut client = Foxglove::connect(foxglove);
    client.op("serverInfo");
    running.stop();
    while !matches!(client.socket.read().expect("a farewell"), Message::Close(_)) {}
}

#[test]
fn a_port_that_is_taken_is_an_error_with_a_remedy() {
    let (_running, _, taken) = serve();
    let mut options = options();
    options.foxglove_port = Some(taken.port());
    let error = spawn(options).err().expect("the port is in use").to_string();
    assert!(
        error.contains("--foxglove-port") && error.contains(&taken.port().to_string()),
        "{error}"
    );
}
