//! What is known of an MCAP file before a chunk is unpacked, and how a piece of it is read.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::io::{Read, Seek, SeekFrom};

use mcap::records::{Channel, MessageHeader, Metadata, Record, SchemaHeader};

use super::container::{CHUNK, Findings, HEAD_BYTES, LONGEST_RECORD_BYTES, unpack};

/// A file, or anything like it that can be read anywhere.
pub trait Input: Read + Seek + Debug + Send {}

impl<T: Read + Seek + Debug + Send> Input for T {}

/// A chunk in the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Place {
    /// First byte of its record.
    pub(super) at: u64,
    /// Bytes of its record, with head.
    pub(super) length: u64,
    /// Log time of its first and last message, ns; `None` if it holds no message.
    pub(super) span_ns: Option<(u64, u64)>,
    /// Messages per channel, where they were counted already.
    pub(super) counts: BTreeMap<u16, u64>,
    /// Where the message index of a channel lies, for those that were not.
    pub(super) indexes: BTreeMap<u16, u64>,
    /// The file ends inside it.
    pub(super) cut: bool,
}

/// Schemas and channels of a file.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    /// Name, encoding and text by number.
    pub(super) schemas: BTreeMap<u16, (SchemaHeader, Vec<u8>)>,
    /// Channels by number.
    pub(super) channels: BTreeMap<u16, Channel>,
}

impl Definitions {
    /// Keeps `record` if it defines something; the first definition of a channel holds.
    pub(super) fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, (header, data.into_owned()));
            }
            Record::Channel(channel) => {
                self.channels.entry(channel.id).or_insert(channel);
            }
            _ => {}
        }
    }

    /// As records, schemas first.
    pub(super) fn records(&self, on: &mut dyn FnMut(Record<'_>)) {
        for (header, data) in self.schemas.values() {
            on(Record::Schema { header: header.clone(), data: data.as_slice().into() });
        }
        for channel in self.channels.values() {
            on(Record::Channel(channel.clone()));
        }
    }
}

/// What is known of a file before a chunk is unpacked.
#[derive(Debug, Default)]
pub(super) struct Table {
    /// Chunks in the order of the file.
    pub(super) chunks: Vec<Place>,
    /// Schemas and channels.
    pub(super) definitions: Definitions,
    /// Messages per channel.
    pub(super) counts: BTreeMap<u16, u64>,
    /// Metadata records.
    pub(super) metadata: Vec<Metadata>,
    /// The container and its problems.
    pub(super) findings: Findings,
}

/// The records in the record of a chunk.
pub(super) fn unpack_record(
    record: &[u8],
    place: &Place,
    on: &mut dyn FnMut(Record<'_>),
) -> Result<(), String> {
    if record.first() != Some(&CHUNK) {
        return Err(format!("there is no chunk at byte {}", place.at));
    }
    match unpack(record, !place.cut, on) {
        Err(why) if !place.cut => {
            Err(format!("chunk at byte {} is damaged or unknown ({why}) and left out", place.at))
        }
        _ => Ok(()),
    }
}

/// `length` bytes from `at` on, at most as many as a record may have.
pub(super) fn read_at(input: &mut dyn Input, at: u64, length: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    input.seek(SeekFrom::Start(at))?;
    input.take(length.min(LONGEST_RECORD_BYTES + HEAD_BYTES as u64)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length {
        Ok(bytes)
    } else {
        Err(std::io::ErrorKind::UnexpectedEof.into())
    }
}

/// The message header of a record, if it is a message.
pub(super) fn header<'a>(record: &'a Record<'_>) -> Option<&'a MessageHeader> {
    match record {
        Record::Message { header, .. } => Some(header),
        _ => None,
    }
}
