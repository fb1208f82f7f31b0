//! The pieces of an MCAP file: whole records in file order, and the records inside a chunk, both within the budget for untrusted input.
//!
//! In: bytes that may be damaged or made to exhaust the machine. Out: one record at a time. Memory holds one record or one chunk.

use std::io::{ErrorKind, Read};

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use twin_input::Inflation;
use twin_input::budget::RECORD_BYTES;

/// Opcodes that readers of files handle themselves: footer, chunk, end of the data section.
pub const FOOTER: u8 = 0x02;
/// See [`FOOTER`].
pub const CHUNK: u8 = 0x06;
/// See [`FOOTER`].
pub const DATA_END: u8 = 0x0F;

/// The opcode that no record has. It is the content of a hole in a file, and of a piece that was never written.
pub const NO_RECORD: u8 = 0x00;

/// Bytes of opcode and length, which precede every record.
pub const HEAD_BYTES: usize = 9;

/// A size that a recorder writes when it opens a chunk, and replaces when it closes the chunk.
pub const OPEN: u64 = u64::MAX;

/// Bytes of a chunk record before the name of its compression: times, size and checksum.
const CHUNK_HEAD_BYTES: usize = 8 + 8 + 8 + 4;

/// The next piece of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// One whole record with its head.
    Record,
    /// A record that claims more bytes than any recorder writes; its claimed length.
    TooLong(u64),
    /// The opcode that no record has: the file is damaged from here on.
    NoRecord,
    /// The file ends here. The buffer contains the incomplete last record, if any.
    End,
}

impl Next {
    /// The damage at byte `offset`, in words; `None` for a record and for the end.
    pub fn damage(self, offset: u64) -> Option<String> {
        match self {
            Self::TooLong(length) => Some(format!(
                "record at byte {offset} claims {length} bytes, at most {} are read: the file is damaged from there on",
                RECORD_BYTES.most
            )),
            Self::NoRecord => Some(format!(
                "there is no record at byte {offset}, but opcode 0, which no recorder writes: the file is damaged from there on"
            )),
            Self::Record | Self::End => None,
        }
    }
}

/// Reads the next record with its head into `record`.
///
/// # Errors
/// The system's error.
pub fn next(input: &mut impl Read, record: &mut Vec<u8>) -> std::io::Result<Next> {
    record.clear();
    fill(input, HEAD_BYTES as u64, record)?;
    let Some(length) = record.get(1..HEAD_BYTES).and_then(|bytes| bytes.try_into().ok()) else {
        return Ok(Next::End);
    };
    if record[0] == NO_RECORD {
        return Ok(Next::NoRecord);
    }
    let length = u64::from_le_bytes(length);
    if length > RECORD_BYTES.most {
        return Ok(Next::TooLong(length));
    }
    let whole = fill(input, length, record)?;
    Ok(if whole { Next::Record } else { Next::End })
}

/// Appends `length` bytes of the input to the buffer; returns false if the input ends before that.
///
/// # Errors
/// The system's error.
pub fn fill(input: &mut impl Read, length: u64, record: &mut Vec<u8>) -> std::io::Result<bool> {
    match input.take(length).read_to_end(record) {
        Ok(read) => Ok(read as u64 == length),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

/// Why the records inside a chunk cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ChunkError {
    /// The bytes do not have the form of a chunk, or its checksum is wrong.
    #[error("{0}")]
    Damaged(#[from] mcap::McapError),
    /// The chunk would become larger than the budget allows.
    #[error("{0}")]
    TooInflated(#[from] twin_input::TooInflated),
    /// A record inside has an opcode that no record has.
    #[error("a record inside has opcode 0, which no recorder writes")]
    NoRecord,
}

/// Passes on the records inside the chunk record `bytes`, which starts with its head. With `checked` the checksum is compared before
/// `on` sees the first record. `inflation` counts what the chunks of one input become.
///
/// # Errors
/// [`ChunkError`]; `on` may have received the records before the damage, unless the checksum was compared.
pub fn unpack(
    mut bytes: &[u8],
    checked: bool,
    inflation: &mut Inflation,
    on: &mut dyn FnMut(Record<'_>),
) -> Result<(), ChunkError> {
    if let Some((packed, claimed)) = compressed(bytes.get(HEAD_BYTES..).unwrap_or_default()) {
        inflation.add(packed, claimed)?;
    }
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(checked)
        .with_record_length_limit(RECORD_BYTES.count());
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (part, rest) = bytes.split_at(wanted.min(bytes.len()));
                reader.insert(part.len()).copy_from_slice(part);
                reader.notify_read(part.len());
                bytes = rest;
            }
            LinearReadEvent::Record { opcode: NO_RECORD, .. } => return Err(ChunkError::NoRecord),
            LinearReadEvent::Record { opcode, data } => on(mcap::parse_record(opcode, data)?),
        }
    }
    Ok(())
}

/// Compressed bytes that are there, and unpacked bytes that a chunk claims; `None` for a chunk without compression, whose records
/// cannot be longer than itself.
fn compressed(body: &[u8]) -> Option<(u64, u64)> {
    let long = |at: usize| body.get(at..)?.first_chunk().map(|bytes| u64::from_le_bytes(*bytes));
    let name = body.get(CHUNK_HEAD_BYTES..)?.first_chunk().map(|b| u32::from_le_bytes(*b))?;
    let head = (CHUNK_HEAD_BYTES + 4 + 8) as u64 + u64::from(name);
    let packed = (body.len() as u64).saturating_sub(head);
    (name > 0).then_some((packed, long(16)?))
}

#[cfg(test)]
#[path = "pieces_tests.rs"]
mod tests;
