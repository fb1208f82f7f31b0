//! Operators change the world, see the effect, and download the changes.

use serde_json::Value;

use super::console::{Console, api, http, options, serve};
use crate::folder::Folder;
use twin_console::server::{ServeOptions, spawn};
use twin_scenario::Scenario;

/// A scenario with a payload.
fn with_payload() -> ServeOptions {
    let mut options = options();
    options.scenario = super::console::scenario("a_300g_slow", &[]);
    options
}

fn disturbances(events: &Value) -> Vec<String> {
    let events = events["events"].as_array().expect("a list");
    let ours = events.iter().filter(|event| event["kind"] == "disturbance");
    ours.map(|event| event["text"].as_str().expect("a sentence").to_owned()).collect()
}

#[test]
fn payload_wind_and_effects_in_force_are_in_the_state_of_everybody() {
    let running = spawn(with_payload()).expect("a free port");
    let mut console = Console::connect(running.address());
    let hello = console.message("hello");
    assert_eq!(hello["state"]["payload_kg"], 0.3);
    assert!(hello["effects"].as_array().unwrap().contains(&"downwash".into()));
    for disturbance in [
        r#"{"kind":"payload_mass","kg":0.45}"#,
        r#"{"kind":"wind","velocity_m_s":[1.5,0.0,-0.5]}"#,
        r#"{"kind":"effect","name":"downwash","on":false}"#,
    ] {
        console.send(&format!(r#"{{"type":"disturb","disturbance":{disturbance}}}"#));
    }
    let changed = |state: &Value| {
        state["payload_kg"] == 0.45
            && state["wind_m_s"] == serde_json::json!([1.5, 0.0, -0.5])
            && state["effects_off"] == serde_json::json!(["downwash"])
    };
    let state = console.message_that("state", changed);
    let stages: Vec<&str> =
        state["stages"].as_array().unwrap().iter().filter_map(|s| s["name"].as_str()).collect();
    assert_eq!(stages, ["source", "predict", "task", "adapt", "control", "record", "publish"]);
    assert!(changed(&api(running.address(), "/api/state")));
}

#[test]
fn a_push_that_is_held_is_one_event() {
    let running = serve();
    let mut console = Console::connect(running.address());
    console.send(r#"{"type":"pause","paused":true}"#);
    console.message_that("state", |state| state["phase"] == "paused");
    let push = r#"{"type":"disturb","disturbance":{"kind":"push","force_n":[2.0,0.0,0.0],"duration_s":0.1}}"#;
    for _ in 0..5 {
        console.send(push);
        console.send(r#"{"type":"step","ticks":5}"#);
    }
    // A second push after the first has ended is a second event.
    console.send(r#"{"type":"step","ticks":30}"#);
    console.send(push);
    console.send(r#"{"type":"disturb","disturbance":{"kind":"wind","velocity_m_s":[0,0,0]}}"#);
    console.send(r#"{"type":"step","ticks":1}"#);
    let mut said = Vec::new();
    while !said.iter().any(|text: &String| text.starts_with("wind is now")) {
        said.extend(disturbances(
            &console.message_that("events", |events| !disturbances(events).is_empty()),
        ));
    }
    let pushes = said.iter().filter(|text| text.starts_with("push of")).count();
    assert!((1..=2).contains(&pushes), "{said:?}");
}

#[test]
fn gains_taken_away_as_a_scenario_table_give_the_same_gains_again() {
    let running = serve();
    let mut console = Console::connect(running.address());
    for change in [
        r#"{"name":"damping.z","value":9.25}"#,
        r#"{"name":"forgetting","value":0.985}"#,
        r#"{"name":"adapter_on","value":0.0}"#,
    ] {
        let change = change.trim_start_matches('{');
        console.send(&format!(r#"{{"type":"set_gain",{change}"#));
        console.message("gain");
    }
    let (status, answer) = http(running.address(), "GET /api/override.toml", "", "");
    assert_eq!(status, 200);
    let table = answer.split_once("\r\n\r\n").expect("a body").1;
    assert!(table.contains("preset = \"tuned\""), "{table}");
    let changed = table.lines().filter(|line| line.contains(" = ")).count();
    assert_eq!(changed, 4, "the preset and what differs from it, nothing else: {table}");
    let folder = Folder::new("override");
    let hover = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/hover.toml");
    let vehicle = hover.with_file_name("../urdf/aerial_manipulator.urdf");
    let file = folder.write("taken.toml", table);
    let vehicle = format!("vehicle.urdf={}", vehicle.display());
    let tuning = Scenario::load(&file, &[vehicle]).expect("usable").tuning().expect("in range");
    let listed = api(running.address(), "/api/gains");
    for gain in listed["gains"].as_array().unwrap() {
        let name = gain["name"].as_str().unwrap();
        assert_eq!(tuning.get(name), gain["value"].as_f64(), "{name}");
    }
}

#[test]
fn the_metrics_count_the_ticks_they_time() {
    let running = serve();
    let mut console = Console::connect(running.address());
    while console.frame().after() < 120 {}
    let (status, answer) = http(running.address(), "GET /metrics", "", "");
    assert_eq!(status, 200);
    let value = |name: &str| -> f64 {
        let line = answer.lines().find_map(|line| line.strip_prefix(name)).expect(name);
        line.trim().parse().expect("a number")
    };
    assert!(value("twin_clients ") >= 1.0);
    // The server publishes the count with the state, at least twice a second.
    let counted = value("twin_tick_lateness_seconds_count ");
    assert!(counted >= 50.0 && counted <= value("twin_ticks "), "{answer}");
}
