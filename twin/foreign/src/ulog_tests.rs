//! A log written by hand from PX4's description of the format.

use super::*;
use crate::cdr;
use crate::container;
use crate::schema::Layout;
use crate::value::Path;

fn message(kind: u8, body: &[u8]) -> Vec<u8> {
    [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat()
}

/// A log with one topic that has a nested type and padding, which the logger cuts off at the end; a second instance; a dropout.
fn log() -> Vec<u8> {
    let data = |id: u16, t_us: u64, value: f32, inner: i16| {
        let body = [
            &id.to_le_bytes()[..],
            &t_us.to_le_bytes(),
            &value.to_le_bytes(),
            &inner.to_le_bytes(),
            &[7],
        ];
        message(b'D', &body.concat())
    };
    [
        &MAGIC[..],
        &[1],
        &5_000_000_u64.to_le_bytes(),
        &message(b'B', &[0; 40]),
        &message(b'I', b"\x10char[3] sys_namePX4"),
        &message(b'F', b"inner_thing:int16_t c;uint8_t[1] d;"),
        &message(b'F', b"vehicle_torque_setpoint:uint64_t timestamp;float x;inner_thing inner;uint8_t[3] _padding0;"),
        &message(b'A', b"\x00\x03\x00vehicle_torque_setpoint"),
        &message(b'A', b"\x01\x04\x00vehicle_torque_setpoint"),
        &data(3, 5_000_100, 1.5, -2),
        &message(b'O', &10_u16.to_le_bytes()),
        &data(4, 5_000_200, 2.5, 9),
        &data(3, 5_000_300, f32::NAN, 0),
    ]
    .concat()
}

#[test]
fn topics_schemas_times_and_values_are_those_written() {
    let (mut channels, mut values, mut layout) = (Vec::new(), Vec::new(), None);
    let found = container::read(&mut &log()[..], &mut |record| match record {
        Record::Schema { header, data } => {
            assert_eq!(header.name, "px4_msgs/msg/VehicleTorqueSetpoint");
            layout = Some(Layout::parse_ulog(std::str::from_utf8(&data).unwrap()).unwrap());
        }
        Record::Channel(channel) => channels.push((channel.id, channel.topic)),
        Record::Message { header, data } => {
            let value = cdr::decode_packed(layout.as_ref().unwrap(), &data).unwrap();
            let number = |path: &str| value.number(&Path::parse(path).unwrap()).unwrap();
            values.push((
                header.channel_id,
                header.log_time,
                number("x"),
                number("inner.c"),
                number("inner.d[0]"),
            ));
        }
        _ => {}
    })
    .unwrap();
    assert!(found.complete && found.problems.is_empty(), "{found:?}");
    assert_eq!(
        (found.dropouts, found.profile.as_str(), found.library.as_str()),
        (1, "ulog", "PX4")
    );
    let topics = ["/fmu/out/vehicle_torque_setpoint", "/fmu/out/vehicle_torque_setpoint/1"];
    assert_eq!(channels, [(3, topics[0].to_owned()), (4, topics[1].to_owned())]);
    assert_eq!(values[0], (3, 5_000_100_000, 1.5, -2.0, 7.0));
    assert_eq!(values[1], (4, 5_000_200_000, 2.5, 9.0, 7.0));
    assert!(values[2].2.is_nan());
}

#[test]
fn a_log_cut_at_every_byte_says_so_and_keeps_what_came_before() {
    let whole = log();
    let mut last = 0;
    for end in MAGIC.len()..whole.len() {
        let mut messages = 0;
        let found = container::read(&mut &whole[..end], &mut |record| {
            messages += u32::from(matches!(record, Record::Message { .. }));
        })
        .unwrap();
        assert_eq!(found.complete, found.problems.is_empty(), "{end}");
        assert!(messages >= last, "{end}");
        last = messages;
    }
    assert_eq!(last, 2);
}

#[test]
fn a_log_for_a_newer_reader_and_a_damaged_one_stop_with_a_reason() {
    let mut newer = log();
    newer[16 + HEAD_BYTES + 8] = 4;
    let mut damaged = log();
    damaged[16 + 2] = b'?';
    for (bytes, wanted) in [(newer, "newer reader"), (damaged, "unknown")] {
        let found = container::read(&mut &bytes[..], &mut |_| {}).unwrap();
        assert!(!found.complete && found.problems[0].contains(wanted), "{found:?}");
    }
}

#[test]
fn the_work_of_subscriptions_grows_with_the_formats_and_not_with_their_square() {
    let growth = twin_input::work::growth(100, &mut |count| {
        // Each format holds the next, and every format is subscribed.
        let format = |n: usize| message(b'F', format!("t{n}:t{} next;", n + 1).as_bytes());
        let subscribe =
            |n: usize| message(b'A', &[&[0][..], &(n as u16).to_le_bytes(), b"t0"].concat());
        let messages = (0..count).flat_map(format).chain((0..count).flat_map(subscribe));
        let bytes: Vec<u8> = MAGIC.into_iter().chain([0; 9]).chain(messages).collect();
        container::read(&mut &bytes[..], &mut |_| {}).unwrap();
    });
    assert!(
        growth < twin_input::work::LINEAR,
        "four times the formats took {growth:.1} times the steps"
    );
}
