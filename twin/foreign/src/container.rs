//! Reads the records of an MCAP file (or of a ULog file, see `ulog`) in file order, also when the file is damaged.
//!
//! In: bytes. Out: schemas, channels and messages through a callback, then [`Findings`], which describe the damage in words. The
//! reader skips a whole chunk if its checksum is wrong, so damage never yields a wrong value. If the file ends inside a chunk,
//! the reader uses the whole records before the end. Memory holds one chunk at a time.

use std::io::Read;

pub use super::findings::{ContainerError, Findings};
use mcap::records::Record;
use twin_input::Inflation;
use twin_record::pieces::{CHUNK, DATA_END, FOOTER, HEAD_BYTES, Next, next, unpack};

/// Reads `input` to its end, or to the first byte where the file is broken. `on` receives every schema, channel, message and
/// metadata record.
///
/// # Errors
/// [`ContainerError`] if the system refuses, or the file is no MCAP file. Later damage becomes a problem in the findings.
pub fn read(
    input: &mut impl Read,
    on: &mut dyn FnMut(Record<'_>),
) -> Result<Findings, ContainerError> {
    let mut magic = Vec::new();
    input.take(mcap::MAGIC.len() as u64).read_to_end(&mut magic)?;
    if let Some(rest) = magic.strip_prefix(&super::ulog::MAGIC) {
        return super::ulog::read(&mut rest.chain(input), on);
    }
    if magic != mcap::MAGIC {
        return Err(ContainerError::NotMcap { found: magic.escape_ascii().to_string() });
    }
    let mut findings = Findings::default();
    let mut record = Vec::new();
    let mut offset = mcap::MAGIC.len() as u64;
    let mut inflation = Inflation::default();
    loop {
        let next = next(input, &mut record)?;
        if let Some(damage) = next.damage(offset) {
            findings.problem(damage);
            return Ok(findings);
        }
        if next != Next::Record {
            cut_off((&record, offset), &mut findings, &mut inflation, on);
            return Ok(findings);
        }
        if !take((&record, offset), &mut findings, &mut inflation, on) {
            if record[0] == DATA_END {
                unused(input, &mut record, on);
            }
            return Ok(findings);
        }
        offset += record.len() as u64;
    }
}

/// Handles one record of the file; returns false after the end of the data section.
fn take(
    (record, offset): (&[u8], u64),
    findings: &mut Findings,
    inflation: &mut Inflation,
    on: &mut dyn FnMut(Record<'_>),
) -> bool {
    let (opcode, body) = (record[0], &record[HEAD_BYTES..]);
    match opcode {
        // The summary section follows: an index of the records above, and the definitions of channels without a message.
        DATA_END | FOOTER => {
            findings.complete = true;
            false
        }
        CHUNK => {
            chunk((record, offset), findings, inflation, on);
            true
        }
        _ => {
            match mcap::parse_record(opcode, body) {
                Ok(Record::Header(header)) => {
                    findings.profile = header.profile;
                    findings.library = header.library;
                }
                Ok(record) => on(record),
                Err(error) => {
                    findings.problem(format!("record at byte {offset} is not readable: {error}"));
                }
            }
            true
        }
    }
}

/// Reads schemas and channels of the summary section. Channels without a message are defined nowhere else. Damage ends the
/// reading here and loses no measurement.
fn unused(input: &mut impl Read, record: &mut Vec<u8>, on: &mut dyn FnMut(Record<'_>)) {
    while let Ok(Next::Record) = next(input, record) {
        match mcap::parse_record(record[0], &record[HEAD_BYTES..]) {
            Ok(Record::Footer(_)) | Err(_) => return,
            Ok(defined @ (Record::Schema { .. } | Record::Channel(_))) => on(defined),
            Ok(_) => {}
        }
    }
}

/// Passes on all records of a whole chunk, or none of them if the chunk is damaged.
fn chunk(
    (record, offset): (&[u8], u64),
    findings: &mut Findings,
    inflation: &mut Inflation,
    on: &mut dyn FnMut(Record<'_>),
) {
    if let Ok(Record::Chunk { header, .. }) = mcap::parse_record(CHUNK, &record[HEAD_BYTES..]) {
        let name = if header.compression.is_empty() { "none".into() } else { header.compression };
        findings.compressions.insert(name);
    }
    let mut seen = 0_u64;
    let end = unpack(record, true, inflation, &mut |record| {
        seen += 1;
        on(record);
    });
    match end {
        Ok(()) => findings.chunks += 1,
        Err(why) => {
            findings.chunks_lost += 1;
            findings.problem(format!(
                "chunk at byte {offset} is damaged or unknown ({why}): {seen} of its records could be used"
            ));
        }
    }
}

/// Reads the incomplete last record of a file that ends too early.
fn cut_off(
    (rest, offset): (&[u8], u64),
    findings: &mut Findings,
    inflation: &mut Inflation,
    on: &mut dyn FnMut(Record<'_>),
) {
    let mut seen = 0_u64;
    if rest.first() == Some(&CHUNK) && rest.len() > HEAD_BYTES {
        // The error is the early end, which the problem below reports.
        let _ = unpack(rest, false, inflation, &mut |record| {
            seen += 1;
            on(record);
        });
    }
    findings.problem(format!(
        "the file ends at byte {} without an end of its data: the recorder was stopped or the copy is not whole; {seen} records of the last piece could be used",
        offset + rest.len() as u64
    ));
}
