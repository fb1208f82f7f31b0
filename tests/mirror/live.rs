//! Flights in progress: a Foxglove server of the older protocol, written by hand, and a file that grows. Both fly the circle at the
//! speed of the wall clock.

use std::collections::BTreeMap;
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use serde_json::json;
use tungstenite::handshake::server::{Request, Response};
use tungstenite::{Message, WebSocket};
use twin_core::notation::TICK_S;
use twin_foreign::live::{From, Live};
use twin_foreign::playback::PartReader;
use twin_foreign::{OpenedFlight, RecordedFlight};

use super::made::{ODOMETRY, THRUST, file, messages, truth};
use crate::patience::{PATIENCE, Patience, clock, until};

/// Error of a cubic over the longest hole that is no gap, 0.2 s, on a circle of 1 m at 1.2 rad/s: (1.2 * 0.2)^4 / 384, and more for
/// the slopes of unequal steps.
const BETWEEN_SAMPLES_M: f64 = 5e-3;

/// Behaviour of the server.
const SAYS: u8 = 0;
const SILENT: u8 = 1;
const HANGS_UP: u8 = 2;

const TOPICS: [(&str, &str, &str); 2] = [
    ("/fmu/out/vehicle_odometry", "px4_msgs/msg/VehicleOdometry", ODOMETRY),
    ("/fmu/out/vehicle_thrust_setpoint", "px4_msgs/msg/VehicleThrustSetpoint", THRUST),
];

/// Time of the flight controller at a time of the flight, µs; the log has the same time.
fn t_us(t_s: f64) -> u64 {
    5_000_000 + (t_s * 1e6) as u64
}

#[expect(clippy::result_large_err, reason = "the form of the handshake's callback")]
fn accept(stream: TcpStream) -> WebSocket<TcpStream> {
    let choose = |request: &Request, mut response: Response| {
        let asked = request.headers()["Sec-WebSocket-Protocol"].to_str().expect("text");
        assert_eq!(asked, "foxglove.sdk.v1, foxglove.websocket.v1");
        let chosen = "foxglove.websocket.v1".parse().expect("a header");
        response.headers_mut().insert("Sec-WebSocket-Protocol", chosen);
        Ok(response)
    };
    tungstenite::accept_hdr(stream, choose).expect("a handshake")
}

/// Serves one connection: it advertises the channels, waits for the subscriptions, then flies until it is told to hang up. Returns the
/// time of the flight in its last message, s.
fn serve(stream: TcpStream, start: Instant, mood: &AtomicU8) -> f64 {
    let mut socket = accept(stream);
    let channel = |(id, (topic, name, text)): (usize, &(&str, &str, &str))| json!({ "id": 7 + id, "topic": topic, "encoding": "cdr", "schemaName": name, "schema": text });
    let channels: Vec<_> = TOPICS.iter().enumerate().map(channel).collect();
    for said in [
        json!({ "op": "serverInfo", "name": "by hand", "capabilities": [] }),
        json!({ "op": "something of a later version", "value": [1, 2] }),
        json!({ "op": "advertise", "channels": channels }),
    ] {
        socket.send(Message::text(said.to_string())).expect("the client reads");
    }
    let mut subscriptions = BTreeMap::new();
    while subscriptions.len() < TOPICS.len() {
        let Message::Text(text) = socket.read().expect("a subscription") else { continue };
        let said: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(said["op"], "subscribe");
        for one in said["subscriptions"].as_array().expect("a list") {
            let id = one["id"].as_u64().expect("a number") as u32;
            subscriptions.insert(one["channelId"].as_u64().expect("a number") - 7, id);
        }
    }
    let mut t_s = 0.0;
    while mood.load(Ordering::Relaxed) != HANGS_UP {
        std::thread::sleep(Duration::from_millis(8));
        if mood.load(Ordering::Relaxed) != SAYS {
            continue;
        }
        t_s = start.elapsed().as_secs_f64();
        for (number, data) in messages(t_us(t_s), t_s).into_iter().enumerate() {
            let head = [
                &[1][..],
                &subscriptions[&(number as u64)].to_le_bytes(),
                &(t_us(t_s) * 1000).to_le_bytes(),
            ];
            let message = [head.concat(), data].concat();
            if socket.send(Message::binary(message)).is_err() {
                return t_s;
            }
        }
    }
    t_s
}

fn parts(opened: &OpenedFlight) -> &Arc<dyn PartReader> {
    opened.long.as_ref().expect("it is read as it goes on")
}

/// The newest second, and the time of the flight at its first tick, s.
fn newest(opened: &OpenedFlight) -> (RecordedFlight, f64) {
    let ticks = parts(opened).ticks();
    let from = ticks.saturating_sub(100);
    (parts(opened).part(from, ticks), zero_s(opened) + from as f64 * TICK_S)
}

/// Time of the flight at the first tick, s.
fn zero_s(opened: &OpenedFlight) -> f64 {
    (opened.signals.start_ns - 5_000_000_000) as f64 * 1e-9
}

/// Asserts that the known positions of the newest second lie on the circle; returns their number.
fn known_on_the_circle(opened: &OpenedFlight) -> usize {
    let (part, first_s) = newest(opened);
    let mut known = 0;
    for (i, instant) in part.instants.iter().enumerate() {
        let (p, _) = truth(first_s + i as f64 * TICK_S);
        let all = (0..3).filter_map(|row| instant.chi[row].map(|value| value - p[row]));
        let errors: Vec<f64> = all.collect();
        assert!(errors.iter().all(|error| error.abs() < BETWEEN_SAMPLES_M), "{i}: {errors:?}");
        known += usize::from(errors.len() == 3);
    }
    known
}

#[test]
fn a_stream_of_the_older_protocol_is_followed_through_silence_and_a_lost_connection() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let mood = Arc::new(AtomicU8::new(SAYS));
    let theirs = Arc::clone(&mood);
    let start = clock();
    let server = std::thread::spawn(move || {
        for _ in 0..2 {
            serve(listener.accept().expect("a client").0, start, &theirs);
            while theirs.load(Ordering::Relaxed) == HANGS_UP {
                std::thread::sleep(Duration::from_millis(5));
            }
        }
    });
    let live = Live::listen(&From::Socket(format!("ws://{address}")), None).expect("a thread");
    let opened = live.wait(PATIENCE).expect("a flight");
    assert_eq!(opened.signals.used[0].topic, TOPICS[0].0);
    until("positions", || known_on_the_circle(&opened) > 50);

    mood.store(SILENT, Ordering::Relaxed);
    until("silence", || !live.is_up());
    // Time goes on, but every value is unknown.
    until("a second in which every value is unknown", || known_on_the_circle(&opened) == 0);
    assert!(live.news().iter().any(|text| text.contains("silent")));

    mood.store(SAYS, Ordering::Relaxed);
    until("positions after the silence", || live.is_up() && known_on_the_circle(&opened) > 50);
    assert!(live.news().iter().any(|text| text.contains("arrive again")));

    mood.store(HANGS_UP, Ordering::Relaxed);
    until("a lost connection", || live.news().iter().any(|text| text.contains("lost")));
    mood.store(SAYS, Ordering::Relaxed);
    until("positions after the loss", || live.is_up() && known_on_the_circle(&opened) > 50);
    drop(live);
    mood.store(HANGS_UP, Ordering::Relaxed);
    std::thread::sleep(Duration::from_millis(20));
    mood.store(SAYS, Ordering::Relaxed);
    server.join().expect("the server ends well");
}

#[test]
fn a_server_that_is_gone_without_a_word_is_lost_and_tried_again() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let mood = Arc::new(AtomicU8::new(SAYS));
    let theirs = Arc::clone(&mood);
    let start = clock();
    // The first connection stays open, like that of a machine that lost power; nobody answers on it.
    let gone = std::thread::spawn(move || {
        let first = listener.accept().expect("a client").0;
        let kept = first.try_clone().expect("a handle");
        serve(first, start, &theirs);
        let again = listener.accept().expect("it comes again").0;
        drop((kept, again));
    });
    let live = Live::listen(&From::Socket(format!("ws://{address}")), None).expect("a thread");
    live.wait(PATIENCE).expect("a flight");
    mood.store(HANGS_UP, Ordering::Relaxed);
    until("a loss", || live.news().iter().any(|text| text.contains("no answer")));
    gone.join().expect("the client came again");
}

#[test]
fn the_last_value_is_not_held_for_longer_than_a_gap() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let mood = Arc::new(AtomicU8::new(SAYS));
    let theirs = Arc::clone(&mood);
    let start = clock();
    let server =
        std::thread::spawn(move || serve(listener.accept().expect("a client").0, start, &theirs));
    let live = Live::listen(&From::Socket(format!("ws://{address}")), None).expect("a thread");
    let opened = live.wait(PATIENCE).expect("a flight");
    mood.store(SILENT, Ordering::Relaxed);
    until("silence", || !live.is_up() && known_on_the_circle(&opened) == 0);
    let part = parts(&opened).part(0, parts(&opened).ticks());
    let known = part.instants.iter().rposition(|instant| instant.chi[0].is_some());
    let last_s = zero_s(&opened) + known.expect("positions") as f64 * TICK_S;
    mood.store(HANGS_UP, Ordering::Relaxed);
    let sent_s = server.join().expect("the server ends well");
    // All ticks after the last message are unknown; rounding may shift the last known tick by one.
    assert!(last_s < sent_s + TICK_S, "known until {last_s} s, sent until {sent_s} s");
}

#[test]
fn a_file_that_is_still_written_is_followed_until_its_recorder_closes_it() {
    let path = file("growing.mcap", b"");
    let mut writer = mcap::WriteOptions::new()
        .profile("ros2")
        .compression_threads(0)
        .create(std::fs::File::create(&path).expect("a file"))
        .expect("a writer");
    let channels = TOPICS.map(|(topic, name, text)| {
        let schema = writer.add_schema(name, "ros2msg", text.as_bytes()).expect("a schema");
        writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("a channel")
    });
    let live = Live::listen(&From::File(path), None).expect("a thread");
    let (start, patience) = (clock(), Patience::new());
    let (mut opened, mut known) = (None, 0);
    while known < 50 {
        assert!(patience.lasts(), "{known} positions are known");
        // One chunk every 0.1 s.
        for _ in 0..10 {
            std::thread::sleep(Duration::from_millis(10));
            let t_s = start.elapsed().as_secs_f64();
            for (channel_id, data) in channels.iter().zip(messages(t_us(t_s), t_s)) {
                let log_time = t_us(t_s) * 1000;
                let header = MessageHeader {
                    channel_id: *channel_id,
                    sequence: 0,
                    log_time,
                    publish_time: log_time,
                };
                writer.write_to_known_channel(&header, &data).expect("written");
            }
        }
        writer.flush().expect("flushed");
        if opened.is_none() && start.elapsed() > Duration::from_secs(4) {
            opened = live.opened();
        }
        known = opened.as_ref().map_or(0, known_on_the_circle);
    }
    writer.finish().expect("finished");
    until("the end", || live.news().iter().any(|text| text.contains("closed the file")));
}

#[test]
fn what_is_no_server_is_said_and_tried_again() {
    let free = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address");
    let live = Live::listen(&From::Socket(format!("ws://{free}")), None).expect("a thread");
    until("a word", || live.news().iter().any(|text| text.contains("lost")));
    assert!(live.opened().is_none() && !live.is_up());
    let text = file("no.mcap", b"this is no MCAP file at all");
    let live = Live::listen(&From::File(text), None).expect("a thread");
    until("a word", || live.news().iter().any(|text| text.contains("no MCAP file")));
    let wrong = Live::listen(&From::Socket(format!("ws://{free}")), Some("nowhere"));
    assert!(wrong.expect_err("no such map").to_string().contains("crazyflie"));
}
