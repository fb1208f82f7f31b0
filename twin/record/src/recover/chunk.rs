//! The records inside of a chunk.

use super::head::{ChunkSizes, HEAD_BYTES, Head, LONGEST_RECORD_BYTES};
use super::report::Trouble;
use super::source::Source;
use mcap::records::op;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use twin_input::interruption;

/// Why the reading of a chunk stopped early.
pub(super) enum Stop {
    /// Nothing more can be read or written.
    Now(Trouble),
    /// The chunk is damaged; the reason.
    Damage(String),
}

impl<E: Into<Trouble>> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Now(error.into())
    }
}

/// Receives opcode and body of each record of a chunk.
pub(super) type OnRecord<'a> = &'a mut dyn FnMut(u8, &[u8]) -> Result<(), Trouble>;

/// Passes on the records of the whole chunk at `at`, after its checksum was found right.
pub(super) fn checked(
    source: &mut Source,
    at: u64,
    sizes: &ChunkSizes,
    on: OnRecord<'_>,
) -> Result<(), Stop> {
    let options = options().with_prevalidate_chunk_crcs(true);
    // An uncompressed record that claims more than its chunk must not be followed beyond it.
    if sizes.compression.is_empty() && sizes.compressed != sizes.uncompressed {
        return Err(Stop::Damage("its sizes do not agree".to_owned()));
    }
    let length = sizes.data + sizes.compressed - at;
    read(LinearReader::new_with_options(options), source, &[], (at, length), on)
}

/// As [`checked`], with the `head` and header of the chunk as they must have been.
pub(super) fn mended(
    source: &mut Source,
    head: &[u8],
    sizes: &ChunkSizes,
    on: OnRecord<'_>,
) -> Result<(), Stop> {
    let options = options().with_prevalidate_chunk_crcs(true);
    let data = (sizes.data, sizes.compressed);
    read(LinearReader::new_with_options(options), source, head, data, on)
}

/// Passes on the records of a compressed chunk whose data end at `end`, as far as they decompress, whatever their checksum.
pub(super) fn unchecked(
    source: &mut Source,
    sizes: &ChunkSizes,
    end: u64,
    on: OnRecord<'_>,
) -> Result<(), Stop> {
    let compressed = end - sizes.data;
    let name = sizes.compression.as_bytes();
    let mut head = vec![op::CHUNK];
    let header = 8 + 8 + 8 + 4 + 4 + name.len() as u64 + 8;
    head.extend((header + compressed).to_le_bytes());
    head.extend([0; 16]);
    // The size of the records is unknown, or may be damaged: this is the most that is read. A checksum of zero is none.
    head.extend(LONGEST_RECORD_BYTES.to_le_bytes());
    head.extend([0; 4]);
    head.extend((name.len() as u32).to_le_bytes());
    head.extend(name);
    head.extend(compressed.to_le_bytes());
    read(LinearReader::new_with_options(options()), source, &head, (sizes.data, compressed), on)
}

fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_record_length_limit(LONGEST_RECORD_BYTES as usize)
}

/// Feeds `first`, then `length` bytes of the file from `at` on, to the reader.
fn read(
    mut reader: LinearReader,
    source: &mut Source,
    mut first: &[u8],
    (mut at, mut length): (u64, u64),
    on: OnRecord<'_>,
) -> Result<(), Stop> {
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| Stop::Damage(error.to_string()))? {
            LinearReadEvent::ReadRequest(wanted) if !first.is_empty() => {
                let (part, rest) = first.split_at(wanted.min(first.len()));
                reader.insert(part.len()).copy_from_slice(part);
                reader.notify_read(part.len());
                first = rest;
            }
            LinearReadEvent::ReadRequest(wanted) => {
                interruption::check()?;
                let part = source.bytes(at, (wanted as u64).min(length).min(PART_BYTES))?;
                reader.insert(part.len()).copy_from_slice(part);
                reader.notify_read(part.len());
                (at, length) = (at + part.len() as u64, length - part.len() as u64);
            }
            // A hole of the file decompresses to zeros; no record has this opcode.
            LinearReadEvent::Record { opcode: 0, .. } => {
                return Err(Stop::Damage("a record in it has the opcode 0".to_owned()));
            }
            LinearReadEvent::Record { opcode, data } => on(opcode, data)?,
        }
    }
    Ok(())
}

/// Most bytes that are handed to the reader at a time.
const PART_BYTES: u64 = 1 << 16;

/// Passes on the whole records between `at` and `end`, which are not compressed; returns the offset behind the last of them.
pub(super) fn plain(
    source: &mut Source,
    mut at: u64,
    end: u64,
    on: OnRecord<'_>,
) -> Result<u64, Trouble> {
    loop {
        interruption::check()?;
        let head = Head::at(source, at)?;
        let fits = |head: &Head| {
            head.is_known() && head.end(at) <= end && head.length <= LONGEST_RECORD_BYTES
        };
        let Some(head) = head.filter(fits) else { return Ok(at) };
        on(head.opcode, &source.read(at + HEAD_BYTES, head.length)?)?;
        at = head.end(at);
    }
}
