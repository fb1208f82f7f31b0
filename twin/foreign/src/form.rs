//! The forms in which messages are written, each read once from its definition.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;
use std::sync::Arc;

use mcap::records::Channel;

use super::message_definitions::{MessageDefinition, MessageDefinitions};
use super::protobuf::Descriptor;
use super::schema::Layout;
use super::value::Value;
use super::{cdr, ulog};
use twin_input::budget::{JSON_BYTES, STREAM_MESSAGE_BYTES, UNPACKED_RATIO};

/// Bytes to which a message of any size may unpack.
const SMALL_BYTES: u64 = 1 << 20;

/// How the messages of a channel are decoded.
#[derive(Debug)]
pub(super) enum Form {
    Cdr(Layout),
    Ulog(Layout),
    Ros1(Layout),
    Protobuf(Descriptor),
    Json,
}

/// Forms by number of the definition and encoding of the message. Many channels may share one definition, so each is read once.
#[derive(Debug, Default)]
pub(super) struct Forms {
    known: BTreeMap<(u16, String), Result<Arc<Form>, String>>,
}

impl Forms {
    /// The form of a channel's messages.
    ///
    /// # Errors
    /// A sentence that says why the messages cannot be decoded.
    pub(super) fn of(
        &mut self,
        definitions: &MessageDefinitions,
        channel: &Channel,
    ) -> Result<Arc<Form>, String> {
        let key = (channel.schema_id, channel.message_encoding.clone());
        let read = || {
            let definition = definitions.get(channel.schema_id);
            Form::read(definition, &channel.message_encoding).map(Arc::new)
        };
        self.known.entry(key).or_insert_with(read).clone()
    }

    /// Forgets the forms of a definition that has changed.
    pub(super) fn forget(&mut self, number: u16) {
        let before = (number, String::new());
        let forms = self.known.range(before..).take_while(|((known, _), _)| *known == number);
        let keys: Vec<(u16, String)> = forms.map(|(key, _)| key.clone()).collect();
        for key in keys {
            self.known.remove(&key);
        }
    }
}

impl Form {
    fn read(definition: Option<&MessageDefinition>, message: &str) -> Result<Self, String> {
        let (name, encoding, text) = match definition {
            None => ("", "", &[][..]),
            Some(MessageDefinition { header, text }) => {
                let text = text.as_deref().map_err(ToString::to_string)?;
                (&*header.name, &*header.encoding, text)
            }
        };
        match (encoding, message) {
            ("ros2msg", "cdr") => {
                Layout::parse(name, &String::from_utf8_lossy(text)).map(Self::Cdr)
            }
            ("ros2idl", "cdr") => {
                Layout::parse_idl(name, &String::from_utf8_lossy(text)).map(Self::Cdr)
            }
            ("ros1msg", "ros1") => {
                Layout::parse_ros1(name, &String::from_utf8_lossy(text)).map(Self::Ros1)
            }
            (ulog::ENCODING, _) => {
                Layout::parse_ulog(&String::from_utf8_lossy(text)).map(Self::Ulog)
            }
            ("protobuf", "protobuf") => Descriptor::parse(name, text).map(Self::Protobuf),
            (_, "json") => Ok(Self::Json),
            (schema, message) => Err(format!(
                "schema encoding {schema:?} with message encoding {message:?} is not read; read are ros2msg and ros2idl with cdr, ros1msg with ros1, protobuf, and json"
            )),
        }
    }

    /// Decodes one message.
    ///
    /// # Errors
    /// A sentence that says what is wrong with the message.
    pub(super) fn decode(&self, message: &[u8]) -> Result<Value, String> {
        match self {
            Self::Cdr(layout) => cdr::decode(layout, &unpacked(message)?),
            Self::Ulog(layout) | Self::Ros1(layout) => cdr::decode_packed(layout, message),
            Self::Protobuf(descriptor) => descriptor.decode(message),
            Self::Json => {
                JSON_BYTES.check_count(message.len()).map_err(|excess| excess.to_string())?;
                serde_json::from_slice::<serde_json::Value>(message)
                    .map(Value::from)
                    .map_err(|error| error.to_string())
            }
        }
    }
}

/// First bytes of a zstd frame; no message of ROS 2 begins with them.
const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// The message itself, where the recorder compressed each message (`--compression-mode message`).
fn unpacked(message: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    if !message.starts_with(&ZSTD) {
        return Ok(Cow::Borrowed(message));
    }
    let by_ratio =
        (message.len() as u64).saturating_mul(UNPACKED_RATIO).saturating_add(SMALL_BYTES);
    let most = by_ratio.min(STREAM_MESSAGE_BYTES.most);
    let damaged =
        |error: std::io::Error| format!("a message that zstd compressed is damaged: {error}");
    let mut whole = Vec::new();
    let decoder = zstd::Decoder::new(message).map_err(damaged)?;
    decoder.take(most + 1).read_to_end(&mut whole).map_err(damaged)?;
    if whole.len() as u64 > most {
        return Err(format!("a message unpacks to more than {most} bytes"));
    }
    Ok(Cow::Owned(whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_that_the_recorder_compressed_is_unpacked_and_a_bomb_is_refused() {
        let message: Vec<u8> = (0..200).collect();
        assert_eq!(*unpacked(&message).unwrap(), message);
        let packed = zstd::bulk::compress(&message, 1).unwrap();
        assert_eq!(*unpacked(&packed).unwrap(), message);
        for end in 4..packed.len() {
            assert!(unpacked(&packed[..end]).is_err(), "{end}");
        }
        let bomb = zstd::bulk::compress(&vec![0; STREAM_MESSAGE_BYTES.count() + 1], 1).unwrap();
        assert!(unpacked(&bomb).unwrap_err().contains("more than"));
    }
}
