//! Foxglove's timeline over a recording: range, pause, speed, seeks of either side, end, and refusals.

use foxglove::Decode;
use foxglove::messages::JointStates;
use foxglove::ws_protocol::client::{PlaybackCommand, PlaybackControlRequest};
use foxglove::ws_protocol::server::playback_state::PlaybackStatus;
use serde_json::{Value, json};

use super::console::Console;
use super::foxglove_client::Foxglove;
use super::mirroring::{mirror_file, mirror_with};
use crate::mirror::made::{PLAIN, file};
use crate::mirror::round_trip::record;
use twin_console::server::Running;

const S: u64 = 1_000_000_000;

/// A tick of the recording, ns.
const TICK: u64 = S / 100;

fn serve(name: &str) -> (Running, Foxglove, Console) {
    let running = mirror_with(name, PLAIN, true, Some(0));
    let client = Foxglove::connect(running.foxglove_address().expect("a port"));
    let console = Console::connect(running.address());
    (running, client, console)
}

fn request(command: PlaybackCommand, speed: f32, seek: Option<u64>) -> PlaybackControlRequest {
    PlaybackControlRequest {
        playback_command: command,
        playback_speed: speed,
        seek_time: seek,
        request_id: format!("{command:?} {speed} {seek:?}"),
    }
}

#[test]
fn the_timeline_plays_pauses_and_sets_the_speed_of_a_recording() {
    let (_running, mut client, mut console) = serve("timeline.mcap");
    let info = client.op("serverInfo");
    let capabilities = info["capabilities"].as_array().unwrap();
    assert!(capabilities.contains(&"playbackControl".into()), "{info}");
    let time =
        |key: &str| info[key]["sec"].as_u64().unwrap() * S + info[key]["nsec"].as_u64().unwrap();
    // The made flight is 20 s long.
    assert_eq!(time("dataStartTime"), 0);
    assert!(time("dataEndTime").abs_diff(20 * S) < S / 10, "{info}");

    let play = request(PlaybackCommand::Play, 2.0, None);
    client.ask(&play);
    let answer = client.playback(|state| state.request_id.is_some());
    assert_eq!(answer.request_id.as_deref(), Some(play.request_id.as_str()));
    assert_eq!((answer.status, answer.did_seek), (PlaybackStatus::Playing, false));
    let playing = client
        .playback(|state| state.request_id.is_none() && state.status == PlaybackStatus::Playing);
    assert!((playing.playback_speed - 2.0).abs() < 1e-6, "{playing:?}");
    console.message_that("state", |state| state["phase"] == "flying" && state["speed"] == 2.0);

    client.ask(&request(PlaybackCommand::Pause, 2.0, None));
    client.playback(|state| state.request_id.is_none() && state.status == PlaybackStatus::Paused);
    console.message_that("state", |state| state["phase"] == "paused");
    // The buttons of the console control the same playback.
    console.send(r#"{"type":"pause","paused":false}"#);
    client.playback(|state| state.status == PlaybackStatus::Playing);
}

/// The telemetry row of the tick that was sought. Before it, only the row of the previous position may arrive, and none of the run-up.
fn sought(client: &mut Foxglove, wanted: u64, was: u64) -> Vec<u8> {
    loop {
        let (time, payload) = client.data(4);
        if time == wanted {
            return payload;
        }
        assert_eq!(time, was, "a row of the run-up");
    }
}

#[test]
fn a_seek_shows_the_row_that_was_sought_first_and_none_of_before() {
    let (_running, mut client, mut console) = serve("sought.mcap");
    client.subscribe("/twin/telemetry", 4);
    client.ask(&request(PlaybackCommand::Pause, 1.0, Some(12 * S)));
    let answer = client.playback(|state| state.request_id.is_some());
    assert!(answer.did_seek);
    assert_eq!((answer.status, answer.current_time), (PlaybackStatus::Buffering, 12 * S));
    let payload = sought(&mut client, 12 * S, 0);
    let row: Value = serde_json::from_slice(&payload).expect("JSON");
    assert_eq!(row["t_s"], 12.0);

    // The server announces a seek of the console as a seek. The ticks after it follow one by one.
    console.send(r#"{"type":"seek","t_s":5}"#);
    let landed = client.playback(|state| state.did_seek);
    assert_eq!((landed.status, landed.request_id), (PlaybackStatus::Paused, None));
    assert_eq!(landed.current_time, 5 * S);
    sought(&mut client, 5 * S, 12 * S);
    client.ask(&request(PlaybackCommand::Play, 1.0, None));
    let after: Vec<u64> = (0..10).map(|_| client.data(4).0).collect();
    let wanted: Vec<u64> = (1..=10).map(|tick| 5 * S + tick * TICK).collect();
    assert_eq!(after, wanted);
}

#[test]
fn at_the_end_playback_has_ended_and_play_begins_anew() {
    let (_running, mut client, _) = serve("ended.mcap");
    client.ask(&request(PlaybackCommand::Play, 50.0, Some(15 * S)));
    let ended = client.playback(|state| state.status == PlaybackStatus::Ended);
    assert!(ended.current_time.abs_diff(20 * S) < S / 10, "{ended:?}");
    client.ask(&request(PlaybackCommand::Play, 50.0, None));
    let anew = client.playback(|state| state.did_seek);
    assert!(anew.current_time < S, "{anew:?}");
}

#[test]
fn what_a_recording_cannot_do_is_refused_with_a_reason() {
    let (_running, mut client, _) = serve("refused.mcap");
    for (speed, found) in [(f32::NAN, "NaN"), (1e6, "1000000"), (-1.0, "-1")] {
        client.ask(&request(PlaybackCommand::Pause, speed, None));
        let status = client.op("status");
        let message = status["message"].as_str().unwrap();
        assert!(message.contains("speed =") && message.contains(found), "{message}");
    }
    let set = |name: &str, value: f64, id: &str| json!({ "op": "setParameters", "parameters": [{ "name": name, "value": value, "type": "float64" }], "id": id });
    client.send(&set("slope.x", 1.5, "law"));
    // The refusal and its reason arrive in either order.
    let told = [(); 2].map(|()| {
        client.json(|said| {
            let reason = said["message"].as_str().is_some_and(|text| text.contains("adapter"));
            said["id"] == "law" || (said["op"] == "status" && reason)
        })
    });
    assert!(told.iter().any(|said| said["parameters"] == json!([])), "{told:?}");
    assert!(told.iter().any(|said| said["op"] == "status"), "{told:?}");
    client.send(&set("forgetting", 0.985, "adapter"));
    let answer = client.json(|said| said["id"] == "adapter");
    assert_eq!(answer["parameters"][0]["value"], 0.985);
    // No URDF describes the vehicle of this flight.
    let why = client.fetch("package://twin/vehicle.urdf", 9).expect_err("no vehicle");
    assert!(why.contains("mirrored"), "{why}");
}

#[test]
fn a_recording_tells_the_angles_of_its_joints_by_their_names_and_no_torque() {
    let path = file("joints.mcap", b"");
    let flown = record(&path);
    let running = mirror_file(&path, true, Some(0));
    let mut client = Foxglove::connect(running.foxglove_address().expect("a port"));
    client.subscribe("/joint_states", 4);
    client.ask(&request(PlaybackCommand::Pause, 1.0, Some(2 * S)));
    let payload = sought(&mut client, 2 * S, 0);
    let joints = JointStates::decode(&payload[..]).expect("foxglove.JointStates").joints;
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    // The names are those of `urdf/aerial_manipulator.urdf`.
    assert_eq!(names, ["joint1", "joint2"]);
    for (joint, wanted) in joints.iter().zip(&flown[200].measurement.chi.as_slice()[6..]) {
        // Rows travel as f32.
        assert_eq!(joint.position, Some(f64::from(*wanted as f32)), "{joint:?}");
        // In a mirrored flight the loop commands no torque.
        assert_eq!(joint.effort, None);
    }
}

#[test]
fn a_simulated_flight_has_no_timeline() {
    let mut options = super::console::options();
    options.foxglove_port = Some(0);
    let running = twin_console::server::spawn(options).expect("free ports");
    let mut client = Foxglove::connect(running.foxglove_address().expect("a port"));
    let info = client.op("serverInfo");
    assert!(!info["capabilities"].as_array().unwrap().contains(&"playbackControl".into()));
    client.ask(&request(PlaybackCommand::Pause, 1.0, None));
    let refused = client.op("status");
    assert!(refused["message"].as_str().unwrap().contains("playback control"), "{refused}");
}
