//! Recordings with one trouble each, whose truth is the made flight without it.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use twin_foreign::{Effort, OpenedFlight};

use super::made::{GAIN, ODOMETRY, THRUST, file, messages};

/// Log time of the first message, ns.
const EPOCH_NS: u64 = 1_700_000_000_000_000_000;

/// A message to be written: topic number, log time, ns, and bytes.
type Message = (usize, u64, Vec<u8>);

/// A file whose channels are odometry and thrust in each of `namespaces`.
fn written(namespaces: &[&str], messages: &[Message]) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .compression_threads(0)
        .create(Cursor::new(Vec::new()))
        .expect("a writer");
    let mut channels = Vec::new();
    for namespace in namespaces {
        for (topic, schema, text) in [
            ("vehicle_odometry", "px4_msgs/msg/VehicleOdometry", ODOMETRY),
            ("vehicle_thrust_setpoint", "px4_msgs/msg/VehicleThrustSetpoint", THRUST),
        ] {
            let schema = writer.add_schema(schema, "ros2msg", text.as_bytes()).expect("a schema");
            let topic = format!("{namespace}/fmu/out/{topic}");
            let none = BTreeMap::new();
            channels.push(writer.add_channel(schema, &topic, "cdr", &none).expect("a channel"));
        }
    }
    for (sequence, (channel, log_time, data)) in messages.iter().enumerate() {
        let header = MessageHeader {
            channel_id: channels[*channel],
            sequence: sequence as u32,
            log_time: *log_time,
            publish_time: *log_time,
        };
        writer.write_to_known_channel(&header, data).expect("written");
    }
    writer.finish().expect("finished");
    writer.into_inner().into_inner()
}

/// The made flight of `seconds`, as messages of the channels `first` and `first + 1`; each `every`-th moment is logged.
fn flight(first: usize, seconds: u64, every: u64) -> Vec<Message> {
    let moment = |i: u64| {
        let [odometry, thrust] = messages(1_000_000 + i * 8000, i as f64 * 8e-3);
        let log_time = EPOCH_NS + i * 8_000_000;
        [(first, log_time, odometry), (first + 1, log_time, thrust)]
    };
    (0..seconds * 125).step_by(every as usize).flat_map(moment).collect()
}

fn opened(name: &str, bytes: &[u8]) -> OpenedFlight {
    OpenedFlight::open(&file(name, bytes), None).expect("a flight")
}

/// Asserts the gain of the made flight, and its duration.
fn assert_made(opened: &OpenedFlight, seconds: f64) {
    // Tolerances: `H` and interpolation change the gain by less than 0.1 %, and a break costs ticks, not time.
    const SHARE: f64 = 2e-3;
    const TIME_S: f64 = 0.1;
    let Effort::Fitted { fit, .. } = &opened.recorded.effort else {
        panic!("{:?}", opened.recorded.effort)
    };
    assert!((fit.gain / GAIN - 1.0).abs() < SHARE, "{fit:?}");
    let times_s = &opened.recorded.times_s;
    let lasted_s = times_s.last().expect("a tick") - times_s[0];
    assert!((lasted_s - seconds).abs() < TIME_S, "{lasted_s}");
}

#[test]
fn one_log_time_of_another_century_does_not_refuse_the_flight() {
    let mut messages = flight(0, 20, 1);
    messages[2200].1 += 6_300_000_000_000_000_000;
    let found = opened("century.mcap", &written(&[""], &messages));
    assert_made(&found, 20.0);
    let notes = &found.signals.notes;
    assert!(notes.iter().any(|note| note.contains("damaged and was mended")), "{notes:?}");
}

#[test]
fn a_recorder_whose_clock_was_set_back_loses_nothing_of_the_flight() {
    let mut messages = flight(0, 20, 1);
    messages[2500..].iter_mut().for_each(|message| message.1 -= 3_600_000_000_000);
    let found = opened("set_back.mcap", &written(&[""], &messages));
    assert_made(&found, 20.0);
    let notes = &found.signals.notes;
    assert!(notes.iter().any(|note| note.contains("-3600.0 s")), "{notes:?}");
}

#[test]
fn of_two_vehicles_the_one_that_flies_longer_is_mirrored_or_the_one_asked_for() {
    // The other vehicle logs its thrust faster, which made it the better source before.
    let messages = [flight(0, 20, 4), flight(2, 10, 1)].concat();
    let path = file("two.mcap", &written(&["/px4_1", "/px4_2"], &messages));
    let open = |vehicle| OpenedFlight::open_vehicle(&path, None, vehicle, &mut |_, _| {});
    for (vehicle, used, seconds) in [(None, "/px4_1", 20.0), (Some("/px4_2"), "/px4_2", 10.0)] {
        let found = open(vehicle).expect("a flight");
        assert!(found.signals.used.iter().all(|source| source.topic.starts_with(used)));
        assert_made(&found, seconds);
    }
    let why = open(Some("/px4_3")).expect_err("no such vehicle").to_string();
    assert!(why.contains("/px4_3") && why.contains("/px4_1, /px4_2"), "{why}");
}
