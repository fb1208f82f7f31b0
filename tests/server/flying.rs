//! Commands of operators: gains, presets, pause, step, speed, restart.

use serde_json::Value;

use super::console::{Console, api, options, scenario, serve};
use crate::folder::Folder;
use twin_console::server::spawn;

fn gain_in(list: &Value, name: &str) -> Value {
    let gains = list["gains"].as_array().expect("a list");
    gains.iter().find(|gain| gain["name"] == name).expect(name)["value"].clone()
}

#[test]
fn a_gain_is_echoed_to_everybody_with_one_tick_and_noted_in_that_tick() {
    let running = serve();
    let (mut one, mut two) =
        (Console::connect(running.address()), Console::connect(running.address()));
    one.frame();
    two.frame();
    one.send(r#"{"type":"set_gain","name":"slope.x","value":2.25}"#);
    let (echo_one, echo_two) = (one.message("gain"), two.message("gain"));
    assert_eq!(echo_one, echo_two);
    assert_eq!((&echo_one["name"], &echo_one["value"]), (&"slope.x".into(), &2.25.into()));
    assert_eq!(echo_one["preset"], "custom");
    let is_gain = |message: &Value| {
        message["events"].as_array().is_some_and(|e| e.iter().any(|e| e["kind"] == "gain"))
    };
    let events = two.message_that("events", is_gain);
    let noted = events["events"]
        .as_array()
        .unwrap()
        .iter()
        .find(|event| event["kind"] == "gain")
        .unwrap()
        .clone();
    assert_eq!(
        noted["tick"], echo_one["tick"],
        "the event is in the first tick flown with the gain"
    );
    assert!(noted["text"].as_str().unwrap().contains("Φ x (slope.x) 1.73205 -> 2.25"), "{noted}");
    assert_eq!(gain_in(&api(running.address(), "/api/gains"), "slope.x"), 2.25);
    let newcomer = Console::connect(running.address()).message("hello");
    assert_eq!(gain_in(&newcomer, "slope.x"), 2.25);
}

#[test]
fn a_preset_renews_the_list_and_undoes_single_changes() {
    let running = serve();
    let mut console = Console::connect(running.address());
    let before = console.message("hello");
    console.send(r#"{"type":"set_gain","name":"damping.z","value":1.0}"#);
    console.message("gain");
    console.send(r#"{"type":"preset","name":"paper"}"#);
    let list = console.message("gains");
    assert_eq!(list["preset"], "paper");
    for gain in list["gains"].as_array().unwrap() {
        assert_eq!(gain["value"], gain["preset_value"], "{gain}");
    }
    assert_ne!(
        gain_in(&list, "slope.x"),
        gain_in(&before, "slope.x"),
        "tuned and paper differ in slope.x"
    );
    console.send(r#"{"type":"preset","name":"tuned"}"#);
    assert_eq!(console.message("gains")["preset"], "tuned");
}

#[test]
fn a_paused_flight_stands_still_and_steps_exactly() {
    let running = serve();
    let mut console = Console::connect(running.address());
    console.send(r#"{"type":"pause","paused":true}"#);
    let stopped =
        console.message_that("state", |state| state["phase"] == "paused")["tick"].as_u64().unwrap();
    let later = console.message_that("state", |state| state["real_time_factor"] == 0.0);
    assert_eq!(later["tick"], stopped);
    console.send(r#"{"type":"step","ticks":3}"#);
    console.message_that("state", |state| state["tick"] == stopped + 3);
    let resting = console.message_that("state", |state| state["real_time_factor"] == 0.0);
    assert_eq!((&resting["tick"], &resting["phase"]), (&(stopped + 3).into(), &"paused".into()));
    console.send(r#"{"type":"pause","paused":false}"#);
    console.message_that("state", |state| state["tick"].as_u64() > Some(stopped + 20));
}

/// Most ticks from one state to the next at a twentieth of real time: two in 0.4 s, and one that had already begun.
const MOST_SLOW_TICKS: u64 = 3;

// The tests of `server/pace.rs` check, without a clock, that ticks are due according to the speed.
#[test]
fn the_speed_follows_the_operator() {
    let running = serve();
    let mut console = Console::connect(running.address());
    console.send(r#"{"type":"speed","value":0.05}"#);
    let slow = |state: &Value| state["speed"] == 0.05;
    let tick = |state: &Value| state["tick"].as_u64().unwrap();
    let mut last = tick(&console.message_that("state", slow));
    for _ in 0..3 {
        let next = tick(&console.message_that("state", slow));
        assert!((last..=last + MOST_SLOW_TICKS).contains(&next), "{last} then {next}");
        last = next;
    }
    console.send(r#"{"type":"speed","value":null}"#);
    let before = std::cell::Cell::new(last);
    console.message_that("state", |state| {
        state["speed"].is_null() && tick(state) > before.replace(tick(state)) + MOST_SLOW_TICKS
    });
}

#[test]
fn a_restart_resets_everybody_and_starts_at_tick_0_with_a_new_schema() {
    let running = serve();
    let (mut one, mut two) =
        (Console::connect(running.address()), Console::connect(running.address()));
    let old = two.message("hello");
    while two.frame().after() < 30 {}
    one.send(r#"{"type":"restart","seed":77,"scenario":"a_300g_slow"}"#);
    two.message("reset");
    let hello = two.message("hello");
    assert_eq!((&hello["scenario"], &hello["state"]["seed"]), (&"a_300g_slow".into(), &77.into()));
    assert_ne!(hello["schema_id"], old["schema_id"]);
    assert_eq!(hello["client_id"], old["client_id"]);
    let frame = two.frame();
    assert_eq!((frame.first_tick, frame.gap, frame.reset), (0, 0, true));
    assert_eq!(u64::from(frame.schema_id), hello["schema_id"].as_u64().unwrap());
    assert!(!two.frame().reset);
}

#[test]
fn a_served_flight_is_recorded_tick_by_tick_and_each_restart_in_its_own_file() {
    let folder = Folder::new("record");
    let mut recorded = options();
    recorded.record = Some(folder.path("flight.mcap"));
    let running = spawn(recorded).expect("a free port");
    let mut console = Console::connect(running.address());
    console.send(r#"{"type":"set_gain","name":"slope.y","value":1.5}"#);
    let echo = console.message("gain");
    while console.frame().after() < 60 {}
    console.send(r#"{"type":"restart","seed":5,"scenario":null}"#);
    console.message("reset");
    while console.frame().after() < 20 {}
    running.stop();

    let first = twin_record::read_recording(&folder.path("flight.mcap")).expect("the first flight");
    assert_eq!(first.warning, None);
    assert!(first.ticks.len() >= 60);
    assert!(first.ticks.iter().zip(0..).all(|(tick, index)| tick.index == index));
    let changed = &first.ticks[usize::try_from(echo["tick"].as_u64().unwrap()).unwrap()];
    assert!(
        changed.events.iter().any(|event| event.text.contains("(slope.y) 1.73205 -> 1.5")),
        "{:?}",
        changed.events
    );
    let second =
        twin_record::read_recording(&folder.path("flight-2.mcap")).expect("the second flight");
    assert_eq!(second.metadata["seed"], "5");
    assert!(second.metadata.contains_key("state_hash"));
}

#[test]
fn a_flight_that_ends_keeps_its_last_state_with_the_verdict_and_can_be_flown_again() {
    let mut short = options();
    short.scenario = scenario("hover", &["task.duration_s=1"]);
    short.speed = None;
    let running = spawn(short).expect("a free port");
    let mut console = Console::connect(running.address());
    let ended = console.message_that("state", |state| state["phase"] == "ended");
    assert_eq!(ended["verdict"], "completed");
    assert!(ended["tick"].as_u64() >= Some(100), "{ended}");
    let newcomer = Console::connect(running.address()).message("hello");
    assert_eq!(newcomer["state"]["reason"], ended["reason"]);
    let events = newcomer["events"].as_array().unwrap();
    assert_eq!(events.iter().filter(|event| event["kind"] == "verdict").count(), 1);
    // A step command does not change a flight that has ended; a restart flies again.
    console.send(r#"{"type":"step","ticks":5}"#);
    let still = console.message("state");
    assert_eq!((&still["phase"], &still["tick"]), (&"ended".into(), &ended["tick"]));
    console.send(r#"{"type":"restart","seed":9,"scenario":null}"#);
    console.message("reset");
    console.message_that("state", |state| state["phase"] == "ended" && state["seed"] == 9);
}
