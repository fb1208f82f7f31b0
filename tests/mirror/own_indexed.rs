//! Long recordings of this program that are read part by part through the index of their file: the numbers are equal bit for bit, in
//! whatever way the file is divided into chunks.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::{Compression, Message, WriteOptions};
use twin_core::tick::Tick;
use twin_foreign::OpenedFlight;
use twin_record::{Recorder, RecordingEnd};
use twin_scenario::Scenario;

use super::indexed::{assert_same, both, parts};
use super::made::file;

/// Number of ticks, more than those of a recording that is read whole.
const TICKS: u64 = 13_000;

/// A recording of this program with `ticks` ticks: a short flight, repeated with continued tick numbers.
fn own(name: &str, ticks: u64) -> PathBuf {
    let hover = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/hover.toml");
    let scenario = Scenario::load(&hover, &[]).expect("a scenario");
    let mut flight = scenario.build().expect("a flight");
    let flown: Vec<Tick> = (0..200).map(|_| flight.tick()).collect();
    let path = file(name, b"");
    // The recorder makes a new file only.
    std::fs::remove_file(&path).expect("it was just made");
    let info = scenario.recording_info(flight.tuning()).expect("it can be recorded");
    let mut recorder = Recorder::create(&path, &info).expect("a file");
    for index in 0..ticks {
        let mut tick = flown[index as usize % flown.len()].clone();
        tick.index = index;
        tick.measurement.t_s = index as f64 * twin_core::notation::TICK_S;
        // All ticks differ, so that a tick in the wrong place is found.
        tick.measurement.chi[0] += index as f64 * 1e-6;
        recorder.record(Arc::new(tick)).expect("recorded");
    }
    recorder.finish(RecordingEnd::default()).expect("written");
    path
}

#[test]
fn a_long_recording_of_this_program_comes_back_bit_for_bit_also_without_its_end() {
    let path = own("long_own.mcap", 13_000);
    let bytes = std::fs::read(&path).expect("it is there");
    let cut = file("long_own_cut.mcap", &bytes[..bytes.len() - bytes.len() / 50]);
    for path in [path, cut] {
        let (long, whole) = both(&path);
        let parts = parts(&long);
        assert!(long.is_own());
        // Reading a cut file whole leaves out its last chunk; reading by the index uses the whole records of that chunk.
        let last = whole.recorded.instants.len();
        assert!(last > 12_500 && parts.ticks() >= last, "{last} {}", parts.ticks());
        for (from, to) in [(0, 500), (5_950, 6_100), (last - 130, last)] {
            assert_same(&parts.part(from, to), &whole.recorded, from, 0.0);
        }
        assert_eq!(long.recorded.nominal_inertia, whole.recorded.nominal_inertia);
        assert!(parts.troubles().is_empty());
    }
}

/// Writes the messages of `path` to another file, in another order.
fn rewritten(
    path: &Path,
    name: &str,
    options: WriteOptions,
    reorder: impl FnOnce(&mut Vec<Message<'_>>),
) -> PathBuf {
    let bytes = std::fs::read(path).expect("it is there");
    let stream = mcap::MessageStream::new(&bytes).expect("an MCAP file");
    let mut messages: Vec<Message<'_>> = stream.map(|message| message.expect("whole")).collect();
    reorder(&mut messages);
    let mut writer = options.compression_threads(0).create(Cursor::new(Vec::new())).expect("begun");
    for message in &messages {
        writer.write(message).expect("written");
    }
    writer.finish().expect("ended");
    file(name, &writer.into_inner().into_inner())
}

/// Chunks of a hundred kilobytes, which hold some ten ticks; no chunk begins where a block does.
fn small() -> WriteOptions {
    WriteOptions::new().chunk_size(Some(100_000))
}

#[test]
fn chunks_of_any_size_and_kind_hold_the_same_flight() {
    let path = own("own_as_recorded.mcap", TICKS);
    let wanted = OpenedFlight::open_whole(&path, None).expect("a flight").recorded;
    for (name, options) in [
        ("own_lz4.mcap", small().compression(Some(Compression::Lz4))),
        ("own_none.mcap", small().compression(None)),
        ("own_large.mcap", WriteOptions::new().chunk_size(Some(30_000_000))),
        ("own_no_summary.mcap", small().emit_summary_records(false)),
    ] {
        let path = rewritten(&path, name, options, |_| ());
        let opened = OpenedFlight::open(&path, None).expect("a flight");
        let parts = parts(&opened);
        assert_eq!(parts.ticks(), wanted.instants.len(), "{name}");
        // The parts are in the order of a flight, in the order of seeks, and over the end of a chunk.
        for (from, to) in [(0, 100), (100, 200), (12_345, 13_000), (5_950, 6_100), (200, 200)] {
            assert_eq!(parts.part(from, to).instants.len(), to - from, "{name}");
            assert_same(&parts.part(from, to), &wanted, from, 0.0);
        }
        assert!(parts.troubles().is_empty(), "{name}");
    }
    // Without a message index the file cannot be read by parts.
    let options = small().emit_message_indexes(false);
    let path = rewritten(&path, "own_no_index.mcap", options, |_| ());
    let opened = OpenedFlight::open(&path, None).expect("a flight");
    assert!(opened.long.is_none());
    assert_same(&opened.recorded, &wanted, 0, 0.0);
}

#[test]
fn chunks_that_overlap_in_time_are_read_in_the_order_of_the_file() {
    let path = own("own_in_order.mcap", TICKS);
    // Of every four seconds, the even ticks come first, then the odd ones: several chunks each, which overlap in time.
    let interleave = |messages: &mut Vec<Message<'_>>| {
        messages.sort_by_key(|message| (message.sequence / 400, message.sequence % 2));
    };
    let path = rewritten(&path, "own_overlapping.mcap", small(), interleave);
    let (long, whole) = both(&path);
    let parts = parts(&long);
    assert_eq!(parts.ticks(), whole.recorded.instants.len());
    assert_same(&parts.part(3_950, 4_850), &whole.recorded, 3_950, 0.0);
    assert!(whole.recorded.times_s.windows(2).any(|pair| pair[1] < pair[0]), "they do overlap");
    assert!(parts.troubles().is_empty());
}

#[test]
fn many_readers_at_once_read_what_one_reads() {
    let path = own("own_readers.mcap", TICKS);
    let (long, whole) = both(&path);
    let parts = parts(&long);
    std::thread::scope(|scope| {
        for reader in 0..4 {
            let whole = &whole.recorded;
            // Each reader visits the same ticks in another order.
            scope.spawn(move || {
                for k in 0..40 {
                    let from = (k * (2 * reader + 1)) % 40 * 75;
                    assert_same(&parts.part(from, from + 100), whole, from, 0.0);
                }
            });
        }
    });
}

/// Positions of the numbers in the chunk indexes of the summary that give the place of the message index of each chunk's second channel.
fn second_indexes(bytes: &[u8]) -> Vec<usize> {
    let long = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight"));
    let mut at = 8;
    let mut found = Vec::new();
    while at + 9 < bytes.len() {
        if bytes[at] == 0x08 {
            // Times of the first and last message, place and length of the chunk, length of the map; each entry of the map is a channel
            // and a place, ten bytes. This finds the second entry in the order of the file.
            let map = at + 9 + 4 * 8 + 4;
            let length = u32::from_le_bytes(bytes[map - 4..map].try_into().expect("four"));
            let mut places: Vec<usize> =
                (0..length as usize / 10).map(|k| map + 10 * k + 2).collect();
            places.sort_by_key(|place| long(*place));
            // The last chunk may hold one channel alone.
            found.extend(places.get(1));
        }
        at += 9 + long(at + 1) as usize;
    }
    found
}

#[test]
fn an_index_that_miscounts_its_chunks_is_said_and_no_tick_is_made_up() {
    // The ticks are the second channel of every chunk, so their message index is the second one.
    let only_ticks = |messages: &mut Vec<Message<'_>>| {
        messages.retain(|m| m.channel.topic == "/twin/tick" || m.channel.topic == "/tf");
    };
    let path = own("own_to_damage.mcap", TICKS);
    let path = rewritten(&path, "own_two_channels.mcap", small(), only_ticks);
    let mut bytes = std::fs::read(&path).expect("it is there");
    let places = second_indexes(&bytes);
    // One chunk claims a tick more, and a later one a tick less; the sum agrees with the file.
    let (more, less) = (places[places.len() / 3], places[places.len() / 2]);
    for (place, step) in [(more, -16_i64), (less, 16)] {
        let at = u64::from_le_bytes(bytes[place..place + 8].try_into().expect("eight"));
        bytes[place..place + 8].copy_from_slice(&at.saturating_add_signed(step).to_le_bytes());
    }
    let (long, whole) = both(&file("own_miscounted.mcap", &bytes));
    let parts = parts(&long);
    let all = parts.part(0, parts.ticks());
    let said = parts.troubles();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said.iter().all(|text| text.contains("its index says")), "{said:?}");
    // One tick is missing, one is left out, and the ticks between them are late by one; all others are in their place.
    let unknown: Vec<usize> =
        (0..all.instants.len()).filter(|tick| all.instants[*tick].chi[0].is_none()).collect();
    assert_eq!(unknown.len(), 1, "{unknown:?}");
    assert!(unknown[0] > 3_000 && unknown[0] < 6_000, "{unknown:?}");
    assert_same(&parts.part(0, 3_000), &whole.recorded, 0, 0.0);
    assert_same(&parts.part(9_000, 13_000), &whole.recorded, 9_000, 0.0);
}
