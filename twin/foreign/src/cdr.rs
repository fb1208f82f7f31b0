//! Decodes CDR, the wire format of ROS 2 messages in little and big endian, along a [`Layout`].
//!
//! The decoder accepts any bytes: it reserves no more memory than the message is long, and it always terminates.

use super::schema::{Count, Field, Kind, Layout, Primitive};
use super::value::Value;

/// Length of the encapsulation header.
const HEADER_BYTES: usize = 4;

/// Largest number of values in one message, so that nested arrays of empty types terminate.
const MOST_VALUES: usize = 1 << 20;

/// Decodes one message.
///
/// # Errors
/// A sentence that says what is wrong and at which byte.
pub fn decode(layout: &Layout, message: &[u8]) -> Result<Value, String> {
    let little = match message.get(..2) {
        Some([0, 1]) => true,
        Some([0, 0]) => false,
        Some([a, b]) => {
            return Err(format!(
                "encapsulation {a:#04x} {b:#04x} is unknown, known are CDR_BE and CDR_LE"
            ));
        }
        _ => return Err("shorter than the CDR header".to_owned()),
    };
    let body = message.get(HEADER_BYTES..).ok_or("shorter than the CDR header")?;
    let mut reader = Reader { body, at: 0, little, packed: false, values: 0 };
    reader.record(layout, 0)
}

/// Decodes one message of a ULog file or of ROS 1: little endian, without a header, and without alignment.
///
/// # Errors
/// As [`decode`].
pub fn decode_packed(layout: &Layout, message: &[u8]) -> Result<Value, String> {
    let mut reader = Reader { body: message, at: 0, little: true, packed: true, values: 0 };
    reader.record(layout, 0)
}

struct Reader<'a> {
    body: &'a [u8],
    at: usize,
    little: bool,
    packed: bool,
    values: usize,
}

impl Reader<'_> {
    fn record(&mut self, layout: &Layout, number: usize) -> Result<Value, String> {
        let fields = &layout.types[number];
        if fields.is_empty() && !self.packed {
            // CDR sends a type without fields as one byte.
            self.take::<1>()?;
        }
        let values = fields
            .iter()
            .map(|field| Ok((field.name.clone(), self.field(layout, field)?)))
            .collect::<Result<_, String>>()?;
        Ok(Value::Record(values))
    }

    fn field(&mut self, layout: &Layout, field: &Field) -> Result<Value, String> {
        let count = match field.count {
            Count::One => return self.one(layout, field.kind),
            Count::Fixed(count) => count,
            Count::Sequence => self.length()?,
        };
        // Every element takes at least one byte, so a larger count is damage.
        if count > self.body.len().saturating_sub(self.at) {
            return Err(format!("{} claims {count} elements at byte {}", field.name, self.at));
        }
        match field.kind {
            Kind::Primitive(primitive) if primitive != Primitive::Text => (0..count)
                .map(|_| self.number(primitive))
                .collect::<Result<_, _>>()
                .map(Value::Numbers),
            kind => (0..count)
                .map(|_| self.one(layout, kind))
                .collect::<Result<_, _>>()
                .map(Value::List),
        }
    }

    fn one(&mut self, layout: &Layout, kind: Kind) -> Result<Value, String> {
        self.values += 1;
        if self.values > MOST_VALUES {
            return Err(format!("more than {MOST_VALUES} values"));
        }
        match kind {
            Kind::Type(number) => self.record(layout, number),
            Kind::Primitive(Primitive::Text) => self.text().map(Value::Text),
            Kind::Primitive(primitive) => self.number(primitive).map(Value::Number),
        }
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.length()?;
        let end = self.at.checked_add(length).filter(|end| *end <= self.body.len());
        let end = end.ok_or_else(|| format!("a text claims {length} bytes at byte {}", self.at))?;
        let bytes = &self.body[self.at..end];
        self.at = end;
        // The length in the message includes the terminating zero.
        Ok(String::from_utf8_lossy(bytes.strip_suffix(&[0]).unwrap_or(bytes)).into_owned())
    }

    fn length(&mut self) -> Result<usize, String> {
        Ok(self.number(Primitive::U32)? as usize)
    }

    fn number(&mut self, primitive: Primitive) -> Result<f64, String> {
        let bytes = primitive.bytes();
        if !self.packed {
            self.at = self.at.next_multiple_of(bytes);
        }
        Ok(match primitive {
            // PX4 leaves other bytes than 0 and 1 in fields that it does not set.
            Primitive::Bool => f64::from(u8::from(self.take()? != [0])),
            Primitive::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Primitive::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Primitive::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Primitive::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Primitive::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Primitive::U32 | Primitive::Text => f64::from(u32::from_le_bytes(self.take()?)),
            Primitive::I64 => i64::from_le_bytes(self.take()?) as f64,
            Primitive::U64 => u64::from_le_bytes(self.take()?) as f64,
            Primitive::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Primitive::F64 => f64::from_le_bytes(self.take()?),
            Primitive::WideText => return Err("a wstring has no agreed form in CDR".to_owned()),
        })
    }

    /// The next bytes in little-endian order.
    fn take<const D: usize>(&mut self) -> Result<[u8; D], String> {
        let bytes = self.body.get(self.at..).and_then(|rest| rest.first_chunk::<D>());
        let mut bytes =
            *bytes.ok_or_else(|| format!("the message ends at byte {}", self.body.len()))?;
        self.at += D;
        if !self.little {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::Path;

    const TEXT: &str = "uint8 a\nfloat64 b\nstring name\nfloat32[] values\nInner inner\n===\nMSG: p/Inner\nint16 c\n";

    /// A message written by hand from the CDR rules: each number is aligned to its size, counted from the end of the header.
    fn message(little: bool) -> Vec<u8> {
        let mut body: Vec<u8> = vec![7, 0, 0, 0, 0, 0, 0, 0];
        let order = |mut bytes: Vec<u8>| {
            if !little {
                bytes.reverse();
            }
            bytes
        };
        body.extend(order(1.5_f64.to_le_bytes().to_vec()));
        body.extend(order(3_u32.to_le_bytes().to_vec()));
        body.extend(b"xy\0\0");
        body.extend(order(2_u32.to_le_bytes().to_vec()));
        body.extend(order(0.5_f32.to_le_bytes().to_vec()));
        body.extend(order(f32::NAN.to_le_bytes().to_vec()));
        body.extend(order((-2_i16).to_le_bytes().to_vec()));
        [vec![0, u8::from(little), 0, 0], body].concat()
    }

    #[test]
    fn both_byte_orders_give_the_values_written() {
        let layout = Layout::parse("p/msg/Outer", TEXT).unwrap();
        for little in [true, false] {
            let value = decode(&layout, &message(little)).unwrap();
            let number = |path: &str| value.number(&Path::parse(path).unwrap());
            assert_eq!(number("a"), Some(7.0));
            assert_eq!(number("b"), Some(1.5));
            assert_eq!(number("values[0]"), Some(0.5));
            assert!(number("values[1]").unwrap().is_nan());
            assert_eq!(number("inner.c"), Some(-2.0));
            assert_eq!(value.at(&Path::parse("name").unwrap()).unwrap().texts(), ["xy"]);
        }
    }

    #[test]
    fn a_message_of_ros_1_has_times_of_two_numbers_and_texts_without_an_end() {
        let text = "Header header\nfloat64 x\n===\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
        let layout = Layout::parse_ros1("p/A", text).unwrap();
        // Written by hand from the rules of ROS 1: no header, no padding, and the length of a text is that of its letters.
        let mut message: Vec<u8> =
            [7_u32, 12, 500, 3].iter().flat_map(|n| n.to_le_bytes()).collect();
        message.extend(b"map");
        message.extend(1.5_f64.to_le_bytes());
        let value = decode_packed(&layout, &message).unwrap();
        let number = |path: &str| value.number(&Path::parse(path).unwrap());
        assert_eq!(number("header.stamp.sec"), Some(12.0));
        assert_eq!(number("header.stamp.nsec"), Some(500.0));
        assert_eq!(number("x"), Some(1.5));
    }

    #[test]
    fn a_message_cut_anywhere_and_a_length_beyond_it_are_errors() {
        let layout = Layout::parse("p/msg/Outer", TEXT).unwrap();
        let whole = message(true);
        for end in 0..whole.len() {
            assert!(decode(&layout, &whole[..end]).is_err(), "{end}");
        }
        let mut long = whole;
        long[28..32].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(decode(&layout, &long).unwrap_err().contains("4294967295"));
    }
}
