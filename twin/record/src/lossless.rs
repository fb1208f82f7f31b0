//! A tick as JSON and back. Finite numbers survive bit for bit.
//!
//! JSON has no NaN: `serde_json` writes NaN and infinities as `null`, and refuses a `null` when it reads a number. A tick with a
//! fault holds such numbers. The reader here therefore reads a `null` in the place of a number as NaN.

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{DeserializeOwned, Deserializer, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use serde_json::{Error, Value};

/// Reads one record; `null` in the place of a number is NaN.
///
/// # Errors
/// `serde_json`'s error for text that is no JSON or not of the type `T`.
pub fn from_json<T: DeserializeOwned>(text: &[u8]) -> Result<T, Error> {
    // Nearly every record is finite, and `serde_json` alone reads those several times faster.
    if let Ok(record) = serde_json::from_slice(text) {
        return Ok(record);
    }
    T::deserialize(NanForNull(serde_json::from_slice(text)?))
}

struct NanForNull(Value);

impl NanForNull {
    fn number<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Value::Null => visitor.visit_f64(f64::NAN),
            other => NanForNull(other).deserialize_any(visitor),
        }
    }
}

impl<'de> Deserializer<'de> for NanForNull {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Value::Array(items) => {
                visitor.visit_seq(SeqDeserializer::new(items.into_iter().map(NanForNull)))
            }
            Value::Object(fields) => visitor.visit_map(MapDeserializer::new(
                fields.into_iter().map(|(key, value)| (key, NanForNull(value))),
            )),
            leaf => leaf.deserialize_any(visitor),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.number(visitor)
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.number(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Value::Null => visitor.visit_none(),
            other => visitor.visit_some(NanForNull(other)),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.0.deserialize_enum(name, variants, visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

impl IntoDeserializer<'_, Error> for NanForNull {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde::{Deserialize, Serialize};
    use twin_core::notation::Coords;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Sample {
        row: Coords,
        single: f64,
        many: Vec<f64>,
        maybe: Option<f64>,
        fault: Option<twin_core::tick::Fault>,
        command: twin_core::tick::GripperCommand,
    }

    fn sample(value: f64) -> Sample {
        Sample {
            row: Coords::repeat(value),
            single: value,
            many: vec![value, 0.1],
            maybe: Some(0.3),
            fault: Some(twin_core::tick::Fault::NonFiniteMeasurement),
            command: twin_core::tick::GripperCommand::Close,
        }
    }

    #[test]
    fn numbers_that_are_not_finite_come_back_as_nan_and_the_rest_unchanged() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let text = serde_json::to_vec(&sample(value)).unwrap();
            let back: Sample = from_json(&text).unwrap();
            assert!(
                back.row.iter().all(|x| x.is_nan())
                    && back.single.is_nan()
                    && back.many[0].is_nan()
            );
            assert_eq!((back.many[1].to_bits(), back.maybe), (0.1_f64.to_bits(), Some(0.3)));
            assert_eq!((back.fault, back.command), (sample(0.0).fault, sample(0.0).command));
        }
    }

    #[test]
    fn an_absent_option_stays_absent_beside_a_nan() {
        let text =
            serde_json::to_vec(&Sample { maybe: None, fault: None, ..sample(f64::NAN) }).unwrap();
        let back: Sample = from_json(&text).unwrap();
        assert!(back.maybe.is_none() && back.fault.is_none());
    }

    #[test]
    fn text_that_is_no_record_is_an_error() {
        for text in ["", "{", "null", "[]", r#"{"row":null}"#, r#"{"row":[1],"single":"x"}"#] {
            assert!(from_json::<Sample>(text.as_bytes()).is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn every_finite_number_survives_bit_for_bit(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let back: Sample = from_json(&serde_json::to_vec(&sample(value)).unwrap()).unwrap();
            prop_assert_eq!(back.single.to_bits(), bits);
            prop_assert_eq!(back.row[7].to_bits(), bits);
        }
    }
}
