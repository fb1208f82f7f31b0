//! The messages that a client gets: the hello, every tick, and the count of the ticks that it missed.

use super::console::{Arrival, Console, options, serve};
use crate::patience::PATIENCE;
use twin_console::server::{Limits, spawn};

#[test]
fn the_hello_comes_first_and_describes_the_frames_that_follow() {
    let running = serve();
    let mut console = Console::connect(running.address());
    let Arrival::Json(hello) = console.next() else { panic!("the first message is no JSON") };
    assert_eq!((&hello["type"], &hello["protocol"]), (&"hello".into(), &2.into()));
    let frame = console.frame();
    assert_eq!(u64::from(frame.schema_id), hello["schema_id"].as_u64().unwrap());
    assert_eq!(frame.rows[0].len(), hello["channels"].as_array().unwrap().len());
    let bodies = hello["scene"]["bodies"].as_array().unwrap();
    assert_eq!(frame.bodies, bodies.iter().filter(|body| body["moving"] == true).count());
    assert!(bodies.iter().any(|body| body["name"] == hello["scene"]["base_body"]));
    assert!(hello["gains"].as_array().unwrap().len() > 20);
    // The time of a row is (tick + 1) × tick_s; the header has the time of the newest row.
    let tick_s = hello["tick_s"].as_f64().unwrap();
    assert!((frame.t_s - frame.after() as f64 * tick_s).abs() < 1e-9, "{frame:?}");
}

/// Most ticks from one state to the next in real time: those of the 0.4 s between states, those of the 0.1 s that a late flight may
/// catch up, and one that had already begun. A loaded machine flies fewer ticks, never more.
const MOST_TICKS_BETWEEN_STATES: u64 = 40 + 10 + 1;

#[test]
fn the_state_comes_in_every_half_second_of_flight_and_counts_the_clients() {
    let running = serve();
    let (mut one, mut two) =
        (Console::connect(running.address()), Console::connect(running.address()));
    let mut tick = || one.message("state")["tick"].as_u64().unwrap();
    let mut last = tick();
    for _ in 0..4 {
        let next = tick();
        assert!((last..=last + MOST_TICKS_BETWEEN_STATES).contains(&next), "{last} then {next}");
        last = next;
    }
    let state = two.message_that("state", |state| state["clients"] == 2);
    assert_eq!(state["phase"], "flying");
    drop(one);
    two.message_that("state", |state| state["clients"] == 1);
}

#[test]
fn a_slow_client_is_told_what_it_missed_and_slows_nobody() {
    let mut fast = options();
    fast.speed = Some(10.0);
    // The slow client must outlast 6000 ticks, which may take long beside other tests.
    fast.limits = Limits { stalled: PATIENCE, silent: PATIENCE, ..Limits::STANDARD };
    let running = spawn(fast).expect("a free port");
    let mut slow = Console::connect(running.address());
    let mut healthy = Console::connect(running.address());
    let slow_hello = slow.message("hello");
    assert!(slow_hello["client_id"].as_u64().unwrap() > 0);

    let first = healthy.frame();
    let mut next = first.after();
    while next < first.first_tick + 6000 {
        let frame = healthy.frame();
        assert_eq!((frame.gap, frame.first_tick), (0, next), "a client that reads misses nothing");
        next = frame.after();
    }

    let mut seen = 0;
    let mut missed = 0;
    let mut expected = None;
    while seen + missed < 5000 {
        let frame = slow.frame();
        if let Some(expected) = expected {
            assert_eq!(frame.first_tick, expected + frame.gap, "rows, gaps and ticks add up");
        }
        expected = Some(frame.after());
        seen += frame.rows.len() as u64;
        missed += frame.gap;
    }
    assert!(missed > 0, "6000 ticks fitted into the buffers of a client that did not read");
}

#[test]
fn a_client_that_comes_late_has_the_flight_so_far_and_misses_nothing_after() {
    let running = serve();
    let mut early = Console::connect(running.address());
    let mut known = early.frame();
    while known.after() < 120 {
        known = early.frame();
    }
    let mut late = Console::connect(running.address());
    let past = late.frame();
    assert_eq!((past.first_tick, past.gap), (0, 0));
    assert!(past.after() >= known.after(), "{} of {} ticks", past.after(), known.after());
    // The comparison uses bits, because an unknown value is NaN.
    let bits = |row: &[f32]| row.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    for (tick, row) in (known.first_tick..).zip(&known.rows) {
        assert_eq!(bits(&past.rows[tick as usize]), bits(row), "tick {tick}");
    }
    assert_eq!(late.frame().first_tick, past.after());
}
