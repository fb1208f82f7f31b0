//! Forks of a served flight. The oracle is `fly_forked`, which forks the same scenario without a server.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};

use serde_json::{Value, json};

use super::console::{Console, Frame, options, scenario};
use twin_console::server::{Running, ServeOptions, spawn};
use twin_scenario::Scenario;
use twin_scenario::fork::{Order, fly_forked, plans};

/// Ticks that the flight has flown when it is forked.
const FLOWN: u64 = 300;

/// Tick of the forks: 1.5 s.
const TICK: u64 = 150;

fn hover() -> Scenario {
    scenario("hover", &["task.duration_s=6.0", "task.start=grasped", "payload.mass_kg=0.2"])
}

/// A paused flight after [`FLOWN`] ticks.
fn flown() -> (Running, Console) {
    let running =
        spawn(ServeOptions { scenario: hover(), start_paused: true, ..options() }).unwrap();
    let mut console = Console::connect(running.address());
    step(&mut console, FLOWN);
    (running, console)
}

fn step(console: &mut Console, to: u64) {
    console.message("hello");
    console.send(&json!({ "type": "step", "ticks": to }).to_string());
    console.message_that("state", |state| state["tick"] == to);
}

fn fork(console: &mut Console, tick: Option<u64>, set: &[&str]) {
    console.send(&json!({ "type": "fork", "tick": tick, "set": set, "name": "" }).to_string());
}

/// The only fork once it is in this state.
fn only(console: &mut Console, state: &str) -> Value {
    let is = |message: &Value| message["forks"][0]["state"] == state;
    console.message_that("forks", is)["forks"][0].clone()
}

/// The rows of a fork from its row `from` on.
fn rows(address: SocketAddr, id: &Value, from: usize) -> Frame {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!(
        "GET /api/forks/{id}/{from} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
    );
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let body = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a body") + 4;
    Frame::decode(&answer[body..])
}

#[test]
fn a_fork_of_a_past_moment_has_the_metrics_of_the_fork_without_a_server() {
    let (running, mut console) = flown();
    fork(&mut console, Some(TICK), &["payload.mass_kg=0.35"]);
    let served = only(&mut console, "flown");
    let order = Order { at_s: TICK as f64 * 0.01, set: vec!["payload.mass_kg=0.35".to_owned()] };
    let plans = plans(&hover(), &[order]).unwrap();
    let flown = fly_forked(&hover(), plans, &mut |_, _| {}).unwrap();
    let wanted = &flown.forks[0];
    let metrics = served["metrics"].as_array().unwrap();
    assert_eq!(metrics.len(), wanted.rows.len());
    for (metric, row) in metrics.iter().zip(&wanted.rows) {
        assert_eq!(metric["metric"], row.metric.as_str());
        assert_eq!(metric["value"].as_f64(), row.value, "{metric}");
        assert_eq!(metric["parent"].as_f64(), row.parent, "{metric}");
    }
    assert_eq!(
        served["changed"],
        json!([{ "key": "payload.mass_kg", "from": "0.2", "to": "0.35" }])
    );
    assert_eq!(served["outcome"]["reason"], wanted.report.reason.as_str());
    // The rows are those of the fork from its first tick to its end, at 6 s; a page may ask for the rest.
    let all = rows(running.address(), &served["id"], 0);
    assert_eq!((all.first_tick, all.after()), (TICK, 600));
    assert_eq!(rows(running.address(), &served["id"], 440).first_tick, 590);
    let newcomer = Console::connect(running.address()).message("hello");
    assert_eq!(newcomer["forks"][0]["id"], served["id"]);
}

#[test]
fn a_fork_takes_over_what_operators_set_and_an_unchanged_one_is_the_flight() {
    let (running, mut console) = flown();
    console.send(r#"{"type":"set_gain","name":"leak","value":1.25}"#);
    console.message("gain");
    console.send(r#"{"type":"disturb","disturbance":{"kind":"payload_mass","kg":0.3}}"#);
    console.send(r#"{"type":"step","ticks":100}"#);
    console.message_that("state", |state| state["tick"] == FLOWN + 100);
    fork(&mut console, None, &[]);
    let unchanged = only(&mut console, "flown");
    assert_eq!(unchanged["changed"], json!([]));
    for metric in unchanged["metrics"].as_array().unwrap() {
        assert_eq!(metric["value"], metric["parent"], "{metric}");
    }
    // The flight flies on to where the fork has been already; both have the same rows to the last bit.
    let ahead = rows(running.address(), &unchanged["id"], 0);
    console.send(r#"{"type":"step","ticks":50}"#);
    let live = console.frame();
    assert_eq!(live.first_tick, ahead.first_tick);
    for (one, other) in live.rows.iter().zip(&ahead.rows) {
        let bits = |row: &[f32]| row.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(one), bits(other));
    }
    // Back to what the scenario has: it differs from what is in force, although not from the scenario.
    fork(&mut console, None, &["gains.leak=2.0", "payload.mass_kg=0.2"]);
    let second = |message: &Value| message["forks"][1]["state"] == "flown";
    let changed = console.message_that("forks", second)["forks"][1]["changed"].clone();
    let keys: Vec<&str> =
        changed.as_array().unwrap().iter().map(|c| c["key"].as_str().unwrap()).collect();
    assert_eq!(keys, ["gains.leak", "payload.mass_kg"]);
}

#[test]
fn refused_forks_say_why_and_the_flight_goes_on() {
    let (_running, mut console) = flown();
    fork(&mut console, Some(TICK), &["seed=9"]);
    let refused = only(&mut console, "failed");
    assert!(
        refused["outcome"]["reason"]
            .as_str()
            .unwrap()
            .contains("seed: 1 -> 9 cannot change in the air")
    );
    let notice =
        |console: &mut Console| console.message("notice")["text"].as_str().unwrap().to_owned();
    fork(&mut console, Some(9_999), &[]);
    assert!(notice(&mut console).contains("tick 9999 is not flown yet"));
    for seed in 10..16 {
        fork(&mut console, Some(TICK), &[&format!("seed={seed}")]);
    }
    assert!(notice(&mut console).contains("6 forks are kept already; drop one"));
    console.send(&json!({ "type": "name_fork", "id": refused["id"], "name": "heavy" }).to_string());
    console.message_that("forks", |message| message["forks"][0]["name"] == "heavy");
    console.send(&json!({ "type": "drop_fork", "id": refused["id"] }).to_string());
    console.message_that("forks", |message| message["forks"].as_array().unwrap().len() == 5);
    console.send(&json!({ "type": "drop_fork", "id": refused["id"] }).to_string());
    assert!(notice(&mut console).contains("there is no such fork"));
    console.send(
        &json!({ "type": "fork", "tick": null, "set": vec!["x"; 65], "name": "" }).to_string(),
    );
    assert!(notice(&mut console).contains("found 65 keys, allowed are 64"));
    console.send(r#"{"type":"restart"}"#);
    let again = console.message("hello");
    assert_eq!(again["forks"], json!([]), "another flight has no fork");
    console.send(r#"{"type":"step","ticks":5}"#);
    console.message_that("state", |state| state["tick"] == 5);
}
