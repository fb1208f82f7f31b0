//! `re_ros_msg` reads `ros2msg` definitions and the CDR messages that `re_cdr` writes.

use std::path::Path;

use mcap::records::Record;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use re_cdr::{BigEndian, CdrEndian, CdrReader, CdrWriter, LittleEndian};
use re_ros_msg::MessageSchema;
use re_ros_msg::deserialize::primitive_array::PrimitiveArray;
use re_ros_msg::deserialize::{MapResolver, TypeResolver, Value as Theirs, decode_message};
use re_ros_msg::message_spec::{ArraySize, BuiltInType, MessageSpecification, Type};
use twin_foreign::cdr::decode;
use twin_foreign::container;
use twin_foreign::schema::Layout;

use super::super::real::flights;
use super::{Leaf, Leaves, leaves_of_ours, number};

/// Definitions that are made, each with messages in both byte orders.
const DEFINITIONS: usize = 300;

/// Types of a definition.
const TYPES: usize = 4;

/// Messages of each channel of a real flight that are compared.
const OF_EACH_CHANNEL: u32 = 50;

/// The name that ROS 2 gives the byte of a type without fields.
const PADDING: &str = "structure_needs_at_least_one_member";

fn leaves_of_theirs(value: &Theirs, path: &str, out: &mut Leaves) {
    let leaf = match value {
        Theirs::Bool(value) => number(u8::from(*value)),
        Theirs::I8(value) => number(*value),
        Theirs::U8(value) => number(*value),
        Theirs::I16(value) => number(*value),
        Theirs::U16(value) => number(*value),
        Theirs::I32(value) => number(*value),
        Theirs::U32(value) => number(*value),
        Theirs::I64(value) => number(*value as f64),
        Theirs::U64(value) => number(*value as f64),
        Theirs::F32(value) => number(*value),
        Theirs::F64(value) => number(*value),
        Theirs::String(text) => Leaf::Text(text.clone()),
        Theirs::Array(values) | Theirs::Sequence(values) => {
            for (i, value) in values.iter().enumerate() {
                leaves_of_theirs(value, &format!("{path}[{i}]"), out);
            }
            out.insert(format!("{path}[]"), Leaf::Count(values.len()));
            return;
        }
        Theirs::PrimitiveArray(values) | Theirs::PrimitiveSeq(values) => {
            let values = elements(values);
            out.insert(format!("{path}[]"), Leaf::Count(values.len()));
            out.extend(
                values.into_iter().enumerate().map(|(i, leaf)| (format!("{path}[{i}]"), leaf)),
            );
            return;
        }
        Theirs::Message(fields) => {
            for (name, value) in fields.iter().filter(|(name, _)| *name != PADDING) {
                leaves_of_theirs(value, &format!("{path}.{name}"), out);
            }
            return;
        }
    };
    out.insert(path.to_owned(), leaf);
}

fn elements(values: &PrimitiveArray) -> Vec<Leaf> {
    match values {
        PrimitiveArray::Bool(all) => all.iter().map(|value| number(u8::from(*value))).collect(),
        PrimitiveArray::I8(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::U8(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::I16(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::U16(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::I32(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::U32(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::I64(all) => all.iter().map(|value| number(*value as f64)).collect(),
        PrimitiveArray::U64(all) => all.iter().map(|value| number(*value as f64)).collect(),
        PrimitiveArray::F32(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::F64(all) => all.iter().copied().map(number).collect(),
        PrimitiveArray::String(all) => all.iter().cloned().map(Leaf::Text).collect(),
    }
}

/// One line of a definition: a field, or at times a constant or a comment. The type `number` uses only types after itself.
fn made_line(number: usize, field: usize, rng: &mut Pcg64) -> String {
    const NUMBERS: [&str; 13] = [
        "bool", "byte", "char", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64",
        "uint64", "float32", "float64",
    ];
    let array = ["", "", "[3]", "[]", "[<=4]"][rng.random_range(0..5)];
    match rng.random_range(0..20) {
        0 => "# uint8 no_field".to_owned(),
        1 if number + 1 < TYPES => format!("uint8 CONSTANT_{field} = 7 # of type {number}"),
        2 if number + 1 < TYPES => format!("string WORD_{field}=\"a # b\""),
        3 => format!("float64   with_default_{field}\t1.5   # metres"),
        4..7 => format!("string{array} text_{field}"),
        7 => format!("string<=12{array} text_{field}"),
        8..12 if number + 1 < TYPES => {
            let other = rng.random_range(number + 1..TYPES);
            // Types 0 and 2 are of the package p, the others of the package q.
            let near = other % 2 == number % 2 && rng.random();
            let package = if near { "" } else { ["p/", "q/"][other % 2] };
            format!("{package}T{other}{array} inner_{field}")
        }
        _ => format!("{}{array} number_{field}", NUMBERS[rng.random_range(0..NUMBERS.len())]),
    }
}

/// A definition of the message `p/msg/T0`. Only the last type may have no field. It has no constant either, because the oracle
/// takes a type of constants alone for a number.
fn made_definition(rng: &mut Pcg64) -> String {
    let mut text = String::new();
    for number in 0..TYPES {
        if number > 0 {
            let package = ["p/", "q/"][number % 2];
            text += &["=".repeat(80), format!("\nMSG: {package}T{number}\n")].concat();
        }
        let least = usize::from(number + 1 < TYPES);
        let fields: Vec<String> =
            (0..rng.random_range(least..8)).map(|field| made_line(number, field, rng)).collect();
        text += &fields.join("\n");
        text += if number + 1 < TYPES { "\nuint8 last\n" } else { "\n" };
    }
    text
}

/// Writes random values of the type `ty`, which the type `scope` names.
fn write<BO: CdrEndian>(
    out: &mut CdrWriter<'_, BO>,
    scope: &MessageSpecification,
    ty: &Type,
    types: &MapResolver<'_>,
    rng: &mut Pcg64,
) {
    match ty {
        Type::BuiltIn(builtin) => write_one(out, builtin, rng),
        Type::Array { ty, size } => {
            let count = match size {
                ArraySize::Fixed(count) => *count,
                ArraySize::Bounded(_) | ArraySize::Unbounded => {
                    let count = rng.random_range(0..4);
                    out.write_sequence_length(count);
                    count
                }
            };
            (0..count).for_each(|_| write(out, scope, ty, types, rng));
        }
        Type::Complex(name) => {
            let inner = types.resolve(scope, name).expect("a type of the definition");
            inner.fields.iter().for_each(|field| write(out, inner, &field.ty, types, rng));
        }
    }
}

fn write_one<BO: CdrEndian>(out: &mut CdrWriter<'_, BO>, ty: &BuiltInType, rng: &mut Pcg64) {
    match ty {
        BuiltInType::Bool => out.write_bool(rng.random()),
        BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 => out.write_u8(rng.random()),
        BuiltInType::Int8 => out.write_i8(rng.random()),
        BuiltInType::Int16 => out.write_i16(rng.random()),
        BuiltInType::UInt16 => out.write_u16(rng.random()),
        BuiltInType::Int32 => out.write_i32(rng.random()),
        BuiltInType::UInt32 => out.write_u32(rng.random()),
        BuiltInType::Int64 => out.write_i64(rng.random()),
        BuiltInType::UInt64 => out.write_u64(rng.random()),
        // Any bits: also NaN, infinities and the smallest numbers.
        BuiltInType::Float32 => out.write_f32(f32::from_bits(rng.random())),
        BuiltInType::Float64 => out.write_f64(f64::from_bits(rng.random())),
        BuiltInType::String(_) => {
            out.write_string(["", "q0", "böse ✓", "base_link"][rng.random_range(0..4)]);
        }
        BuiltInType::WString(_) => unreachable!("no definition of this test has it"),
    }
}

/// A definition as both readers understand it.
struct Both {
    ours: Layout,
    theirs: MessageSchema,
}

impl Both {
    fn parse(name: &str, text: &str) -> Self {
        let ours = Layout::parse(name, text).unwrap_or_else(|why| panic!("{name}: {why}\n{text}"));
        let theirs = MessageSchema::parse(name, text);
        Self { ours, theirs: theirs.unwrap_or_else(|why| panic!("{name}: {why:#}\n{text}")) }
    }

    fn types(&self) -> MapResolver<'_> {
        MapResolver::new(self.theirs.dependencies.iter().map(|spec| (spec.name.clone(), spec)))
    }

    fn made_message<BO: CdrEndian>(&self, header: [u8; 4], rng: &mut Pcg64) -> Vec<u8> {
        let mut body = Vec::new();
        let (mut out, types, spec) =
            (CdrWriter::<BO>::new(&mut body), self.types(), &self.theirs.spec);
        spec.fields.iter().for_each(|field| write(&mut out, spec, &field.ty, &types, rng));
        [&header[..], &body].concat()
    }

    /// What our reader and theirs say of a message.
    fn read<BO: CdrEndian>(
        &self,
        message: &[u8],
    ) -> (Result<Leaves, String>, Result<Leaves, String>) {
        let ours = decode(&self.ours, message).map(|value| {
            let mut leaves = Leaves::new();
            leaves_of_ours(&value, "", &mut leaves);
            leaves
        });
        let mut body = CdrReader::<BO>::new(&message[4..]);
        let theirs = decode_message(&mut body, &self.theirs.spec, &self.types()).map(|value| {
            let mut leaves = Leaves::new();
            leaves_of_theirs(&value, "", &mut leaves);
            leaves
        });
        (ours, theirs.map_err(|why| why.to_string()))
    }
}

#[test]
fn made_definitions_and_messages_in_both_byte_orders_read_as_re_ros_msg_reads_them() {
    let mut rng = Pcg64::seed_from_u64(11);
    let mut values = 0;
    for _ in 0..DEFINITIONS {
        let text = made_definition(&mut rng);
        let both = Both::parse("p/msg/T0", &text);
        let little = both.made_message::<LittleEndian>([0, 1, 0, 0], &mut rng);
        let big = both.made_message::<BigEndian>([0, 0, 0, 0], &mut rng);
        for (ours, theirs) in [both.read::<LittleEndian>(&little), both.read::<BigEndian>(&big)] {
            let (ours, theirs) = (ours.expect("a whole message"), theirs.expect("a whole message"));
            assert_eq!(ours, theirs, "{text}");
            values += ours.len();
        }
        // A message that ends too early is refused by both.
        let cut = &little[..rng.random_range(4..little.len())];
        let (ours, theirs) = both.read::<LittleEndian>(cut);
        assert!(ours.is_err() && theirs.is_err(), "{text}\n{ours:?}\n{theirs:?}");
    }
    assert!(values > 20 * DEFINITIONS, "{values} values are too few to say something");
}

/// Compares the first messages of each channel that has a `ros2msg` definition; returns their number.
fn compared(path: &Path) -> u32 {
    let (mut definitions, mut channels, mut total) = (Vec::new(), Vec::new(), 0);
    let mut input = std::fs::File::open(path).expect("a flight");
    let read = container::read(&mut input, &mut |record| match record {
        Record::Schema { header, data } if header.encoding == "ros2msg" => {
            let text = std::str::from_utf8(&data).expect("a text");
            definitions.push((header.id, Both::parse(&header.name, text)));
        }
        Record::Channel(channel) => channels.push((channel.id, channel.schema_id, 0)),
        Record::Message { header, data } => {
            let Some((_, schema, count)) =
                channels.iter_mut().find(|(id, ..)| *id == header.channel_id)
            else {
                return;
            };
            let Some((_, both)) = definitions.iter().find(|(id, _)| id == schema) else { return };
            if *count < OF_EACH_CHANNEL {
                *count += 1;
                total += 1;
                let (ours, theirs) = both.read::<LittleEndian>(&data);
                assert_eq!(ours, theirs, "channel {} of {}", header.channel_id, path.display());
            }
        }
        _ => {}
    });
    read.expect("a readable file");
    total
}

#[test]
fn messages_of_real_flights_read_as_re_ros_msg_reads_them() {
    let Some(folder) = flights() else { return };
    for name in
        ["px4_arm/20250612_waypoint4_px4.mcap", "px4_arm/ros2bag_ats_2025-12-02_12-44-28_0.mcap"]
    {
        let messages = compared(&folder.join(name));
        assert!(messages > 200, "{name}: {messages} messages");
    }
}
