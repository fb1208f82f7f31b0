//! Decodes Protobuf messages by the `FileDescriptorSet` that a recording embeds.
//!
//! The decoder accepts any bytes: it reserves no more memory than the message is long, follows no type deeper than `DEEPEST`,
//! and always terminates. A number or text that was not sent has its proto3 default; a message that was not sent is absent.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::value::Value;
use twin_input::budget::NAME_BYTES;
use twin_input::work;

/// Deepest nesting of messages, and of the types in a descriptor.
const DEEPEST: usize = 16;

/// Largest number of values in one message, defaults included.
const MOST_VALUES: usize = 1 << 20;

/// Wire types.
const VARINT: u8 = 0;
const EIGHT: u8 = 1;
const BYTES: u8 = 2;
const FOUR: u8 = 5;

/// Label of a repeated field, and the numbers of the types, from `descriptor.proto`.
const REPEATED: u64 = 3;
const DOUBLE: u64 = 1;
const FLOAT: u64 = 2;
const INT64: u64 = 3;
const INT32: u64 = 5;
const BOOL: u64 = 8;
const STRING: u64 = 9;
const MESSAGE: u64 = 11;
const BYTE_STRING: u64 = 12;
const UINT32: u64 = 13;
const ENUM: u64 = 14;
const SFIXED32: u64 = 15;
const SFIXED64: u64 = 16;
const SINT32: u64 = 17;
const SINT64: u64 = 18;

/// The types of a message; the message itself is first.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor {
    types: Vec<Type>,
}

/// A message type.
#[derive(Clone, Debug, PartialEq)]
struct Type {
    fields: Vec<Field>,
    /// Places of the fields by their numbers; of two fields with one number the first counts.
    places: HashMap<u64, usize>,
}

impl Type {
    fn new(fields: Vec<Field>) -> Self {
        let places = fields.iter().enumerate().rev().map(|(at, field)| (field.number, at));
        Self { places: places.collect(), fields }
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Field {
    name: Arc<str>,
    number: u64,
    repeated: bool,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// A number of this type.
    Number(u64),
    Text,
    Message(usize),
    /// Bytes, groups and unknown messages, which the decoder skips.
    Unread,
}

/// One field as it was sent.
enum Sent<'a> {
    Number(u64, u8),
    Bytes(&'a [u8]),
}

/// Splits `bytes` into its fields, in order.
fn fields<'a>(
    mut bytes: &'a [u8],
    on: &mut dyn FnMut(u64, Sent<'a>) -> Result<(), String>,
) -> Result<(), String> {
    while !bytes.is_empty() {
        let key = varint(&mut bytes)?;
        let wire = (key & 7) as u8;
        let sent = match wire {
            VARINT => Sent::Number(varint(&mut bytes)?, wire),
            EIGHT => Sent::Number(u64::from_le_bytes(take(&mut bytes)?), wire),
            FOUR => Sent::Number(u64::from(u32::from_le_bytes(take(&mut bytes)?)), wire),
            BYTES => {
                let length = varint(&mut bytes)?;
                let length = usize::try_from(length).unwrap_or(usize::MAX);
                let (part, rest) = bytes
                    .split_at_checked(length)
                    .ok_or_else(|| format!("a field claims {length} bytes"))?;
                bytes = rest;
                Sent::Bytes(part)
            }
            other => return Err(format!("wire type {other} is not read")),
        };
        on(key >> 3, sent)?;
    }
    Ok(())
}

fn varint(bytes: &mut &[u8]) -> Result<u64, String> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let [byte] = take(bytes)?;
        value |= u64::from(byte & 0x7F) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err("a number longer than ten bytes".to_owned())
}

fn take<const D: usize>(bytes: &mut &[u8]) -> Result<[u8; D], String> {
    let (first, rest) = bytes.split_first_chunk::<D>().ok_or("the message ends inside a field")?;
    *bytes = rest;
    Ok(*first)
}

/// A type from the descriptor: its fields, each with the name of its type.
type Found<'a> = Vec<(Field, &'a [u8])>;

impl Descriptor {
    /// Reads the message type `name` (`package.Type`) from the `FileDescriptorSet` in `set`.
    ///
    /// # Errors
    /// A sentence that says what was not understood, or that the type is missing.
    pub fn parse(name: &str, set: &[u8]) -> Result<Self, String> {
        let mut found: BTreeMap<String, Found<'_>> = BTreeMap::new();
        fields(set, &mut |number, sent| match (number, sent) {
            (1, Sent::Bytes(file)) => file_types(file, &mut found),
            _ => Ok(()),
        })?;
        let own =
            found.remove_entry(name).ok_or_else(|| format!("no type {name} in its schema"))?;
        let all: Vec<(String, Found<'_>)> = std::iter::once(own).chain(found).collect();
        let places: HashMap<&[u8], usize> =
            all.iter().enumerate().map(|(place, (name, _))| (name.as_bytes(), place)).collect();
        let place = |wanted: &[u8]| {
            work::steps(1);
            places.get(wanted.strip_prefix(b".").unwrap_or(wanted)).copied()
        };
        let settled = |(field, kind): &(Field, &[u8])| {
            let mut field = field.clone();
            if let Kind::Message(_) = field.kind {
                field.kind = place(kind).map_or(Kind::Unread, Kind::Message);
            }
            field
        };
        let types = all.iter().map(|(_, found)| found.iter().map(settled).collect());
        Ok(Self { types: types.map(Type::new).collect() })
    }

    /// Decodes one message.
    ///
    /// # Errors
    /// A sentence that says what is wrong with the message.
    pub fn decode(&self, message: &[u8]) -> Result<Value, String> {
        self.record(0, message, 0, &mut 0)
    }

    fn record(
        &self,
        number: usize,
        bytes: &[u8],
        depth: usize,
        values: &mut usize,
    ) -> Result<Value, String> {
        let Type { fields: known, places } = &self.types[number];
        *values += 1 + known.len();
        if depth > DEEPEST || *values > MOST_VALUES {
            return Err(format!(
                "deeper than {DEEPEST} messages or more than {MOST_VALUES} values"
            ));
        }
        let mut found: Vec<Option<Value>> = known.iter().map(default).collect();
        fields(bytes, &mut |number, sent| {
            work::steps(1);
            let Some(&at) = places.get(&number) else { return Ok(()) };
            let (field, place) = (&known[at], &mut found[at]);
            match (field.kind, sent) {
                (Kind::Number(kind), Sent::Number(bits, wire)) => {
                    put_number(place, field, number_of(kind, bits, wire)?);
                }
                (Kind::Number(kind), Sent::Bytes(packed)) => {
                    packed_numbers(kind, packed, &mut |value| put_number(place, field, value))?;
                }
                (Kind::Text, Sent::Bytes(text)) => {
                    put(place, field, Value::Text(String::from_utf8_lossy(text).into_owned()));
                }
                (Kind::Message(kind), Sent::Bytes(inner)) => {
                    put(place, field, self.record(kind, inner, depth + 1, values)?);
                }
                (Kind::Unread, _) => {}
                _ => return Err(format!("{} is not sent as its schema says", field.name)),
            }
            Ok(())
        })?;
        let sent = known.iter().zip(found);
        Ok(Value::Record(sent.filter_map(|(f, value)| Some((f.name.clone(), value?))).collect()))
    }
}

/// The default value of a field that was not sent.
fn default(field: &Field) -> Option<Value> {
    match (field.kind, field.repeated) {
        (Kind::Unread, _) | (Kind::Message(_), false) => None,
        (Kind::Number(_), true) => Some(Value::Numbers(Vec::new())),
        (_, true) => Some(Value::List(Vec::new())),
        (Kind::Number(_), false) => Some(Value::Number(0.0)),
        (Kind::Text, false) => Some(Value::Text(String::new())),
    }
}

fn put_number(place: &mut Option<Value>, field: &Field, value: f64) {
    match place {
        Some(Value::Numbers(values)) if field.repeated => values.push(value),
        _ => *place = Some(Value::Number(value)),
    }
}

fn put(place: &mut Option<Value>, field: &Field, value: Value) {
    match place {
        Some(Value::List(values)) if field.repeated => values.push(value),
        _ => *place = Some(value),
    }
}

/// The value of a number of type `kind` that was sent with wire type `wire`.
fn number_of(kind: u64, bits: u64, wire: u8) -> Result<f64, String> {
    let wanted = wire_of(kind);
    if wire != wanted {
        return Err(format!("a number of type {kind} was sent as wire type {wire}"));
    }
    let unzigzag = || (bits >> 1).cast_signed() ^ -((bits & 1).cast_signed());
    Ok(match kind {
        DOUBLE => f64::from_bits(bits),
        FLOAT => f64::from(f32::from_bits(bits as u32)),
        INT64 | SFIXED64 => bits.cast_signed() as f64,
        // The sender extends negative numbers to 64 bits.
        INT32 | ENUM | SFIXED32 => f64::from((bits as u32).cast_signed()),
        UINT32 => f64::from(bits as u32),
        BOOL => f64::from(u8::from(bits != 0)),
        SINT32 | SINT64 => unzigzag() as f64,
        _ => bits as f64,
    })
}

/// The wire type of a number of type `kind`.
fn wire_of(kind: u64) -> u8 {
    match kind {
        DOUBLE | 6 | SFIXED64 => EIGHT,
        FLOAT | 7 | SFIXED32 => FOUR,
        _ => VARINT,
    }
}

fn packed_numbers(kind: u64, mut packed: &[u8], on: &mut dyn FnMut(f64)) -> Result<(), String> {
    let wire = wire_of(kind);
    while !packed.is_empty() {
        let bits = match wire {
            EIGHT => u64::from_le_bytes(take(&mut packed)?),
            FOUR => u64::from(u32::from_le_bytes(take(&mut packed)?)),
            _ => varint(&mut packed)?,
        };
        on(number_of(kind, bits, wire)?);
    }
    Ok(())
}

/// Collects the types in a `FileDescriptorProto`.
fn file_types<'a>(file: &'a [u8], found: &mut BTreeMap<String, Found<'a>>) -> Result<(), String> {
    let (mut package, mut types) = (String::new(), Vec::new());
    fields(file, &mut |number, sent| {
        match (number, sent) {
            (2, Sent::Bytes(name)) => package = String::from_utf8_lossy(name).into_owned(),
            (4, Sent::Bytes(kind)) => types.push(kind),
            _ => {}
        }
        Ok(())
    })?;
    types.into_iter().try_for_each(|kind| message_type(kind, &package, found, 0))
}

/// Collects a `DescriptorProto` and the types nested in it.
fn message_type<'a>(
    bytes: &'a [u8],
    outer: &str,
    found: &mut BTreeMap<String, Found<'a>>,
    depth: usize,
) -> Result<(), String> {
    if depth > DEEPEST {
        return Err(format!("types are nested deeper than {DEEPEST}"));
    }
    let (mut name, mut nested, mut own) = (String::new(), Vec::new(), Vec::new());
    fields(bytes, &mut |number, sent| {
        match (number, sent) {
            (1, Sent::Bytes(text)) => name = String::from_utf8_lossy(text).into_owned(),
            (2, Sent::Bytes(field)) => own.push(field_of(field)?),
            (3, Sent::Bytes(inner)) => nested.push(inner),
            _ => {}
        }
        Ok(())
    })?;
    // The full name of every nested type holds the name of its owner, so a long name would be copied for each.
    NAME_BYTES.check_count(outer.len() + name.len()).map_err(|excess| excess.to_string())?;
    let full = if outer.is_empty() { name } else { format!("{outer}.{name}") };
    nested.into_iter().try_for_each(|inner| message_type(inner, &full, found, depth + 1))?;
    found.insert(full, own);
    Ok(())
}

/// Reads a `FieldDescriptorProto`; returns the field and the name of its type.
fn field_of(bytes: &[u8]) -> Result<(Field, &[u8]), String> {
    let (mut name, mut kind_name) = (&b""[..], &b""[..]);
    let (mut number, mut label, mut kind) = (0, 0, 0);
    fields(bytes, &mut |field, sent| {
        match (field, sent) {
            (1, Sent::Bytes(text)) => name = text,
            (3, Sent::Number(value, _)) => number = value,
            (4, Sent::Number(value, _)) => label = value,
            (5, Sent::Number(value, _)) => kind = value,
            (6, Sent::Bytes(text)) => kind_name = text,
            _ => {}
        }
        Ok(())
    })?;
    let kind = match kind {
        STRING => Kind::Text,
        // The index of the type is set when all types are known.
        MESSAGE => Kind::Message(0),
        BYTE_STRING | 10 => Kind::Unread,
        DOUBLE..=SINT64 => Kind::Number(kind),
        other => return Err(format!("field type {other} is unknown")),
    };
    let name = String::from_utf8_lossy(name).into();
    Ok((Field { name, number, repeated: label == REPEATED, kind }, kind_name))
}

#[cfg(test)]
#[path = "protobuf_tests.rs"]
mod tests;
