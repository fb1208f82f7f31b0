//! Files that are whole but unusual: a message names the defect, and the usable part is used.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use twin_core::elementary::{cos, sin};
use twin_foreign::gather::gather_from;
use twin_foreign::{Map, OpenedFlight, Survey};

use super::made::{Form, PLAIN, file, flight};

/// A channel to write: topic, schema, its encoding and text, encoding of the messages.
type Channel<'a> = (&'a str, &'a str, &'a str, &'a str, &'a str);

/// A file with these channels; each message is `(channel, time in ms, bytes)`.
fn made(channels: &[Channel<'_>], messages: &[(usize, u64, Vec<u8>)]) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .compression(None)
        .create(Cursor::new(Vec::new()))
        .expect("a writer");
    let ids: Vec<u16> = channels
        .iter()
        .map(|(topic, schema, encoding, text, message)| {
            let schema = writer.add_schema(schema, encoding, text.as_bytes()).expect("a schema");
            writer.add_channel(schema, topic, message, &BTreeMap::new()).expect("a channel")
        })
        .collect();
    for (sequence, (channel, time_ms, data)) in messages.iter().enumerate() {
        let log_time = time_ms * 1_000_000;
        let header = MessageHeader {
            channel_id: ids[*channel],
            sequence: sequence as u32,
            log_time,
            publish_time: log_time,
        };
        writer.write_to_known_channel(&header, data).expect("written");
    }
    writer.finish().expect("finished");
    writer.into_inner().into_inner()
}

fn float64(value: f64) -> Vec<u8> {
    [&[0, 1, 0, 0][..], &value.to_le_bytes()].concat()
}

fn map(text: &str) -> Map {
    Map::parse(text, "test").expect("a map")
}

#[test]
fn an_unknown_compression_is_named_and_nothing_is_made_of_it() {
    let whole = flight(Form { seconds: 1.0, compression: Some(mcap::Compression::Zstd), ..PLAIN });
    let name = [&4_u32.to_le_bytes()[..], b"zstd"].concat();
    let other = [&4_u32.to_le_bytes()[..], b"zpaq"].concat();
    let mut bytes = whole;
    for at in 0..bytes.len() - name.len() {
        if bytes[at..].starts_with(&name) {
            bytes[at..at + name.len()].copy_from_slice(&other);
        }
    }
    let survey = Survey::read_from(&mut &bytes[..]).expect("an MCAP");
    assert_eq!((survey.messages, survey.container.chunks), (0, 0));
    assert!(survey.container.problems[0].contains("zpaq"), "{:?}", survey.container.problems);
    let path = file("zpaq.mcap", &bytes);
    let error = OpenedFlight::open(&path, None).expect_err("no message").to_string();
    assert!(error.contains("no position and no attitude") && error.contains("none"), "{error}");
}

#[test]
fn an_unknown_encoding_is_named_with_those_that_are_read() {
    let channel = ("/pose", "x/msg/Pose", "flatbuffer", "?", "flatbuffer");
    let bytes = made(&[channel], &[(0, 1, vec![1, 2, 3])]);
    let map = map("[[topic]]\ntopic = \"/pose\"\n[topic.gives.battery]\npaths = [\"v\"]\n");
    let notes = gather_from(&mut &bytes[..], &map).expect("an MCAP").notes;
    let wanted = ["flatbuffer", "ros2msg and ros2idl with cdr"];
    assert!(wanted.iter().all(|word| notes[0].contains(word)), "{notes:?}");
    assert_eq!(notes.len(), 1, "said once: {notes:?}");
}

#[test]
fn two_definitions_under_one_name_are_each_used_for_their_own_channel() {
    let (short, long) = ("float64 v\n", "float64 before\nfloat64 v\n");
    let channels =
        [("/a", "x/msg/Log", "ros2msg", short, "cdr"), ("/b", "x/msg/Log", "ros2msg", long, "cdr")];
    let two = [float64(7.0), 12.5_f64.to_le_bytes().to_vec()].concat();
    let bytes = made(&channels, &[(0, 1, float64(11.5)), (1, 2, two)]);
    let survey = Survey::read_from(&mut &bytes[..]).expect("an MCAP");
    assert_eq!(survey.ambiguous_schemas, ["x/msg/Log"]);
    let map = map("[[topic]]\nschema = \"x/msg/Log\"\n[topic.gives.battery]\npaths = [\"v\"]\n");
    let gathered = gather_from(&mut &bytes[..], &map).expect("an MCAP");
    let values: Vec<f64> = gathered.tracks.iter().map(|track| track.samples[0].values[0]).collect();
    assert_eq!(values, [11.5, 12.5]);
}

#[test]
fn a_recording_without_a_pose_says_what_it_has_instead() {
    let channels = [
        ("/battery", "x/msg/Volt", "ros2msg", "float64 v\n", "cdr"),
        ("/empty", "x/msg/Volt", "ros2msg", "float64 v\n", "cdr"),
    ];
    let path = file("no_pose.mcap", &made(&channels, &[(0, 1, float64(11.0))]));
    let error = OpenedFlight::open(&path, None).expect_err("no pose").to_string();
    for wanted in ["no_pose.mcap", "no position and no attitude", "--map", "/battery (x/msg/Volt)"]
    {
        assert!(error.contains(wanted), "{wanted}: {error}");
    }
    assert!(!error.contains("/empty"), "{error}");
}

#[test]
fn times_that_run_backwards_repeat_or_stand_beside_nan_are_counted_and_left_out() {
    let text = "float64 x\nfloat64 y\nfloat64 z\n";
    let channel = ("/pose", "x/msg/Point", "ros2msg", text, "cdr");
    let point =
        |x: f64| [float64(x), 0.5_f64.to_le_bytes().into(), 1.0_f64.to_le_bytes().into()].concat();
    let mut messages: Vec<(usize, u64, Vec<u8>)> =
        (0..200).map(|i| (0, 1000 + i * 10, point(i as f64 * 0.01))).collect();
    messages[50].1 -= 200;
    messages[60].1 = messages[59].1;
    messages[70].2 = point(f64::NAN);
    let map_file = file(
        "point.toml",
        b"[[topic]]\ntopic = \"/pose\"\n[topic.gives.position]\npaths = [\"x\", \"y\", \"z\"]\nunit = \"m\"\n",
    );
    let path = file("times.mcap", &made(&[channel], &messages));
    let opened = OpenedFlight::open(&path, map_file.to_str()).expect("a position");
    let timing = opened.signals.used[0].timing;
    assert_eq!(
        (timing.samples, timing.backwards, timing.duplicate, timing.not_finite),
        (197, 1, 1, 1)
    );
    for (tick, instant) in opened.recorded.instants.iter().enumerate() {
        let x = instant.chi[0].expect("no hole");
        // The motion is a straight line, so the samples that were left out do not change it. Time starts with the first sample.
        assert!((x - opened.recorded.times_s[tick]).abs() < 1e-9, "{tick}: {x}");
        assert_eq!(instant.chi[3], None);
    }
}

/// A record of an MCAP file.
fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

#[test]
fn a_channel_that_stands_in_the_summary_alone_is_an_empty_one() {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    // rosbag2 writes a channel without a message into no chunk. The opcodes are those of the MCAP specification: header, end of data,
    // channel, footer.
    let channel = [&7_u16.to_le_bytes()[..], &[0; 2], &text("/mode"), &text("cdr"), &[0; 4]];
    let bytes = [
        mcap::MAGIC.to_vec(),
        record(0x01, &[text("ros2"), text("hand")].concat()),
        record(0x0F, &[0; 4]),
        record(0x04, &channel.concat()),
        record(0x02, &[0; 20]),
        mcap::MAGIC.to_vec(),
    ]
    .concat();
    let survey = Survey::read_from(&mut &*bytes).expect("readable");
    assert!(survey.container.complete && survey.container.problems.is_empty(), "{survey:?}");
    let found: Vec<(&str, u64)> =
        survey.channels.iter().map(|info| (info.topic.as_str(), info.messages)).collect();
    assert_eq!(found, [("/mode", 0)]);
}

#[test]
fn transforms_in_protobuf_give_the_pose_of_the_base() {
    use foxglove::Encode;
    use foxglove::messages::{FrameTransform, FrameTransforms, Quaternion, Timestamp, Vector3};
    let one = |name: &str, x: f64, ms: u32| FrameTransform {
        timestamp: Some(Timestamp::new(100, ms * 1_000_000)),
        parent_frame_id: "world".to_owned(),
        child_frame_id: name.to_owned(),
        translation: Some(Vector3 { x, y: 0.5, z: 1.0 }),
        // The yaw grows with x, because a quantity that never changes counts as not measured.
        rotation: Some(Quaternion { x: 0.0, y: 0.0, z: sin(x / 2.0), w: cos(x / 2.0) }),
    };
    let schema = FrameTransforms::get_schema().expect("a schema");
    let mut writer = mcap::WriteOptions::new().create(Cursor::new(Vec::new())).expect("a writer");
    let id = writer.add_schema(&schema.name, &schema.encoding, &schema.data).expect("a schema");
    let channel_id =
        writer.add_channel(id, "/tf", "protobuf", &BTreeMap::new()).expect("a channel");
    for i in 0..50_u32 {
        let x = f64::from(i) * 0.01;
        let transforms = vec![one("gripper", 9.0, 10 * i), one("base_link", x, 10 * i)];
        let mut data = Vec::new();
        FrameTransforms { transforms }.encode(&mut data).expect("encoded");
        let log_time = u64::from(i) * 10_000_000 + 3_000_000;
        let header = MessageHeader { channel_id, sequence: i, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &data).expect("written");
    }
    writer.finish().expect("finished");
    let protobuf = writer.into_inner().into_inner();
    let opened = OpenedFlight::open(&file("tf_protobuf.mcap", &protobuf), None).expect("a flight");
    let last = opened.recorded.instants.last().expect("ticks");
    // 49 steps of 10 mm and of 10 mrad.
    assert!((last.chi[0].expect("known") - 0.49).abs() < 1e-9, "{last:?}");
    assert!((last.chi[5].expect("known") - 0.49).abs() < 1e-9, "{last:?}");
    assert_eq!(opened.signals.used[0].topic, "/tf");
}
