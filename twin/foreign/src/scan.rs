//! Finds the chunks of an MCAP file without a summary by stepping from record to record.

use std::collections::BTreeMap;
use std::io::{BufReader, Read, SeekFrom};

use mcap::records::Record;

use super::container::Findings;
use super::table::{ChunkEntry, Input, Table, header as message, read_at, unpack_record};
use twin_input::Inflation;
use twin_input::budget::{ATTACHED_BYTES, RECORD_BYTES};
use twin_record::pieces::{CHUNK, DATA_END, FOOTER, HEAD_BYTES, NO_RECORD, Next};

/// Opcodes that the scan distinguishes.
const HEADER: u8 = 0x01;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const MESSAGE_INDEX: u8 = 0x07;
const METADATA: u8 = 0x0C;

/// Bytes of a message index before its entries: record head, channel, length of the entries.
pub(super) const MESSAGE_INDEX_HEAD_BYTES: usize = HEAD_BYTES + 2 + 4;

/// Bytes of one entry: log time and offset.
pub(super) const ENTRY_BYTES: u64 = 16;

/// Bytes of a chunk before the name of its compression: times, size and checksum.
const CHUNK_HEAD_BYTES: u64 = 8 + 8 + 8 + 4;

/// Channel of a message index and its number of messages, from its first bytes.
pub(super) fn message_index(head: &[u8]) -> Option<(u16, u64)> {
    let channel = u16::from_le_bytes(head.get(HEAD_BYTES..)?.first_chunk().copied()?);
    let length = u32::from_le_bytes(head.get(HEAD_BYTES + 2..)?.first_chunk().copied()?);
    (head.first() == Some(&MESSAGE_INDEX)).then(|| (channel, u64::from(length) / ENTRY_BYTES))
}

/// Reads profile and program from the header record.
pub(super) fn header(file: &mut dyn Input, findings: &mut Findings) -> std::io::Result<()> {
    let at = mcap::MAGIC.len() as u64;
    let head = read_at(file, at, HEAD_BYTES as u64)?;
    let length = head[1..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
    if head[0] == HEADER && length < RECORD_BYTES.most {
        let body = read_at(file, at + HEAD_BYTES as u64, length)?;
        if let Ok(Record::Header(header)) = mcap::parse_record(HEADER, &body) {
            (findings.profile, findings.library) = (header.profile, header.library);
        }
    }
    Ok(())
}

/// Position and results of the walk over the records.
struct Walk<'a> {
    file: BufReader<&'a mut dyn Input>,
    at: u64,
    length: u64,
    table: Table,
    /// True if messages lie outside of chunks; the file must then be read whole.
    loose: bool,
    /// Bytes of the metadata records so far.
    metadata_bytes: u64,
}

/// The table of a file of `length` bytes; `None` if messages lie outside of chunks or there is no chunk.
pub(super) fn scan(file: &mut dyn Input, length: u64) -> std::io::Result<Option<Table>> {
    let at = mcap::MAGIC.len() as u64;
    file.seek(SeekFrom::Start(at))?;
    let mut walk = Walk {
        file: BufReader::new(&mut *file),
        at,
        length,
        table: Table::default(),
        loose: false,
        metadata_bytes: 0,
    };
    while walk.step()? {}
    let Walk { mut table, loose, .. } = walk;
    if loose || table.chunks.is_empty() {
        return Ok(None);
    }
    header(file, &mut table.findings)?;
    look_into(file, &mut table);
    let each = table.chunks.iter().flat_map(|place| &place.counts);
    let mut counts = BTreeMap::new();
    each.for_each(|(channel, count)| *counts.entry(*channel).or_insert(0) += count);
    table.counts = counts;
    table.findings.chunks = table.chunks.len() as u64;
    if !table.findings.complete {
        table.findings.problem(format!(
            "the file ends at byte {length} without an end of its data: the recorder was stopped or the copy is not whole"
        ));
    }
    Ok(Some(table))
}

impl Walk<'_> {
    /// Handles one record; returns false at the end.
    fn step(&mut self) -> std::io::Result<bool> {
        let left = self.length.saturating_sub(self.at);
        let mut head = [0; HEAD_BYTES];
        if left < HEAD_BYTES as u64 {
            return Ok(false);
        }
        self.file.read_exact(&mut head)?;
        let body = head[1..].first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        let damage = match head[0] {
            NO_RECORD => Next::NoRecord.damage(self.at),
            _ if body > RECORD_BYTES.most => Next::TooLong(body).damage(self.at),
            _ => None,
        };
        if let Some(damage) = damage {
            self.table.findings.problem(damage);
            return Ok(false);
        }
        let whole = left - HEAD_BYTES as u64 >= body;
        let read = match head[0] {
            CHUNK => self.chunk(body, whole)?,
            MESSAGE => {
                self.loose = true;
                return Ok(false);
            }
            DATA_END | FOOTER => {
                self.table.findings.complete = true;
                return Ok(false);
            }
            _ if !whole => 0,
            MESSAGE_INDEX => self.message_index(&head, body)?,
            SCHEMA | CHANNEL | METADATA => self.record(head[0], body)?,
            _ => 0,
        };
        self.at += HEAD_BYTES as u64 + body;
        self.file.seek_relative((body - read).cast_signed())?;
        Ok(whole)
    }

    /// Reads the first bytes of a chunk; returns how many it read.
    fn chunk(&mut self, body: u64, whole: bool) -> std::io::Result<u64> {
        let mut head = Vec::new();
        // The name of a compression is one short word.
        let wanted = (CHUNK_HEAD_BYTES + 4 + 16).min(body);
        self.file.by_ref().take(wanted).read_to_end(&mut head)?;
        let long = |at: usize| {
            head.get(at..).and_then(<[u8]>::first_chunk).map(|bytes| u64::from_le_bytes(*bytes))
        };
        let span_ns = long(0).zip(long(8)).filter(|(first, last)| first <= last && *last > 0);
        let name = head.get(CHUNK_HEAD_BYTES as usize..).and_then(|rest| {
            let length = u32::from_le_bytes(*rest.first_chunk()?) as usize;
            std::str::from_utf8(rest.get(4..4 + length)?).ok()
        });
        let name = name.map_or("unknown", |name| if name.is_empty() { "none" } else { name });
        self.table.findings.compressions.insert(name.to_owned());
        let length = if whole { HEAD_BYTES as u64 + body } else { self.length - self.at };
        self.table.chunks.push(ChunkEntry {
            at: self.at,
            length,
            span_ns,
            cut: !whole,
            ..ChunkEntry::default()
        });
        Ok(head.len() as u64)
    }

    fn message_index(&mut self, head: &[u8], body: u64) -> std::io::Result<u64> {
        let mut bytes = head.to_vec();
        let wanted = ((MESSAGE_INDEX_HEAD_BYTES - HEAD_BYTES) as u64).min(body);
        let read = self.file.by_ref().take(wanted).read_to_end(&mut bytes)? as u64;
        if let (Some((channel, count)), Some(place)) =
            (message_index(&bytes), self.table.chunks.last_mut())
        {
            place.counts.insert(channel, count);
        }
        Ok(read)
    }

    fn record(&mut self, opcode: u8, body: u64) -> std::io::Result<u64> {
        let mut bytes = Vec::new();
        let read = self.file.by_ref().take(body).read_to_end(&mut bytes)? as u64;
        match mcap::parse_record(opcode, &bytes) {
            Ok(Record::Metadata(metadata)) => {
                self.metadata_bytes += body;
                match ATTACHED_BYTES.check(self.metadata_bytes) {
                    Ok(()) => self.table.metadata.push(metadata),
                    Err(excess) => self.table.findings.problem(format!("metadata: {excess}")),
                }
            }
            Ok(record) => self.table.definitions.take(record),
            Err(error) => self
                .table
                .findings
                .problem(format!("record at byte {} is not readable: {error}", self.at)),
        }
        Ok(read)
    }
}

/// Unpacks the chunks that contain what no other place contains: the first chunk, chunks with messages of a channel that is not
/// yet known (its definition is in that chunk), chunks without a message index, and a chunk that the end of the file cuts off.
fn look_into(file: &mut dyn Input, table: &mut Table) {
    let mut inflation = Inflation::default();
    for number in 0..table.chunks.len() {
        let place = &table.chunks[number];
        let uncounted = place.counts.is_empty() || place.cut;
        let known = |channel: &u16| table.definitions.channels.contains_key(channel);
        if number > 0 && !uncounted && place.counts.keys().all(known) {
            continue;
        }
        let Ok(record) = read_at(file, place.at, place.length) else { continue };
        let mut counts: BTreeMap<u16, u64> = BTreeMap::new();
        let mut span_ns: Option<(u64, u64)> = None;
        let definitions = &mut table.definitions;
        let end = unpack_record(&record, place, &mut inflation, &mut |record| {
            if let Some(header) = message(&record) {
                *counts.entry(header.channel_id).or_default() += 1;
                let (first, last) = span_ns.unwrap_or((u64::MAX, 0));
                span_ns = Some((first.min(header.log_time), last.max(header.log_time)));
            }
            definitions.take(record);
        });
        if let Err(why) = end {
            table.findings.chunks_lost += 1;
            table.findings.problem(why);
        }
        if uncounted {
            let place = &mut table.chunks[number];
            (place.counts, place.span_ns) = (counts, span_ns);
        }
    }
}
