//! `px4-ulog` reads PX4's logs.

use std::collections::BTreeMap;
use std::path::Path;

use mcap::records::Record;
use px4_ulog::full_parser::{SomeVec, read_file};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use twin_foreign::cdr::decode_packed;
use twin_foreign::container;
use twin_foreign::schema::Layout;

use super::super::{made, real::flights};
use super::{Leaf, Leaves, leaves_of_ours, number};

/// Logs that are made.
const LOGS: usize = 60;

/// Types of a field, and their sizes in bytes.
const KINDS: [(&str, usize); 12] = [
    ("bool", 1),
    ("char", 1),
    ("int8_t", 1),
    ("uint8_t", 1),
    ("int16_t", 2),
    ("uint16_t", 2),
    ("int32_t", 4),
    ("uint32_t", 4),
    ("int64_t", 8),
    ("uint64_t", 8),
    ("float", 4),
    ("double", 8),
];

/// Name of the type that other types contain.
const INNER: &str = "inner_thing";

/// The values of a field of a topic, one for each message. The key is the number of the topic's channel and the path of the field.
type Columns = BTreeMap<(String, String), Vec<Leaf>>;

fn message(kind: u8, body: &[u8]) -> Vec<u8> {
    [&(body.len() as u16).to_le_bytes()[..], &[kind], body].concat()
}

/// A format of some fields, with padding inside, and its size in bytes. `inner` is the size of [`INNER`].
fn made_format(name: &str, first: &str, inner: Option<usize>, rng: &mut Pcg64) -> (String, usize) {
    let mut text = format!("{name}:{first}");
    let mut bytes = 0;
    for field in 0..rng.random_range(1..9) {
        let (kind, of_one) = match inner {
            Some(inner) if rng.random_range(0..4) == 0 => (INNER, inner),
            _ => KINDS[rng.random_range(0..KINDS.len())],
        };
        let count = rng.random_range(1..5);
        let array = if count == 1 { String::new() } else { format!("[{count}]") };
        text += &[kind, &array, " field_", &field.to_string(), ";"].concat();
        bytes += of_one * count;
        if rng.random_range(0..4) == 0 {
            text += &["uint8_t[3] _padding", &field.to_string(), ";"].concat();
            bytes += 3;
        }
    }
    (text + "int16_t last;", bytes + 2)
}

/// A log with three topics, each with two instances, and the kinds of messages that say nothing of a topic.
fn made_log(rng: &mut Pcg64) -> Vec<u8> {
    let mut log = [&b"ULog\x01\x12\x35\x01"[..], &[0; 8], &message(b'B', &[0; 40])].concat();
    log.extend(message(b'I', b"\x10char[3] sys_namePX4"));
    log.extend(message(b'P', b"\x0cint32_t RATE\x07\0\0\0"));
    let (format, inner) = made_format(INNER, "", None, rng);
    log.extend(message(b'F', format.as_bytes()));
    let mut sizes = Vec::new();
    for topic in 0..3 {
        let (format, bytes) =
            made_format(&format!("made_{topic}"), "uint64_t timestamp;", Some(inner), rng);
        let padding = if rng.random() { "uint8_t[5] _padding99;" } else { "" };
        log.extend(message(b'F', (format + padding).as_bytes()));
        sizes.push(bytes);
    }
    for id in 0..6_u8 {
        let name = format!("made_{}", id / 2);
        log.extend(message(b'A', &[&[id % 2, id, 0][..], name.as_bytes()].concat()));
    }
    for step in 0..40_u64 {
        let id = rng.random_range(0..6_u8);
        // Any bytes: also numbers that are not finite, and booleans that are neither 0 nor 1, as PX4 leaves them in fields that it does
        // not set.
        let values: Vec<u8> = (0..sizes[usize::from(id / 2)]).map(|_| rng.random()).collect();
        let time = (1_000_000 + 4000 * step).to_le_bytes();
        log.extend(message(b'D', &[&[id, 0][..], &time, &values].concat()));
        match step {
            10 => log.extend(message(b'O', &[10, 0])),
            20 => log.extend(message(b'L', b"6\0\0\0\0\0\0\0\0hello")),
            30 => log.extend(message(b'S', b"\x2f\x73\x13\x20\x25\x0c\xbb\x12")),
            _ => {}
        }
    }
    log
}

/// The columns that our reader finds, without padding.
fn ours(path: &Path) -> Columns {
    let (mut layouts, mut channels, mut columns) =
        (BTreeMap::new(), BTreeMap::new(), Columns::new());
    let mut input = std::fs::File::open(path).expect("a log");
    let found = container::read(&mut input, &mut |record| match record {
        Record::Schema { header, data } => {
            let text = std::str::from_utf8(&data).expect("a text");
            let name = text.split(':').next().expect("a name").to_owned();
            layouts.insert(header.id, (name, Layout::parse_ulog(text).expect("a definition")));
        }
        Record::Channel(channel) => {
            let instance = channel.metadata["instance"].clone();
            channels.insert(channel.id, (channel.schema_id, instance));
        }
        Record::Message { header, data } => {
            let (schema, instance) = &channels[&header.channel_id];
            let (name, layout) = &layouts[schema];
            let mut leaves = Leaves::new();
            let value = decode_packed(layout, &data).expect("a whole message");
            leaves_of_ours(&value, "", &mut leaves);
            for (field, leaf) in leaves {
                if !field.contains("_padding") && !field.ends_with("[]") {
                    let key = (format!("{name} {instance}"), field[1..].to_owned());
                    columns.entry(key).or_default().push(leaf);
                }
            }
        }
        _ => {}
    });
    let found = found.expect("a readable log");
    assert!(found.complete, "{}: {found:?}", path.display());
    columns
}

/// The columns that `px4-ulog` finds.
fn theirs(path: &Path) -> Columns {
    let log = read_file(path.to_str().expect("a name in UTF-8")).expect("a readable log");
    assert!(!log.completeness.is_incomplete(), "{}: {:?}", path.display(), log.completeness);
    let topics = log.messages.iter();
    let instances = topics.flat_map(|(topic, all)| all.iter().map(move |one| (topic, one)));
    let fields = instances.flat_map(|(topic, (instance, fields))| {
        let channel = format!("{topic} {}", instance.value());
        fields.iter().map(move |(field, all)| ((channel.clone(), field.clone()), leaves(all)))
    });
    fields.collect()
}

fn leaves(values: &SomeVec) -> Vec<Leaf> {
    match values {
        SomeVec::Int8(all) => all.iter().copied().map(number).collect(),
        SomeVec::UInt8(all) => all.iter().copied().map(number).collect(),
        SomeVec::Int16(all) => all.iter().copied().map(number).collect(),
        SomeVec::UInt16(all) => all.iter().copied().map(number).collect(),
        SomeVec::Int32(all) => all.iter().copied().map(number).collect(),
        SomeVec::UInt32(all) => all.iter().copied().map(number).collect(),
        SomeVec::Int64(all) => all.iter().map(|value| number(*value as f64)).collect(),
        SomeVec::UInt64(all) => all.iter().map(|value| number(*value as f64)).collect(),
        SomeVec::Float(all) => all.iter().copied().map(number).collect(),
        SomeVec::Double(all) => all.iter().copied().map(number).collect(),
        SomeVec::Bool(all) => all.iter().map(|value| number(u8::from(*value))).collect(),
        SomeVec::Char(all) => all.iter().map(|value| number(u32::from(*value))).collect(),
    }
}

/// Asserts that both readers give the same columns; returns the number of values.
fn assert_equal(path: &Path) -> usize {
    let (ours, theirs) = (ours(path), theirs(path));
    let names = |columns: &Columns| columns.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&ours), names(&theirs), "{}", path.display());
    for (key, values) in &ours {
        // Not assert_eq, which would print thousands of values.
        assert!(*values == theirs[key], "{key:?} of {} differs", path.display());
    }
    ours.values().map(Vec::len).sum()
}

#[test]
fn every_value_of_made_logs_is_as_px4_ulog_reads_it() {
    let mut rng = Pcg64::seed_from_u64(12);
    for _ in 0..LOGS {
        let path = made::file("oracle.ulg", &made_log(&mut rng));
        assert!(assert_equal(&path) > 100);
    }
}

#[test]
fn every_value_of_a_real_log_is_as_px4_ulog_reads_it() {
    let Some(folder) = flights() else { return };
    let values = assert_equal(&folder.join("px4_arm/arm_01.ulg"));
    assert!(values > 100_000, "{values}");
}
