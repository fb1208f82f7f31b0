//! What the first bytes of a record say, and whether that can be true. The search for the next readable record rests on it.

use super::source::Source;
use crate::pieces::{self, OPEN};
use mcap::records::op;
use twin_input::budget::RECORD_BYTES;

/// Bytes of opcode and length, which precede every record.
pub(super) const HEAD_BYTES: u64 = pieces::HEAD_BYTES as u64;

/// Longest record and chunk that is read; recorders write a few MiB.
pub(super) const LONGEST_RECORD_BYTES: u64 = RECORD_BYTES.most;

/// Bytes of a chunk's header before the name of its compression.
const CHUNK_HEADER_BYTES: u64 = 32;

/// Fewest bytes of a message: channel, sequence and two times.
const LEAST_MESSAGE_BYTES: u64 = 22;

/// Compressions that a chunk may name.
const COMPRESSIONS: [&str; 3] = ["", "zstd", "lz4"];

/// Opcode and length of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Head {
    /// Opcode.
    pub opcode: u8,
    /// Bytes after the head.
    pub length: u64,
}

impl Head {
    /// The head at `at`; `None` at the end of the file.
    pub(super) fn at(source: &mut Source, at: u64) -> std::io::Result<Option<Self>> {
        let bytes = source.bytes(at, HEAD_BYTES)?;
        let length = bytes.get(1..HEAD_BYTES as usize).and_then(|bytes| bytes.try_into().ok());
        let (Some(opcode), Some(length)) = (bytes.first(), length) else { return Ok(None) };
        Ok(Some(Self { opcode: *opcode, length: u64::from_le_bytes(length) }))
    }

    /// The offset after a record at `at`.
    pub(super) fn end(self, at: u64) -> u64 {
        at.saturating_add(HEAD_BYTES).saturating_add(self.length)
    }

    /// Whether MCAP defines this opcode. Zero is never one: it is what a hole of a file reads as.
    pub(super) fn is_known(self) -> bool {
        (op::HEADER..=op::DATA_END).contains(&self.opcode)
    }
}

/// The header of a chunk, as far as its sizes go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ChunkSizes {
    /// Log times of the first and the last message, ns.
    pub times_ns: (u64, u64),
    /// Bytes of the records.
    pub uncompressed: u64,
    /// Checksum of the records; 0 if the recorder made none.
    pub checksum: u32,
    /// Name of the compression.
    pub compression: String,
    /// Bytes of the compressed records.
    pub compressed: u64,
    /// Offset of the compressed records in the file.
    pub data: u64,
}

impl ChunkSizes {
    /// The header of the chunk whose record begins at `at`; `None` if it cannot be one.
    pub(super) fn at(source: &mut Source, at: u64) -> std::io::Result<Option<Self>> {
        let start = at + HEAD_BYTES;
        // The longest name has four letters.
        let bytes = source.bytes(start, CHUNK_HEADER_BYTES + 12)?.to_vec();
        Ok(Self::parse(&bytes, start))
    }

    fn parse(bytes: &[u8], start: u64) -> Option<Self> {
        let number = |at: usize| Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?));
        let letters = u32::from_le_bytes(bytes.get(28..32)?.try_into().ok()?);
        let end =
            CHUNK_HEADER_BYTES as usize + usize::try_from(letters).ok().filter(|n| *n <= 4)?;
        let name = std::str::from_utf8(bytes.get(32..end)?).ok()?;
        COMPRESSIONS.contains(&name).then_some(())?;
        Some(Self {
            times_ns: (number(0)?, number(8)?),
            uncompressed: number(16)?,
            checksum: u32::from_le_bytes(bytes.get(24..28)?.try_into().ok()?),
            compression: name.to_owned(),
            compressed: number(end)?,
            data: start + end as u64 + 8,
        })
    }

    /// Whether the recorder was still writing the chunk.
    pub(super) fn is_open(&self, head: Head) -> bool {
        head.length == OPEN && self.compressed == OPEN
    }

    /// Whether the length of the record agrees with the size of the compressed records.
    pub(super) fn agrees(&self, head: Head, at: u64) -> bool {
        self.data.checked_add(self.compressed) == Some(head.end(at))
    }
}

/// Whether a record that can be told from other bytes begins at `at`. `message` says whether a channel is known, or `None` if no
/// message stands outside of a chunk.
pub(super) fn is_record(
    source: &mut Source,
    at: u64,
    is_channel: &dyn Fn(u16) -> bool,
) -> std::io::Result<bool> {
    let Some(head) = Head::at(source, at)?.filter(|head| head.is_known()) else {
        return Ok(false);
    };
    if head.opcode == op::CHUNK {
        let sizes = ChunkSizes::at(source, at)?;
        return Ok(sizes.is_some_and(|sizes| sizes.is_open(head) || sizes.agrees(head, at)));
    }
    if head.end(at) > source.length() || !is_followed(source, head.end(at))? {
        return Ok(false);
    }
    let body = at + HEAD_BYTES;
    Ok(match head.opcode {
        op::MESSAGE => {
            let channel = source.bytes(body, 2)?.try_into().map_or(0, u16::from_le_bytes);
            head.length >= LEAST_MESSAGE_BYTES && is_channel(channel)
        }
        op::ATTACHMENT => attachment_agrees(source, body, head.length)?,
        _ if head.length > 1 << 20 => false,
        _ => mcap::parse_record(head.opcode, &source.read(body, head.length)?).is_ok(),
    })
}

/// Whether a record, or the end of the file, may begin at `at`.
pub(super) fn is_followed(source: &mut Source, at: u64) -> std::io::Result<bool> {
    let left = source.length().saturating_sub(at);
    if left == 0 || (left == mcap::MAGIC.len() as u64 && source.read(at, left)? == mcap::MAGIC) {
        return Ok(true);
    }
    // Past the window: the search goes on where it was.
    let bytes = source.read(at, HEAD_BYTES)?;
    let length = bytes.get(1..).and_then(|bytes| bytes.try_into().ok()).map(u64::from_le_bytes);
    let head = bytes.first().zip(length).map(|(&opcode, length)| Head { opcode, length });
    Ok(head.is_some_and(|head| {
        let open = head.opcode == op::CHUNK && head.length == OPEN;
        head.is_known() && (open || head.end(at) <= source.length())
    }))
}

/// Whether the lengths inside of an attachment add up to the `length` of its record.
fn attachment_agrees(source: &mut Source, body: u64, length: u64) -> std::io::Result<bool> {
    let mut at = body + 16;
    for _ in 0..2 {
        let Ok(text) = source.read(at, 4)?.try_into().map(u32::from_le_bytes) else {
            return Ok(false);
        };
        at += 4 + u64::from(text);
    }
    let data = source.read(at, 8)?.try_into().map(u64::from_le_bytes);
    Ok(data.is_ok_and(|data| (at + 8 + 4).checked_add(data) == body.checked_add(length)))
}
