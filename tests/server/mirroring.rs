//! A recording in the console: the page labels it as a recording, and plays, steps and seeks it. Messages that make no sense are refused,
//! and unknown values are NaN.

use serde_json::Value;

use super::console::{Arrival, Console, Frame, http};
use crate::mirror::made::{Form, PLAIN, file, flight};
use twin_console::server::{Limits, MirrorOptions, Running, spawn_mirror};
use twin_core::notation::GRAVITY_M_S2;
use twin_foreign::OpenedFlight;

fn mirror(name: &str, form: Form, start_paused: bool) -> Running {
    mirror_with(name, form, start_paused, None)
}

pub(super) fn mirror_with(
    name: &str,
    form: Form,
    start_paused: bool,
    foxglove_port: Option<u16>,
) -> Running {
    mirror_file(&file(name, &flight(form)), start_paused, foxglove_port)
}

pub(super) fn mirror_file(
    path: &std::path::Path,
    start_paused: bool,
    foxglove_port: Option<u16>,
) -> Running {
    spawn_mirror(MirrorOptions {
        opened: OpenedFlight::open(path, None).expect("a flight"),
        forecaster: twin_foreign::Forecaster::default(),
        live: None,
        host: "127.0.0.1".to_owned(),
        port: 0,
        speed: Some(1.0),
        start_s: 0.0,
        start_paused,
        viewer_dir: None,
        foxglove_port,
        foxglove_origins: Vec::new(),
        limits: Limits::STANDARD,
    })
    .expect("a free port")
}

/// Index of the channel `name` in a `hello`.
fn channel(hello: &Value, name: &str) -> usize {
    let channels = hello["channels"].as_array().expect("a list");
    channels.iter().position(|channel| channel["name"] == name).expect(name)
}

/// The last row up to tick `last`, and the frames received until then.
fn rows_to(console: &mut Console, schema: &Value, last: u64) -> (Vec<f32>, Vec<Frame>) {
    let mut frames = Vec::new();
    loop {
        if let Arrival::Frame(frame) = console.next()
            && u64::from(frame.schema_id) == schema.as_u64().expect("a number")
        {
            let (after, row) = (frame.after(), frame.rows.last().expect("a row").clone());
            frames.push(frame);
            if after > last {
                return (row, frames);
            }
        }
    }
}

#[test]
fn a_recording_says_what_it_is_and_shows_unknown_rows_as_unknown() {
    let running = mirror("console.mcap", PLAIN, true);
    let mut console = Console::connect(running.address());
    let hello = console.message("hello");
    let info = &hello["mirror"];
    assert_eq!(info["file"], "console.mcap");
    assert!(info["predictor"].as_str().expect("text").contains("not trained"));
    assert!(info["stand_in"].as_str().expect("text").contains("plain quadrotor"));
    assert_eq!(info["unknown_rows"], serde_json::json!(["phi", "theta", "psi", "q1", "q2"]));
    assert!((info["duration_s"].as_f64().expect("a number") - 20.0).abs() < 0.1);
    // Nobody gave a mass, so the forces are those on one kilogram, and so is the weight in them.
    assert_eq!(info["per_kilogram"], true);
    let residual = &hello["channels"][channel(&hello, "residual.z")];
    assert_eq!((&residual["unit"], &residual["weight"]), (&"N/kg".into(), &GRAVITY_M_S2.into()));
    assert_eq!(hello["channels"][channel(&hello, "residual.phi")]["unit"], "N m");
    console.send(r#"{"type":"seek","t_s":10}"#);
    let sought = console.message("hello");
    let (row, frames) = rows_to(&mut console, &sought["schema_id"], 1000);
    // The ten seconds before the target are sent too, so that the charts show a past.
    assert_eq!(frames[0].first_tick, 0);
    assert_eq!(frames.iter().map(|frame| frame.rows.len()).sum::<usize>(), 1001);
    let value = |name: &str| row[channel(&sought, name)];
    assert!((value("residual.z") - 9.81).abs() < 0.1, "{}", value("residual.z"));
    assert!(value("chi.phi").is_finite());
    let of_the_residual =
        ["residual.psi", "base.psi", "adapted.psi", "innovation.psi", "r_hat.psi"];
    let of_a_missing_arm = ["chi.q1", "chi_des.q1", "error.q1", "residual.q1", "r_hat.q1"];
    let of_another_controller = ["joint_torque.1", "sliding_norm", "wind.x"];
    for unknown in [&of_the_residual[..], &of_a_missing_arm, &of_another_controller].concat() {
        assert!(value(unknown).is_nan(), "{unknown}");
    }
    // The yaw is measured although no torque about it is known: it can be compared with the expected yaw.
    for known in ["chi.psi", "chi_des.psi", "error.psi"] {
        assert!(value(known).is_finite(), "{known}");
    }
    // A ghost from half a second before stays near a vehicle that obeys physics.
    assert!(value("error.x").abs() < 0.05, "{}", value("error.x"));
}

#[test]
fn a_moment_looks_the_same_however_one_comes_to_it() {
    let running = mirror("seek.mcap", PLAIN, true);
    let mut console = Console::connect(running.address());
    let first = console.message("hello");
    let names = ["chi.x", "residual.z", "adapted.z", "chi_des.x"];
    let at = |console: &mut Console, hello: &Value| {
        let (row, _) = rows_to(console, &hello["schema_id"], 1500);
        names.map(|name| row[channel(hello, name)])
    };
    console.send(r#"{"type":"seek","t_s":15}"#);
    let hello = console.message("hello");
    let forward = at(&mut console, &hello);
    console.send(r#"{"type":"seek","t_s":19}"#);
    console.message("hello");
    console.send(r#"{"type":"seek","t_s":15}"#);
    let hello = console.message("hello");
    assert_eq!(at(&mut console, &hello).map(f32::to_bits), forward.map(f32::to_bits));
    assert_ne!(hello["schema_id"], first["schema_id"]);
    console.send(r#"{"type":"step","ticks":3}"#);
    console.message_that("state", |state| state["tick"] == 1504 && state["phase"] == "paused");
}

#[test]
fn a_seek_keeps_the_phases_at_the_times_at_which_they_began() {
    let hole = Form { hole_s: Some((6.0, 9.0)), ..PLAIN };
    let running = mirror("phases.mcap", hole, true);
    let mut console = Console::connect(running.address());
    let phases = console.message("hello")["mirror"]["phases"].clone();
    let times: Vec<f64> =
        phases.as_array().expect("a list").iter().filter_map(|p| p["t_s"].as_f64()).collect();
    let [.., lost, found, end] = times[..] else { panic!("the hole makes two phases: {phases}") };
    // A derivative needs half a second of data, so the residual is known later than the motion.
    assert!(5.9 < lost && lost < 6.1 && 9.0 < found && found < 9.7 && end > 19.8, "{times:?}");
    // The run-up of ten seconds begins after the hole.
    console.send(r#"{"type":"seek","t_s":19.8}"#);
    let sought = console.message("hello");
    let begun = &phases.as_array().expect("a list")[..times.len() - 1];
    assert_eq!(sought["events"].as_array().expect("a list"), begun);
    let is_phase = |event: &Value| event["kind"] == "phase";
    let said = loop {
        match console.next() {
            Arrival::Json(message) if message["type"] == "events" => {
                let events = message["events"].as_array().expect("a list");
                if let Some(phase) = events.iter().find(|event| is_phase(event)) {
                    break Some(phase.clone());
                }
            }
            Arrival::Frame(frame) if frame.after() > 1980 => break None,
            _ => {}
        }
    };
    assert_eq!(said, None, "no phase begins at a seek");
}

#[test]
fn at_its_end_a_recording_waits_and_plays_again_from_its_start() {
    let running = mirror("end.mcap", Form { seconds: 12.0, ..PLAIN }, false);
    let mut console = Console::connect(running.address());
    console.message("hello");
    console.send(r#"{"type":"seek","t_s":11.7}"#);
    let state = console.message_that("state", |state| {
        state["phase"] == "paused" && state["tick"].as_u64() > Some(1190)
    });
    assert_eq!(state["verdict"], Value::Null);
    console.send(r#"{"type":"pause","paused":false}"#);
    console.message_that("state", |state| {
        state["phase"] == "flying" && state["tick"].as_u64() < Some(600)
    });
}

#[test]
fn inside_a_hole_nothing_is_shown_as_if_it_were_live() {
    let hole = Form { hole_s: Some((6.0, 9.0)), ..PLAIN };
    let running = mirror("hole_console.mcap", hole, true);
    let mut console = Console::connect(running.address());
    console.message("hello");
    console.send(r#"{"type":"seek","t_s":7.5}"#);
    let hello = console.message("hello");
    let (row, _) = rows_to(&mut console, &hello["schema_id"], 750);
    for name in ["chi.x", "chi.phi", "residual.z", "adapted.z", "chi_des.x", "error.psi", "r_hat.z"]
    {
        assert!(row[channel(&hello, name)].is_nan(), "{name}");
    }
}

#[test]
fn what_would_act_on_a_vehicle_is_refused_with_the_reason() {
    let running = mirror("refuse.mcap", PLAIN, true);
    let mut console = Console::connect(running.address());
    console.message("hello");
    for (message, wanted) in [
        (r#"{"type":"disturb","disturbance":{"kind":"drop_payload"}}"#, "flown already"),
        (r#"{"type":"preset","name":"paper"}"#, "own controller"),
        (r#"{"type":"set_gain","name":"slope.x","value":1.0}"#, "own controller"),
        (r#"{"type":"restart","seed":4,"scenario":null}"#, "no seed"),
        (r#"{"type":"seek","t_s":-1}"#, "0..=1000000"),
    ] {
        console.send(message);
        let notice = console.message("notice");
        assert!(notice["text"].as_str().expect("text").contains(wanted), "{message}: {notice}");
    }
    let body = r#"{"name":"slope.x","value":1.0}"#;
    let headers = "Content-Type: application/json\r\n";
    let (status, answer) = http(running.address(), "POST /api/gains", headers, body);
    assert_eq!(status, 422, "{answer}");
    // The adapter's gains can be changed.
    console.send(r#"{"type":"set_gain","name":"forgetting","value":0.98}"#);
    console.send(r#"{"type":"step","ticks":1}"#);
    assert_eq!(console.message("gain")["value"], 0.98);
}
