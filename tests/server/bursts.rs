//! Bursts of commands: restarts become one, and of equal commands the last one counts.

use std::time::Duration;

use super::console::{Console, options};
use super::raw::metric;
use crate::folder::Folder;
use crate::patience::until;
use twin_console::server::{Limits, spawn};

/// Consoles that restart at once, and restarts of each.
const CONSOLES: usize = 60;
const EACH: usize = 3;

#[test]
fn a_burst_of_180_restarts_begins_one_flight_and_one_recording() {
    let place = Folder::new("burst");
    let mut recorded = options();
    recorded.record = Some(place.path("flight.mcap"));
    // The second restart waits for longer than the test takes.
    recorded.limits = Limits { restart_gap: Duration::from_hours(1), ..Limits::STANDARD };
    let running = spawn(recorded).expect("a free port");
    let address = running.address();
    let mut consoles: Vec<Console> = (0..CONSOLES).map(|_| Console::connect(address)).collect();
    for seed in 0..EACH {
        for console in &mut consoles {
            console.send(&format!(r#"{{"type":"restart","seed":{seed},"scenario":null}}"#));
        }
    }
    // One restart begins a flight, one waits, and the others are void.
    let void = (CONSOLES * EACH - 2) as f64;
    until("all restarts have arrived", || metric(address, "twin_commands_coalesced_total") >= void);
    assert!((metric(address, "twin_restarts_total") - 1.0).abs() < 0.5);
    let mut watcher = Console::connect(address);
    let start = watcher.frame().after();
    while watcher.frame().after() < start + 20 {}
    running.stop();
    let files = std::fs::read_dir(place.path("")).expect("the folder").count();
    assert_eq!(files, 2, "the first flight and the one that was restarted");
}

#[test]
fn the_last_restart_of_a_burst_is_flown_and_what_follows_it_is_not_lost() {
    let running = spawn(options()).expect("a free port");
    let mut console = Console::connect(running.address());
    for seed in 1..=4 {
        console.send(&format!(r#"{{"type":"restart","seed":{seed},"scenario":null}}"#));
    }
    for n in 0..=100 {
        let value = f64::from(n) / 100.0 + 1.0;
        console.send(&format!(r#"{{"type":"set_gain","name":"slope.x","value":{value}}}"#));
    }
    console.message_that("state", |state| state["seed"] == 4);
    let last = console.message_that("gain", |gain| gain["value"] == 2.0);
    assert_eq!(last["name"], "slope.x");
    assert!(metric(running.address(), "twin_restarts_total") >= 2.0);
}

#[test]
fn a_seed_beyond_the_command_lines_range_is_refused() {
    let running = spawn(options()).expect("a free port");
    let mut console = Console::connect(running.address());
    for seed in ["9007199254740993", "18446744073709551615"] {
        console.send(&format!(r#"{{"type":"restart","seed":{seed},"scenario":null}}"#));
        let notice = console.message("notice");
        assert!(notice["text"].as_str().unwrap().contains("0..=9007199254740992"), "{notice}");
    }
    console.send(r#"{"type":"restart","seed":9007199254740992,"scenario":null}"#);
    console.message_that("state", |state| state["seed"].as_u64() == Some(1 << 53));
}
