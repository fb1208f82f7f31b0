//! The table of an MCAP file: positions, definitions and counts that are known before a chunk is unpacked; and reading one piece.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::io::{Read, Seek, SeekFrom};

use mcap::records::{Channel, MessageHeader, Metadata, Record};

use super::container::Findings;
use super::message_definitions::{MessageDefinition, MessageDefinitions};
use twin_input::Inflation;
use twin_input::budget::RECORD_BYTES;
use twin_record::pieces::{CHUNK, HEAD_BYTES, unpack};

/// A file, or another input that can be read at any position.
pub trait Input: Read + Seek + Debug + Send {}

impl<T: Read + Seek + Debug + Send> Input for T {}

/// Position and content of one chunk.
#[derive(Clone, Debug, Default)]
pub(super) struct ChunkEntry {
    /// Offset of the first byte of its record.
    pub(super) at: u64,
    /// Length of its record with the head, bytes.
    pub(super) length: u64,
    /// Log times of its first and last message, ns; `None` if it contains no message.
    pub(super) span_ns: Option<(u64, u64)>,
    /// Message counts per channel, where they are known already.
    pub(super) counts: BTreeMap<u16, u64>,
    /// Offset of the message index of each channel whose messages are not yet counted.
    pub(super) indexes: BTreeMap<u16, u64>,
    /// True if the file ends inside the chunk.
    pub(super) cut: bool,
}

/// Schemas and channels of a file.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    /// Message definitions.
    pub(super) schemas: MessageDefinitions,
    /// Channels by number.
    pub(super) channels: BTreeMap<u16, Channel>,
}

impl Definitions {
    /// Stores `record` if it defines a schema or a channel; the first definition of a channel stays in force.
    pub(super) fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                self.schemas.take(header, &data);
            }
            Record::Channel(channel) => {
                self.channels.entry(channel.id).or_insert(channel);
            }
            _ => {}
        }
    }

    /// Passes on the definitions as records, schemas first.
    pub(super) fn records(&self, on: &mut dyn FnMut(Record<'_>)) {
        self.schemas.all().for_each(|schema| on(record(schema)));
        for channel in self.channels.values() {
            on(Record::Channel(channel.clone()));
        }
    }

    /// Passes on the definition of one channel as records, its schema first.
    pub(super) fn records_of(&self, channel: u16, on: &mut dyn FnMut(Record<'_>)) {
        let Some(channel) = self.channels.get(&channel) else { return };
        self.schemas.get(channel.schema_id).into_iter().for_each(|schema| on(record(schema)));
        on(Record::Channel(channel.clone()));
    }
}

/// The record of a definition; the text of one that the budget refuses is empty.
fn record(schema: &MessageDefinition) -> Record<'_> {
    let text = schema.text.as_deref().unwrap_or_default();
    Record::Schema { header: schema.header.clone(), data: text.into() }
}

/// All that is known of a file before a chunk is unpacked.
#[derive(Debug, Default)]
pub(super) struct Table {
    /// Chunks in file order.
    pub(super) chunks: Vec<ChunkEntry>,
    /// Schemas and channels.
    pub(super) definitions: Definitions,
    /// Message counts per channel.
    pub(super) counts: BTreeMap<u16, u64>,
    /// Metadata records.
    pub(super) metadata: Vec<Metadata>,
    /// The container and its problems.
    pub(super) findings: Findings,
}

/// Passes on the records inside the record of a chunk.
pub(super) fn unpack_record(
    record: &[u8],
    place: &ChunkEntry,
    inflation: &mut Inflation,
    on: &mut dyn FnMut(Record<'_>),
) -> Result<(), String> {
    if record.first() != Some(&CHUNK) {
        return Err(format!("there is no chunk at byte {}", place.at));
    }
    match unpack(record, !place.cut, inflation, on) {
        Err(why) if !place.cut => {
            Err(format!("chunk at byte {} is damaged or unknown ({why}) and left out", place.at))
        }
        _ => Ok(()),
    }
}

/// Reads `length` bytes at offset `at`, at most as many as a record may have.
pub(super) fn read_at(input: &mut dyn Input, at: u64, length: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    input.seek(SeekFrom::Start(at))?;
    input.take(length.min(RECORD_BYTES.most + HEAD_BYTES as u64)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length {
        Ok(bytes)
    } else {
        Err(std::io::ErrorKind::UnexpectedEof.into())
    }
}

/// The header of the message, if the record is a message.
pub(super) fn header<'a>(record: &'a Record<'_>) -> Option<&'a MessageHeader> {
    match record {
        Record::Message { header, .. } => Some(header),
        _ => None,
    }
}
