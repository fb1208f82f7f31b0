use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::PathBuf;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions};
use tempfile::TempDir;

use super::*;

/// Messages in a small file, and bytes of a chunk, so that it has about six chunks.
const MESSAGES: u32 = 30;
const CHUNK_BYTES: u64 = 250;

const FORMS: [(&str, Option<Compression>); 3] =
    [("plain", None), ("zstd", Some(Compression::Zstd)), ("lz4", Some(Compression::Lz4))];

/// What identifies a message: channel's topic, sequence, log time, data.
type Told = (String, u32, u64, Vec<u8>);

fn data(sequence: u32) -> Vec<u8> {
    // Bytes without a pattern that a compression could use up.
    (0..24_u32)
        .map(|i| (sequence.wrapping_mul(2_654_435_761).wrapping_add(i * i * 40_503) >> 7) as u8)
        .collect()
}

fn small(compression: Option<Compression>, chunked: bool) -> Vec<u8> {
    let mut file = WriteOptions::new()
        .compression(compression)
        .chunk_size(Some(CHUNK_BYTES))
        .use_chunks(chunked)
        .profile("test")
        .library("another recorder")
        .create(Cursor::new(Vec::new()))
        .unwrap();
    let kept = Attachment {
        log_time: 1,
        create_time: 2,
        name: "a.txt".to_owned(),
        media_type: "text/plain".to_owned(),
        data: b"attached"[..].into(),
    };
    file.attach(&kept).unwrap();
    let metadata =
        Metadata { name: "about".to_owned(), metadata: BTreeMap::from([("k".into(), "v".into())]) };
    file.write_metadata(&metadata).unwrap();
    let schema = file.add_schema("S", "jsonschema", b"{}").unwrap();
    let channels = ["/a", "/b"]
        .map(|topic| file.add_channel(schema, topic, "json", &BTreeMap::new()).unwrap());
    for sequence in 0..MESSAGES {
        let header = MessageHeader {
            channel_id: channels[sequence as usize % 2],
            sequence,
            log_time: u64::from(sequence) * 10_000_000,
            publish_time: 0,
        };
        file.write_to_known_channel(&header, &data(sequence)).unwrap();
    }
    file.finish().unwrap();
    file.into_inner().into_inner()
}

/// A file in a folder of its own, which is removed when it is dropped.
struct Place {
    folder: TempDir,
    file: PathBuf,
}

impl Place {
    fn new(name: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        Self { folder, file }
    }

    /// Salvages `bytes`; the new file has to be one that the reference library reads with its summary.
    fn salvage(&self, bytes: &[u8], unverified: bool) -> Option<(Salvaged, Vec<Told>)> {
        std::fs::write(&self.file, bytes).unwrap();
        let mut out = Cursor::new(Vec::new());
        let found = match recover(&self.file, &mut out, unverified) {
            Ok(found) => found,
            Err(RecoverError::Nothing { .. }) => return None,
            Err(error) => panic!("{error}"),
        };
        let out = out.into_inner();
        let summary = mcap::Summary::read(&out).unwrap().expect("a summary");
        let told = messages(&out);
        assert_eq!(summary.stats.unwrap().message_count, found.messages);
        assert_eq!(told.len() as u64, found.messages);
        Some((found, told))
    }
}

fn messages(bytes: &[u8]) -> Vec<Told> {
    let stream = mcap::MessageStream::new(bytes).unwrap();
    let told = stream.map(|message| {
        let message = message.unwrap();
        (
            message.channel.topic.clone(),
            message.sequence,
            message.log_time,
            message.data.into_owned(),
        )
    });
    told.collect()
}

fn number(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().unwrap()))
}

/// Offsets of the records in `bytes` from `at` on: opcode, first byte of the body, end.
fn records(bytes: &[u8], mut at: usize) -> Vec<(u8, usize, usize)> {
    let mut found = Vec::new();
    while let Some(length) = number(bytes, at + 1) {
        let end = at + 9 + length as usize;
        found.push((bytes[at], at + 9, end));
        at = end;
    }
    found
}

/// The oracle: whole messages of the first `cut` bytes of a sound file, decompressed by the libraries of the compressions themselves.
fn whole_messages(file: &[u8], cut: usize) -> usize {
    let count = |raw: &[u8]| {
        records(raw, 0)
            .into_iter()
            .filter(|(opcode, _, end)| *opcode == 5 && *end <= raw.len())
            .count()
    };
    let mut sum = 0;
    for (opcode, body, end) in records(file, 8) {
        if opcode == 5 && end <= cut {
            sum += 1;
        }
        if opcode == 6 {
            let letters = usize::from(file[body + 28]);
            let data = body + 32 + letters + 8;
            if data > cut {
                continue;
            }
            let part = &file[data..end.min(cut)];
            sum += match &file[body + 32..body + 32 + letters] {
                b"zstd" => count(&decoded(zstd::Decoder::new(part).unwrap())),
                b"lz4" => count(&lz4::Decoder::new(part).map(decoded).unwrap_or_default()),
                _ => count(part),
            };
        }
    }
    sum
}

/// What decompresses before the end of the input.
fn decoded(mut from: impl Read) -> Vec<u8> {
    let (mut raw, mut byte) = (Vec::new(), [0]);
    while from.read(&mut byte).is_ok_and(|read| read == 1) {
        raw.push(byte[0]);
    }
    raw
}

#[test]
fn of_a_file_cut_at_any_byte_every_whole_message_is_kept() {
    for (name, compression) in FORMS {
        let file = small(compression, true);
        let place = Place::new(&format!("cut-{name}.mcap"));
        let all = messages(&file);
        assert_eq!(whole_messages(&file, file.len()), all.len());
        for cut in 0..=file.len() {
            let told = place.salvage(&file[..cut], false).map_or_else(Vec::new, |(_, told)| told);
            assert_eq!(told, all[..whole_messages(&file, cut)], "{name}, cut at {cut}");
        }
    }
}

#[test]
fn of_a_file_without_chunks_cut_at_any_byte_every_whole_message_is_kept() {
    let file = small(None, false);
    let (place, all) = (Place::new("cut-unchunked.mcap"), messages(&file));
    for cut in 0..=file.len() {
        let told = place.salvage(&file[..cut], false).map_or_else(Vec::new, |(_, told)| told);
        assert_eq!(told, all[..whole_messages(&file, cut)], "cut at {cut}");
    }
}

#[test]
fn the_open_chunk_of_a_killed_recorder_is_read_as_far_as_it_goes() {
    for (name, compression) in FORMS {
        let file = small(compression, true);
        let (place, all) = (Place::new(&format!("open-{name}.mcap")), messages(&file));
        let chunks: Vec<_> =
            records(&file, 8).into_iter().filter(|(opcode, ..)| *opcode == 6).collect();
        let (_, body, end) = chunks[2];
        let letters = usize::from(file[body + 28]);
        for cut in body + 40 + letters..end {
            let mut open = file[..cut].to_vec();
            // A recorder writes these numbers when it closes the chunk.
            for at in [body - 8, body + 16, body + 32 + letters] {
                open[at..at + 8].fill(0xFF);
            }
            open[body + 24..body + 28].fill(0xFF);
            let (found, told) = place.salvage(&open, false).expect("messages before");
            assert_eq!(told, all[..whole_messages(&file, cut)], "{name}, cut at {cut}");
            assert!(found.lost_more && !found.finished);
        }
    }
}

#[test]
fn a_damaged_byte_costs_at_most_its_chunk_and_never_gives_a_wrong_message() {
    for (name, compression) in FORMS {
        let file = small(compression, true);
        let (place, all) = (Place::new(&format!("flip-{name}.mcap")), messages(&file));
        let most = all.len() / 4;
        // Every byte of the plain form; of the others enough to hit every field of every kind of record.
        for at in (0..file.len()).step_by(if compression.is_none() { 1 } else { 5 }) {
            for mask in [0x01, 0x02] {
                let mut damaged = file.clone();
                damaged[at] ^= mask;
                let (found, told) = place.salvage(&damaged, false).expect("most of it");
                let lost = all.iter().filter(|message| !told.contains(message)).count();
                let topic = |told: &Told| told.0.len() == 2;
                let wrong =
                    told.iter().filter(|message| topic(message) && !all.contains(message)).count();
                assert!(
                    lost <= most && wrong == 0,
                    "{name}, byte {at}: {lost} lost, {wrong} wrong, {found:?}"
                );
                assert!(lost == 0 || found.damaged_places > 0, "{name}, byte {at}: {found:?}");
            }
        }
    }
}

#[test]
fn the_account_says_how_many_messages_are_lost_and_unverified_ones_come_on_request() {
    let file = small(None, true);
    let place = Place::new("account.mcap");
    let all = messages(&file);
    let chunk = records(&file, 8).into_iter().filter(|(opcode, ..)| *opcode == 6).nth(2).unwrap();
    let mut damaged = file.clone();
    damaged[chunk.2 - 1] ^= 1;
    let (found, told) = place.salvage(&damaged, false).unwrap();
    assert_eq!(found.lost_messages, (all.len() - told.len()) as u64);
    assert!(found.lost_messages > 0 && found.finished && !found.lost_more, "{found:?}");
    assert!(found.losses[0].what.contains("CRC"), "{found:?}");
    let cut = records(&file, 8).into_iter().find(|(opcode, ..)| *opcode == 0x0F).unwrap().1 - 9;
    let (by_index, _) = place.salvage(&damaged[..cut], false).unwrap();
    assert_eq!(by_index.lost_messages, found.lost_messages);
    let (kept, told) = place.salvage(&damaged, true).unwrap();
    assert_eq!((told.len(), kept.lost_messages), (all.len(), 0));
    assert!(kept.unverified_messages > 0);
}

#[test]
fn attachments_metadata_profile_and_definitions_come_along() {
    let file = small(Some(Compression::Zstd), true);
    let place = Place::new("extras.mcap");
    let path = &place.file;
    std::fs::write(path, &file[..file.len() - 50]).unwrap();
    let mut out = Cursor::new(Vec::new());
    let found = recover(path, &mut out, false).unwrap();
    assert_eq!((found.attachments, found.metadata, found.channels), (1, 1, 2));
    let out = out.into_inner();
    let summary = mcap::Summary::read(&out).unwrap().unwrap();
    let read = mcap::read::attachment(&out, &summary.attachment_indexes[0]).unwrap();
    assert_eq!((&*read.data, read.name.as_str()), (&b"attached"[..], "a.txt"));
    let about = mcap::read::metadata(&out, &summary.metadata_indexes[0]).unwrap();
    assert_eq!(about.metadata["k"], "v");
    let told = mcap::read::metadata(&out, &summary.metadata_indexes[1]).unwrap();
    assert_eq!(
        (told.name.as_str(), told.metadata["finished"].as_str()),
        (METADATA_RECOVERED, "false")
    );
    let schema = summary.channels.values().next().unwrap().schema.clone().unwrap();
    assert_eq!((schema.name.as_str(), &*schema.data), ("S", &b"{}"[..]));
    match mcap::read::LinearReader::new(&out).unwrap().next().unwrap().unwrap() {
        mcap::records::Record::Header(header) => {
            assert_eq!(
                (header.profile.as_str(), header.library.as_str()),
                ("test", "another recorder")
            );
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn holes_text_folders_and_no_file_are_clear_errors() {
    let place = Place::new("hole.mcap");
    let file = small(None, true);
    let mut holed = file.clone();
    let middle = file.len() / 2;
    holed.splice(middle..middle, vec![0; 300_000]);
    let (found, told) = place.salvage(&holed, false).unwrap();
    assert!(told.len() * 3 > messages(&file).len() * 2, "{found:?}");
    assert!(place.salvage(b"hello, this is text", false).is_none());
    assert!(place.salvage(b"", false).is_none());
    let refused =
        |path: &Path| recover(path, Cursor::new(Vec::new()), false).unwrap_err().to_string();
    let folder = refused(place.folder.path());
    assert!(folder.contains("not a regular file"), "{folder}");
    assert!(refused(Path::new("/no/such/file.mcap")).contains("/no/such/file.mcap"));
}
