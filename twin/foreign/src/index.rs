//! The position, times and message counts of the chunks of an MCAP file, known without unpacking them.
//!
//! They come from the summary at the end of the file. If there is no summary (the recorder was killed), the index steps from
//! record to record and reads the heads of the chunks alone. Any chunk can then be read by itself.

use std::collections::BTreeMap;
use std::io::SeekFrom;
use std::sync::{Arc, Mutex, PoisonError};

use mcap::records::{Channel, ChunkIndex, Record, SchemaHeader};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};

use super::container::ContainerError;
use super::scan;
use super::table::{ChunkEntry, Definitions, Input, Table, read_at, unpack_record};
use twin_input::Inflation;
use twin_input::budget::RECORD_BYTES;
use twin_record::pieces::HEAD_BYTES;

/// An open file whose chunks can be read in any order.
#[derive(Debug)]
pub(super) struct Index {
    input: Mutex<Box<dyn Input>>,
    /// What the chunks that were unpacked so far have become.
    inflation: Mutex<Inflation>,
    /// The positions and definitions that are known so far.
    pub(super) table: Table,
}

impl Index {
    /// The index of `input`; `None` if it is no MCAP file with chunks. Such a file can only be read from start to end.
    ///
    /// # Errors
    /// [`ContainerError`] if the system refuses.
    pub(super) fn new(mut input: Box<dyn Input>) -> Result<Option<Self>, ContainerError> {
        let length = input.seek(SeekFrom::End(0))?;
        if length < mcap::MAGIC.len() as u64 {
            return Ok(None);
        }
        if read_at(&mut *input, 0, mcap::MAGIC.len() as u64)? != mcap::MAGIC {
            return Ok(None);
        }
        // An unusable summary counts as a missing one.
        let table = match summary(&mut *input, length).filter(|table| !table.chunks.is_empty()) {
            Some(table) => Some(table),
            None => scan::scan(&mut *input, length)?,
        };
        Ok(table.map(|table| Self { input: Mutex::new(input), inflation: Mutex::default(), table }))
    }

    /// Log times of the first and the last message, ns.
    pub(super) fn span_ns(&self) -> Option<(u64, u64)> {
        let spans = || self.table.chunks.iter().filter_map(|place| place.span_ns);
        Some((spans().map(|span| span.0).min()?, spans().map(|span| span.1).max()?))
    }

    /// Numbers of the chunks that may contain messages with log times from `from_ns` to `to_ns`, in file order.
    pub(super) fn between(&self, from_ns: u64, to_ns: u64) -> impl Iterator<Item = usize> + '_ {
        let overlaps = move |place: &ChunkEntry| {
            place.span_ns.is_some_and(|(first, last)| first <= to_ns && last >= from_ns)
        };
        self.table.chunks.iter().enumerate().filter(move |(_, p)| overlaps(p)).map(|(n, _)| n)
    }

    /// The channel of `topic` with the most messages, and its message count.
    pub(super) fn channel(&self, topic: &str) -> Option<(u16, u64)> {
        let channels = self.table.definitions.channels.values();
        channels
            .filter(|channel| channel.topic == topic)
            .map(|channel| (channel.id, self.channel_messages(channel.id)))
            .max_by_key(|(_, messages)| *messages)
    }

    /// Number of messages of a channel in the whole file.
    pub(super) fn channel_messages(&self, channel: u16) -> u64 {
        self.table.counts.get(&channel).copied().unwrap_or(0)
    }

    /// Number of messages of `channel` in chunk `number`.
    ///
    /// # Errors
    /// A sentence if the index of the chunk cannot be read.
    pub(super) fn messages(&self, number: usize, channel: u16) -> Result<u64, String> {
        let place = &self.table.chunks[number];
        if let Some(count) = place.counts.get(&channel) {
            return Ok(*count);
        }
        let Some(at) = place.indexes.get(&channel) else { return Ok(0) };
        let head = self.read(*at, scan::MESSAGE_INDEX_HEAD_BYTES as u64)?;
        match scan::message_index(&head) {
            Some((found, count)) if found == channel => Ok(count),
            _ => Err(format!("there is no message index at byte {at}")),
        }
    }

    /// Passes on every record of chunk `number`, or none if its checksum is wrong. If the file ends inside the chunk, passes on
    /// its whole records.
    ///
    /// # Errors
    /// A sentence that says what is wrong with the chunk.
    pub(super) fn unpack(
        &self,
        number: usize,
        on: &mut dyn FnMut(Record<'_>),
    ) -> Result<(), String> {
        let place = &self.table.chunks[number];
        let record = self.read(place.at, place.length)?;
        // The lock is not held while the chunk is unpacked, so that threads unpack side by side.
        let mut inflation = *self.inflation.lock().unwrap_or_else(PoisonError::into_inner);
        let end = unpack_record(&record, place, &mut inflation, on);
        *self.inflation.lock().unwrap_or_else(PoisonError::into_inner) = inflation;
        end
    }

    fn read(&self, at: u64, length: u64) -> Result<Vec<u8>, String> {
        // A thread that panicked during a read left the input usable: every read seeks first.
        let mut input = self.input.lock().unwrap_or_else(PoisonError::into_inner);
        read_at(&mut **input, at, length).map_err(|error| format!("byte {at}: {error}"))
    }
}

/// The table from the summary of the file; `None` if the summary is missing, damaged or incomplete.
fn summary(input: &mut dyn Input, length: u64) -> Option<Table> {
    let options = SummaryReaderOptions::default()
        .with_file_size(length)
        .with_record_length_limit(RECORD_BYTES.count());
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.ok()? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let read = input.read(reader.insert(wanted)).ok()?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(input.seek(to).ok()?),
        }
    }
    let found = reader.finish()?;
    let statistics = found.stats?;
    let told = statistics.chunk_count as usize == found.chunk_indexes.len()
        && statistics.channel_count as usize == found.channels.len();
    let inside = found.chunk_indexes.iter().all(|chunk| {
        chunk.chunk_length <= RECORD_BYTES.most + HEAD_BYTES as u64
            && chunk.chunk_start_offset.checked_add(chunk.chunk_length).is_some_and(|e| e <= length)
    });
    if !(told && inside) {
        return None;
    }
    let mut table = Table { counts: statistics.channel_message_counts, ..Table::default() };
    define(&mut table.definitions, found.channels.into_values());
    place(&mut table, found.chunk_indexes);
    table.findings.complete = true;
    for place in found.metadata_indexes {
        let record = read_at(input, place.offset, place.length).ok()?;
        if let Ok(Record::Metadata(metadata)) =
            mcap::parse_record(*record.first()?, record.get(HEAD_BYTES..)?)
        {
            table.metadata.push(metadata);
        }
    }
    scan::header(input, &mut table.findings).ok()?;
    Some(table)
}

/// Stores these channels and their schemas.
fn define<'a>(
    definitions: &mut Definitions,
    channels: impl Iterator<Item = Arc<mcap::Channel<'a>>>,
) {
    for channel in channels {
        let schema_id = channel.schema.as_ref().map_or(0, |schema| schema.id);
        if let Some(schema) = &channel.schema {
            let (name, encoding) = (schema.name.clone(), schema.encoding.clone());
            definitions.take(Record::Schema {
                header: SchemaHeader { id: schema.id, name, encoding },
                data: schema.data.as_ref().into(),
            });
        }
        definitions.take(Record::Channel(Channel {
            id: channel.id,
            schema_id,
            topic: channel.topic.clone(),
            message_encoding: channel.message_encoding.clone(),
            metadata: channel.metadata.clone(),
        }));
    }
}

/// Stores the positions of these chunks.
fn place(table: &mut Table, chunks: Vec<ChunkIndex>) {
    for chunk in chunks {
        let counts = counted(&chunk).unwrap_or_default();
        let name = if chunk.compression.is_empty() { "none".into() } else { chunk.compression };
        table.findings.compressions.insert(name);
        let (first, last) = (chunk.message_start_time, chunk.message_end_time);
        // A chunk without a message has two zero times and no message index.
        let empty = last == 0 && chunk.message_index_offsets.is_empty();
        table.chunks.push(ChunkEntry {
            at: chunk.chunk_start_offset,
            length: chunk.chunk_length,
            span_ns: (!empty && first <= last).then_some((first, last)),
            counts,
            indexes: chunk.message_index_offsets,
            cut: false,
        });
    }
    table.chunks.sort_by_key(|place| place.at);
    table.findings.chunks = table.chunks.len() as u64;
}

/// Messages per channel of a chunk, computed from the positions of its message indexes; `None` if those do not follow the chunk
/// without a gap. Reading the indexes themselves would go through the whole file.
fn counted(chunk: &ChunkIndex) -> Option<BTreeMap<u16, u64>> {
    let begin = chunk.chunk_start_offset.checked_add(chunk.chunk_length)?;
    let end = begin.checked_add(chunk.message_index_length)?;
    let mut indexes: Vec<(u64, u16)> =
        chunk.message_index_offsets.iter().map(|(channel, at)| (*at, *channel)).collect();
    indexes.sort_unstable();
    if indexes.first()?.0 != begin {
        return None;
    }
    let ends = indexes.iter().skip(1).map(|(at, _)| *at).chain([end]);
    let count = |((at, channel), end): (&(u64, u16), u64)| {
        let entries = end.checked_sub(*at)?.checked_sub(scan::MESSAGE_INDEX_HEAD_BYTES as u64)?;
        (entries % scan::ENTRY_BYTES == 0).then_some((*channel, entries / scan::ENTRY_BYTES))
    };
    indexes.iter().zip(ends).map(count).collect()
}
