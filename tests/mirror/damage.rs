//! Damaged files, messages and maps: the reader does not panic, hang or give a wrong value, and uses the undamaged part.

use std::path::Path;

use rand::{RngExt, SeedableRng};
use twin_foreign::cdr::decode;
use twin_foreign::gather::gather;
use twin_foreign::recorded::on_ticks;
use twin_foreign::schema::Layout;
use twin_foreign::signals::signals;
use twin_foreign::{Map, Survey, container, topics};

use super::made::{Form, PLAIN, file, flight};

/// Number of damaged files that are read to the ticks; each takes about a millisecond.
const FILES: usize = 1500;

/// Number of damaged messages, schemas and maps.
const TEXTS: usize = 20_000;

/// A flight of half a second in several chunks.
const SMALL: Form = Form { seconds: 0.5, compression: None, chunk_bytes: 2048, ..PLAIN };

pub(super) fn mutate(bytes: &[u8], rng: &mut rand_pcg::Pcg64) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..rng.random_range(1..6) {
        let at = rng.random_range(0..out.len());
        match rng.random_range(0..6) {
            0 => out[at] ^= 1 << rng.random_range(0..8),
            1 => out[at] = rng.random(),
            2 => out.truncate(at.max(1)),
            3 => out[at..].iter_mut().take(8).for_each(|byte| *byte = 0xFF),
            4 => out.insert(at, rng.random()),
            _ => {
                let end = (at + rng.random_range(1..64)).min(out.len());
                let part = out[at..end].to_vec();
                out.extend(part);
            }
        }
    }
    out
}

fn generic() -> Map {
    Map::over_generic(Map::default()).expect("the generic map")
}

/// Reads the file as far as possible; other tests check the result.
fn read_all(path: &Path, map: &Map) {
    let Ok(survey) = Survey::read(path) else { return };
    if let Ok(gathered) = gather(path, map)
        && survey.duration_s < 100.0
        && let Ok(recorded) = on_ticks(&signals(&gathered), &map.vehicle)
    {
        let known = recorded.instants.iter().flat_map(|i| i.chi.iter().flatten());
        assert!(known.copied().all(f64::is_finite));
    }
}

#[test]
fn a_file_cut_at_every_byte_keeps_what_came_before_and_says_that_it_is_cut() {
    for compression in [None, Some(mcap::Compression::Zstd)] {
        let whole = flight(Form { seconds: 0.1, chunk_bytes: 512, compression, ..PLAIN });
        let mut last = 0;
        for end in 0..whole.len() {
            let mut messages = 0;
            let found = container::read(&mut &whole[..end], &mut |record| {
                messages += u64::from(matches!(record, mcap::records::Record::Message { .. }));
            });
            let Ok(found) = found else {
                assert!(end < 8, "refused at byte {end}");
                continue;
            };
            assert_eq!(found.complete, found.problems.is_empty(), "byte {end}: {found:?}");
            // The decompressor gives bytes in blocks, so a longer piece of the file never gives fewer messages.
            assert!(messages >= last, "byte {end}: {messages} after {last}");
            last = messages;
        }
        assert_eq!(last, 24);
    }
}

/// A byte in the middle of chunk `number`, found by walking the records: opcode, length as u64, content.
fn middle_of_a_chunk(file: &[u8], number: usize) -> usize {
    let (mut at, mut chunks) = (8, 0);
    loop {
        let length = u64::from_le_bytes(file[at + 1..at + 9].try_into().expect("eight")) as usize;
        chunks += usize::from(file[at] == 0x06);
        if chunks > number {
            return at + 9 + length / 2;
        }
        at += 9 + length;
    }
}

#[test]
fn a_damaged_chunk_is_left_out_whole_and_the_others_are_read() {
    let whole = flight(Form { compression: None, ..SMALL });
    let mut damaged = whole.clone();
    let middle = middle_of_a_chunk(&whole, 2);
    damaged[middle] ^= 0x55;
    let read = |bytes: &[u8]| {
        let mut data = Vec::new();
        let found = container::read(&mut &*bytes, &mut |record| {
            if let mcap::records::Record::Message { data: message, .. } = record {
                data.push(message.into_owned());
            }
        });
        (found.expect("an MCAP"), data)
    };
    let ((_, all), (found, rest)) = (read(&whole), read(&damaged));
    assert_eq!(found.chunks_lost, 1);
    assert!(found.complete && found.problems[0].contains("damaged"), "{:?}", found.problems);
    assert!(rest.len() > all.len() / 2 && rest.len() < all.len());
    assert!(rest.iter().all(|message| all.contains(message)));
}

#[test]
fn mutated_files_never_panic_hang_or_give_numbers_that_are_not_finite() {
    let map = generic();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
    let seeds =
        [flight(SMALL), flight(Form { compression: Some(mcap::Compression::Zstd), ..SMALL })];
    for i in 0..FILES {
        let path = file("mutated.mcap", &mutate(&seeds[i % seeds.len()], &mut rng));
        read_all(&path, &map);
    }
}

#[test]
fn mutated_messages_schemas_and_maps_never_panic_or_hang() {
    let text = "uint8 a\nfloat64 b\nstring name\nfloat32[] values\nInner[] inner\nstring[<=4] names\n===\nMSG: p/Inner\nint16 c\nfloat32[3] d\n";
    let layout = Layout::parse("p/msg/Outer", text).expect("a schema");
    let message: Vec<u8> = [0, 1, 0, 0, 7, 0, 0, 0]
        .into_iter()
        .chain((0..160).map(|i| if i % 4 == 0 { 2 } else { 0 }))
        .collect();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(6);
    let (mut decoded, mut parsed) = (0, 0);
    for i in 0..TEXTS {
        decoded += usize::from(decode(&layout, &mutate(&message, &mut rng)).is_ok());
        let schema = String::from_utf8_lossy(&mutate(text.as_bytes(), &mut rng)).into_owned();
        if let Ok(layout) = Layout::parse("p/msg/Outer", &schema) {
            parsed += 1;
            // Decoding by a schema of another message must end, too.
            let _ = decode(&layout, &message);
        }
        if i % 20 == 0 {
            let (name, map) = topics::SHIPPED[i / 20 % topics::SHIPPED.len()];
            let map = String::from_utf8_lossy(&mutate(map.as_bytes(), &mut rng)).into_owned();
            let _ = Map::parse(&map, name);
        }
    }
    // Both outcomes occurred.
    assert!(decoded > 0 && decoded < TEXTS && parsed > 0 && parsed < TEXTS, "{decoded} {parsed}");
}
