//! Goes through a damaged file record by record. Behind damage it goes on at the next record that can be told from other bytes.

use std::io::{Seek, Write};

use super::chunk::{self, Stop};
use super::head::{self, ChunkSizes, HEAD_BYTES, Head, LONGEST_RECORD_BYTES};
use super::report::Trouble;
use super::salvage::Salvage;
use super::source::Source;
use mcap::records::{Record, op};
use twin_input::interruption;

/// Bytes that are searched at a time.
const SEARCH_BYTES: u64 = 1 << 16;

/// Bytes of a footer with its head, and of the magic behind it.
const FOOTER_BYTES: u64 = HEAD_BYTES + 20;
const MAGIC_BYTES: u64 = mcap::MAGIC.len() as u64;

/// The damaged file, the new file, and how far the one is in the other.
pub(super) struct Walk<W: Write + Seek> {
    source: Source,
    out: Salvage<W>,
    /// Whether messages are kept whose chunk has a wrong checksum.
    unverified: bool,
    /// Whether messages stand in chunks; other bytes are then never taken for a message.
    has_chunks: bool,
    /// Whether the indexes that follow belong to a chunk whose messages are lost.
    counts_lost: bool,
    /// The last search: where it began and what it found.
    searched: Option<(u64, Option<u64>)>,
}

/// The header of the file: its profile and the library that wrote it; empty if it cannot be read.
pub(super) fn header(source: &mut Source) -> std::io::Result<(String, String)> {
    let head = Head::at(source, MAGIC_BYTES)?;
    if let Some(head) = head.filter(|head| head.opcode == op::HEADER && head.length < SEARCH_BYTES)
    {
        let body = source.read(MAGIC_BYTES + HEAD_BYTES, head.length)?;
        if let Ok(Record::Header(header)) = mcap::parse_record(op::HEADER, &body) {
            return Ok((header.profile, header.library));
        }
    }
    Ok(Default::default())
}

impl<W: Write + Seek> Walk<W> {
    pub(super) fn new(source: Source, out: Salvage<W>, unverified: bool) -> Self {
        let (has_chunks, counts_lost) = (false, false);
        Self { source, out, unverified, has_chunks, counts_lost, searched: None }
    }

    /// Goes through the whole file and returns the new file, which is to be finished.
    pub(super) fn run(mut self) -> Result<Salvage<W>, Trouble> {
        self.out.report.bytes = self.source.length();
        let expected = self.summary()?;
        let mut at = MAGIC_BYTES;
        if self.source.bytes(0, MAGIC_BYTES)? != mcap::MAGIC {
            at = self.skip(0, "the file does not begin as an MCAP file")?;
        }
        while at < self.source.length() {
            interruption::check()?;
            if self.source.length() - at == MAGIC_BYTES
                && self.source.bytes(at, MAGIC_BYTES)? == mcap::MAGIC
            {
                break;
            }
            at = self.step(at)?;
        }
        let report = &mut self.out.report;
        if let Some(expected) = expected {
            report.lost_messages = expected.saturating_sub(report.messages);
            report.lost_more = false;
            if report.lost_messages > 0 && report.damaged_places == 0 {
                report.lose(
                    0,
                    0,
                    "messages that the statistics of the recording count are not there",
                );
            }
        }
        report.lost_more |= !report.finished && expected.is_none();
        Ok(self.out)
    }

    /// Reads the definitions of the summary, because those of the data may be damaged; returns how many messages it counts.
    fn summary(&mut self) -> Result<Option<u64>, Trouble> {
        let Some(at) = self.source.length().checked_sub(FOOTER_BYTES + MAGIC_BYTES) else {
            return Ok(None);
        };
        let end = self.source.read(at, FOOTER_BYTES + MAGIC_BYTES)?;
        let (footer, magic) = end.split_at(FOOTER_BYTES as usize);
        if magic != mcap::MAGIC || footer[0] != op::FOOTER {
            return Ok(None);
        }
        let Ok(Record::Footer(footer)) =
            mcap::parse_record(op::FOOTER, &footer[HEAD_BYTES as usize..])
        else {
            return Ok(None);
        };
        self.out.report.finished = true;
        if footer.summary_start == 0 || footer.summary_start >= at {
            return Ok(None);
        }
        let (mut expected, known) = (None, &mut self.out.known);
        chunk::plain(&mut self.source, footer.summary_start, at, &mut |opcode, body| {
            if let Ok(record) = mcap::parse_record(opcode, body)
                && !known.add(&record, false)
                && let Record::Statistics(statistics) = record
            {
                expected = Some(statistics.message_count);
            }
            Ok(())
        })?;
        Ok(expected)
    }

    /// Takes what begins at `at` and returns where to go on.
    fn step(&mut self, at: u64) -> Result<u64, Trouble> {
        let Some(head) = Head::at(&mut self.source, at)? else {
            return self.skip(at, "the file ends inside of a record");
        };
        if head.opcode == op::CHUNK {
            return self.chunk(at, head);
        }
        let end = head.end(at);
        let whole =
            head.opcode != 0 && end <= self.source.length() && head.length <= LONGEST_RECORD_BYTES;
        if !whole {
            return self.skip(at, "a record cannot be told from other bytes here");
        }
        // A damaged length may swallow good records: then one begins before the end that it claims.
        let hides = |found: Option<u64>| found.is_some_and(|found| found < end);
        if !head::is_followed(&mut self.source, end)? && hides(self.search(at + 1)?) {
            return self.skip(at, "the length of a record is damaged");
        }
        self.record(at, head)?;
        Ok(end)
    }

    fn record(&mut self, at: u64, head: Head) -> Result<(), Trouble> {
        let body = self.source.read(at + HEAD_BYTES, head.length)?;
        let trouble = match mcap::parse_record(head.opcode, &body) {
            // Its entries have 16 bytes each; the reader does not look at what stands behind them.
            Ok(Record::MessageIndex(index)) if body.len() == 6 + 16 * index.records.len() => {
                let lost = if self.counts_lost { index.records.len() } else { 0 };
                self.out.report.lost_messages += lost as u64;
                return Ok(());
            }
            Ok(Record::MessageIndex(_)) => "its opcode or its length is damaged".to_owned(),
            // Recorders do not mix the two, but a damaged opcode makes a message of another record.
            Ok(Record::Message { .. }) if self.has_chunks => {
                "a message outside of chunks, in a file with chunks".to_owned()
            }
            Ok(Record::Unknown { opcode, .. }) => {
                format!("its opcode {opcode:#04x} is private or damaged, so it was left out")
            }
            Ok(record) => return Ok(self.out.take(record, true)?),
            Err(error) => error.to_string(),
        };
        self.out.report.lose(at, HEAD_BYTES + head.length, format!("a record: {trouble}"));
        Ok(())
    }

    fn chunk(&mut self, at: u64, head: Head) -> Result<u64, Trouble> {
        let length = self.source.length();
        let sizes = ChunkSizes::at(&mut self.source, at)?;
        let Some(sizes) = sizes.filter(|sizes| sizes.data <= length) else {
            return self.skip(at, "the header of a chunk is damaged or cut off");
        };
        self.has_chunks = true;
        self.counts_lost = false;
        let agrees = sizes.agrees(head, at);
        if sizes.is_open(head) || (agrees && head.end(at) > length) {
            return self.unfinished(at, &sizes);
        }
        if agrees {
            let (end, before) = (head.end(at), self.out.report.messages);
            if let Err(why) = self.whole(at, &sizes)? {
                self.damaged((at, end), &sizes, &why, before)?;
            }
            return Ok(end);
        }
        // One of the two sizes is damaged; the checksum tells which.
        for end in [head.end(at), sizes.data.saturating_add(sizes.compressed)] {
            let fits = end > sizes.data && end <= length;
            let compressed = end.saturating_sub(sizes.data);
            let tried = ChunkSizes { compressed, ..sizes.clone() };
            if fits && self.checksum_holds(&tried, at, end)? {
                let what = "one of the two sizes of a chunk; its messages are whole";
                self.out.report.lose(at, 0, what);
                return Ok(end);
            }
        }
        self.skip(at, "the sizes of a chunk do not agree")
    }

    /// Takes all records of a chunk, or says why its checksum is wrong.
    fn whole(&mut self, at: u64, sizes: &ChunkSizes) -> Result<Result<(), String>, Trouble> {
        let out = &mut self.out;
        let end = chunk::checked(&mut self.source, at, sizes, &mut |opcode, body| {
            take(out, opcode, body, true)
        });
        match end {
            Ok(()) => {
                self.out.report.chunks += 1;
                Ok(Ok(()))
            }
            Err(Stop::Damage(why)) => Ok(Err(why)),
            Err(Stop::Now(trouble)) => Err(trouble),
        }
    }

    /// Takes the records of a chunk whose header contradicts itself, if they are whole up to `end`.
    fn checksum_holds(&mut self, sizes: &ChunkSizes, at: u64, end: u64) -> Result<bool, Trouble> {
        if sizes.checksum == 0 || !head::is_followed(&mut self.source, end)? {
            return Ok(false);
        }
        let mut head = self.source.read(at, sizes.data - at)?;
        let places = head.len();
        head[1..HEAD_BYTES as usize].copy_from_slice(&(end - at - HEAD_BYTES).to_le_bytes());
        head[places - 8..].copy_from_slice(&sizes.compressed.to_le_bytes());
        let out = &mut self.out;
        let told = chunk::mended(&mut self.source, &head, sizes, &mut |opcode, body| {
            take(out, opcode, body, true)
        });
        match told {
            Ok(()) => {
                self.out.report.chunks += 1;
                Ok(true)
            }
            Err(Stop::Damage(_)) => Ok(false),
            Err(Stop::Now(trouble)) => Err(trouble),
        }
    }

    /// A chunk that is damaged between the offsets `at` and `end`. `before` messages were kept before it.
    fn damaged(
        &mut self,
        (at, end): (u64, u64),
        sizes: &ChunkSizes,
        why: &str,
        before: u64,
    ) -> Result<(), Trouble> {
        // Without a checksum the records before the damage have been taken already.
        if sizes.checksum != 0 {
            self.read_damaged(sizes, end)?;
        }
        let (first, last) = sizes.times_ns;
        let span_s = last.saturating_sub(first) as f64 / 1e9;
        let report = &mut self.out.report;
        let kept = report.messages - before;
        report.lost_s += if kept == 0 { span_s } else { 0.0 };
        report.lost_more = true;
        self.counts_lost = kept == 0;
        let what = format!(
            "a chunk of {span_s:.2} s is damaged ({why}); {kept} of its messages were kept"
        );
        report.lose(at, end - at, what);
        Ok(())
    }

    /// Takes the definitions of a chunk whose checksum is wrong where there are no others, and its messages if they are asked for.
    fn read_damaged(&mut self, sizes: &ChunkSizes, end: u64) -> Result<(), Trouble> {
        let (out, keep) = (&mut self.out, self.unverified);
        let on = &mut |opcode: u8, body: &[u8]| match mcap::parse_record(opcode, body) {
            Ok(record) if keep => Ok(out.take(record, false)?),
            Ok(record) => {
                out.known.add(&record, false);
                Ok(())
            }
            Err(_) => Ok(()),
        };
        if sizes.compression.is_empty() {
            chunk::plain(&mut self.source, sizes.data, end, on)?;
            return Ok(());
        }
        match chunk::unchecked(&mut self.source, sizes, end, on) {
            Err(Stop::Now(trouble)) => Err(trouble),
            _ => Ok(()),
        }
    }

    /// The last chunk of a recorder that was stopped, or of a file that was cut off: its whole messages.
    fn unfinished(&mut self, at: u64, sizes: &ChunkSizes) -> Result<u64, Trouble> {
        let length = self.source.length();
        let before = self.out.report.messages;
        let out = &mut self.out;
        let on = &mut |opcode: u8, body: &[u8]| take(out, opcode, body, false);
        let end = if sizes.compression.is_empty() {
            chunk::plain(&mut self.source, sizes.data, length, on)?
        } else {
            match chunk::unchecked(&mut self.source, sizes, length, on) {
                Err(Stop::Now(trouble)) => return Err(trouble),
                _ => length,
            }
        };
        let report = &mut self.out.report;
        let kept = report.messages - before;
        report.lost_more = true;
        report.lose(
            at,
            end - at,
            format!("the last chunk is not finished; its {kept} whole messages were kept"),
        );
        Ok(end)
    }

    /// Notes damage at `at`; returns where the next readable record begins, or the end of the file.
    fn skip(&mut self, at: u64, what: &str) -> Result<u64, Trouble> {
        let end = self.search(at + 1)?.unwrap_or(self.source.length());
        self.out.report.lose(at, end - at, what);
        self.out.report.lost_more = true;
        Ok(end)
    }

    /// The next readable record from `from` on.
    fn search(&mut self, from: u64) -> Result<Option<u64>, Trouble> {
        // A search that begins between the last one and its result has the same result: the whole file is searched once.
        if let Some((began, found)) = self.searched
            && from >= began
            && found.is_none_or(|found| from <= found)
        {
            return Ok(found);
        }
        let found = self.search_anew(from)?;
        self.searched = Some((from, found));
        Ok(found)
    }

    fn search_anew(&mut self, mut at: u64) -> Result<Option<u64>, Trouble> {
        let Self { source, out, has_chunks, .. } = self;
        let is_channel = |id: u16| !*has_chunks && out.known.has(id);
        loop {
            interruption::check()?;
            let part = source.bytes(at, SEARCH_BYTES)?.to_vec();
            for (index, bytes) in part.windows(HEAD_BYTES as usize).enumerate() {
                // No record is longer than 1 TB, apart from the placeholder of a chunk.
                let likely = bytes[6..] == [0; 3] || bytes[1..] == [0xFF; 8];
                if likely
                    && (op::HEADER..=op::DATA_END).contains(&bytes[0])
                    && head::is_record(source, at + index as u64, &is_channel)?
                {
                    return Ok(Some(at + index as u64));
                }
            }
            if (part.len() as u64) < SEARCH_BYTES {
                return Ok(None);
            }
            at += SEARCH_BYTES - (HEAD_BYTES - 1);
        }
    }
}

/// Takes a record of a chunk; one that cannot be read is left out.
fn take<W: Write + Seek>(
    out: &mut Salvage<W>,
    opcode: u8,
    body: &[u8],
    verified: bool,
) -> Result<(), Trouble> {
    match mcap::parse_record(opcode, body) {
        Ok(record) => Ok(out.take(record, verified)?),
        Err(error) => {
            out.report.lose(0, body.len() as u64, format!("a record of a chunk: {error}"));
            Ok(())
        }
    }
}
