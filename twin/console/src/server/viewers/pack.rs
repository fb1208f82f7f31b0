//! `MessagePack` for the viewers, with maps that keep the order of their keys, and with typed arrays.

use rmpv::Value;

/// Deepest nesting of a message that [`decode`] accepts.
const DEEPEST: usize = 16;

/// A map whose keys keep their order: `map! { "type" => "delete", "path" => path }`.
macro_rules! map {
    ($($key:expr => $value:expr),* $(,)?) => {
        ::rmpv::Value::Map(vec![$((::rmpv::Value::from($key), ::rmpv::Value::from($value))),*])
    };
}
pub(super) use map;

/// An array of numbers.
pub(super) fn numbers<const N: usize>(values: [f64; N]) -> Value {
    Value::Array(values.into_iter().map(Value::F64).collect())
}

/// The bytes of a value.
pub(super) fn encode(value: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    append(&mut bytes, value);
    bytes
}

/// Appends the bytes of a value.
pub(super) fn append(bytes: &mut Vec<u8>, value: &Value) {
    if let Err(error) = rmpv::encode::write_value(bytes, value) {
        tracing::error!("a message has no binary form: {error}");
    }
}

/// Appends the head of an array; the caller appends its `length` values.
pub(super) fn begin_array(bytes: &mut Vec<u8>, length: usize) {
    match u16::try_from(length) {
        Ok(few @ 0..16) => bytes.push(0x90 | few as u8),
        Ok(more) => {
            bytes.push(0xDC);
            bytes.extend(more.to_be_bytes());
        }
        Err(_) => {
            bytes.push(0xDD);
            bytes.extend((length as u32).to_be_bytes());
        }
    }
}

/// Overwrites the numbers at the end of an encoded message. The message must end with as many `Value::F32` as `values` has.
pub(super) fn overwrite_f32(bytes: &mut [u8], values: &[f32]) {
    /// Bytes of an f32: a byte for the type, and the number with its most significant byte first.
    const LENGTH: usize = 5;
    let end = bytes.len().saturating_sub(values.len() * LENGTH);
    for (slot, value) in bytes[end..].chunks_exact_mut(LENGTH).zip(values) {
        slot[1..].copy_from_slice(&value.to_be_bytes());
    }
}

/// Decodes `bytes`, which must hold exactly one value.
///
/// # Errors
/// A sentence if the bytes are not `MessagePack`, are nested too deep, or hold more than one value.
pub(super) fn decode(bytes: &[u8]) -> Result<Value, String> {
    // The reader decodes 0xc1 as nil, but the format never uses this byte.
    if bytes.first() == Some(&0xC1) {
        return Err("this is not MessagePack: it starts with the unused byte 0xc1".to_owned());
    }
    let mut rest = bytes;
    let value = rmpv::decode::read_value_with_max_depth(&mut rest, DEEPEST)
        .map_err(|error| format!("this is not MessagePack: {error}"))?;
    if rest.is_empty() {
        Ok(value)
    } else {
        Err(format!("{} bytes follow after the value", rest.len()))
    }
}

/// The value of a key of a map.
pub(super) fn get<'a>(map: &'a Value, key: &str) -> Option<&'a Value> {
    let entries = map.as_map()?;
    entries.iter().find(|(name, _)| name.as_str() == Some(key)).map(|(_, value)| value)
}

/// The value of a key of a map, if it is text.
pub(super) fn text<'a>(map: &'a Value, key: &str) -> Option<&'a str> {
    get(map, key).and_then(Value::as_str)
}

/// Little-endian bytes of numbers.
pub(super) fn f32_bytes(values: impl IntoIterator<Item = f32>) -> Vec<u8> {
    values.into_iter().flat_map(f32::to_le_bytes).collect()
}

/// Little-endian bytes of numbers.
pub(super) fn f64_bytes(values: impl IntoIterator<Item = f64>) -> Vec<u8> {
    values.into_iter().flat_map(f64::to_le_bytes).collect()
}

/// Little-endian bytes of indices.
pub(super) fn u32_bytes(values: impl IntoIterator<Item = u32>) -> Vec<u8> {
    values.into_iter().flat_map(u32::to_le_bytes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes were written by hand from the specification: fixmap, fixstr, float 64, fixarray, nil, bool, positive fixint, ext 8.
    #[test]
    fn a_message_has_the_bytes_of_the_specification() {
        let value = map! {
            "a" => 1.5,
            "b" => Value::Array(vec![Value::Nil, Value::Boolean(true), Value::from(7_u32)]),
            "c" => Value::Ext(0x17, f32_bytes([1.0, -2.0, 0.5])),
        };
        let mut wanted = vec![0x83, 0xA1, b'a', 0xCB, 0x3F, 0xF8, 0, 0, 0, 0, 0, 0];
        wanted.extend([0xA1, b'b', 0x93, 0xC0, 0xC3, 0x07]);
        wanted.extend([0xA1, b'c', 0xC7, 12, 0x17]);
        wanted.extend([0, 0, 0x80, 0x3F, 0, 0, 0, 0xC0, 0, 0, 0, 0x3F]);
        assert_eq!(encode(&value), wanted);
        assert_eq!(decode(&wanted), Ok(value));
    }

    #[test]
    fn what_is_put_together_by_hand_is_what_the_library_writes() {
        for length in [0, 15, 16, 65_535, 65_536] {
            let mut bytes = Vec::new();
            begin_array(&mut bytes, length);
            bytes.resize(bytes.len() + length, 0xC0);
            assert_eq!(bytes, encode(&Value::Array(vec![Value::Nil; length])), "{length}");
        }
        let triple = |values: [f32; 3]| {
            encode(&map! { "at" => Value::Array(values.map(Value::F32).to_vec()) })
        };
        let mut bytes = triple([0.0; 3]);
        overwrite_f32(&mut bytes, &[1.5, -2.0, 1e-7]);
        assert_eq!(bytes, triple([1.5, -2.0, 1e-7]));
    }

    #[test]
    fn broken_bytes_are_refused_without_harm() {
        let lies = [0xDF, 0xFF, 0xFF, 0xFF, 0xFF];
        let deep = vec![0x91; 60_000];
        for bytes in [&[][..], &[0xC1], &lies, &[0xC7, 200, 1], &deep, &[0xA5, b'a'], &[1, 2]] {
            assert!(decode(bytes).is_err(), "{:?}", &bytes[..bytes.len().min(8)]);
        }
    }
}
