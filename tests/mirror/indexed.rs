//! Long flights that are read part by part through the index of their file, compared with the same flights read whole.

use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use twin_foreign::Shadow;
use twin_foreign::playback::PartReader;
use twin_foreign::stretches::LONG_S;
use twin_foreign::{OpenedFlight, RecordedFlight};

use super::made::{Form, PLAIN, file, flight};

/// A flight longer than those that are read whole, with a hole in which a part ends.
const LONG: Form = Form { seconds: LONG_S + 30.0, hole_s: Some((53.0, 55.5)), ..PLAIN };

/// The filters start 4 s earlier, or at the start of the flight, so accelerations of some m/s² differ by rounding.
const ROUNDING: f64 = 1e-9;

pub(super) fn both(path: &Path) -> (OpenedFlight, OpenedFlight) {
    let long = OpenedFlight::open(path, None).expect("a flight");
    (long, OpenedFlight::open_whole(path, None).expect("a flight"))
}

pub(super) fn parts(opened: &OpenedFlight) -> &Arc<dyn PartReader> {
    opened.long.as_ref().expect("it is long and has chunks")
}

/// Asserts that the ticks of `part` are those of `whole` from tick `from` on. Numbers that need no fit may differ by `tolerance`.
pub(super) fn assert_same(
    part: &RecordedFlight,
    whole: &RecordedFlight,
    from: usize,
    tolerance: f64,
) {
    for (i, instant) in part.instants.iter().enumerate() {
        let (tick, other) = (from + i, &whole.instants[from + i]);
        assert_eq!(part.times_s[i].to_bits(), whole.times_s[tick].to_bits(), "{tick}");
        assert_eq!(part.airborne[i], whole.airborne[tick], "{tick}");
        let pairs = [
            (instant.chi, other.chi),
            (instant.chi_dot, other.chi_dot),
            (instant.chi_ddot, other.chi_ddot),
        ];
        for (found, wanted) in pairs.iter().flat_map(|(a, b)| a.iter().zip(b)) {
            let near = match (found, wanted) {
                (Some(found), Some(wanted)) => (found - wanted).abs() <= tolerance,
                (None, None) => true,
                _ => false,
            };
            assert!(near, "{tick}: {found:?} {wanted:?}");
        }
        // A recording of this program needs no fit.
        let bits = |tau: [Option<f64>; 8]| tau.map(|tau| tau.map(f64::to_bits));
        assert!(tolerance > 0.0 || bits(instant.tau) == bits(other.tau), "{tick}");
        let known = |tau: [Option<f64>; 8]| tau.map(|tau| tau.is_some());
        assert_eq!(known(instant.tau), known(other.tau), "{tick}");
    }
}

#[test]
fn a_long_flight_read_part_by_part_is_the_one_read_whole() {
    for (name, compression) in
        [("long_zstd.mcap", Some(mcap::Compression::Zstd)), ("long_none.mcap", None)]
    {
        let path = file(name, &flight(Form { compression, ..LONG }));
        let (long, whole) = both(&path);
        let parts = parts(&long);
        assert_eq!(parts.ticks(), whole.recorded.instants.len());
        // The parts are in any order and of any length, and lie over the hole and at both ends.
        for (from, to) in
            [(5200, 5700), (0, 500), (14_700, parts.ticks()), (5600, 5601), (5200, 5700)]
        {
            let part = parts.part(from, to);
            assert_eq!(part.instants.len(), to - from);
            assert_same(&part, &whole.recorded, from, ROUNDING);
        }
        assert!(parts.troubles().is_empty());
        assert!(long.recorded.instants.len() < 7000, "{}", long.recorded.instants.len());
        let gain = |opened: &OpenedFlight| match &opened.recorded.effort {
            twin_foreign::Effort::Fitted { fit, .. } => fit.gain,
            other => panic!("{other:?}"),
        };
        // The whole flight is one circle, so the stretches give the same gain, up to the run-in of the filter H.
        assert!((gain(&long) / gain(&whole) - 1.0).abs() < 1e-3);
        assert!(long.signals.notes.iter().any(|note| note.contains("stretches")));
        // The time between two stretches is not a gap of the recording.
        assert_eq!(long.signals.used[0].timing.gaps, 0, "{:?}", long.signals.used[0]);
    }
}

#[test]
fn a_long_flight_in_shadow_predicts_what_the_whole_one_predicts() {
    let path = file("long_shadow.mcap", &flight(LONG));
    let (long, whole) = both(&path);
    let fly = |opened: &OpenedFlight| Shadow::of(opened).fly(&mut |_| {}).expect("ticks");
    let (long, whole) = (fly(&long), fly(&whole));
    assert_eq!((long.ticks, long.airborne_ticks), (whole.ticks, whole.airborne_ticks));
    assert_eq!(long.held_ticks, whole.held_ticks);
    for (ours, other) in long.scored.rows.iter().zip(&whole.scored.rows) {
        assert_eq!(ours.residual_known.to_bits(), other.residual_known.to_bits(), "{ours:?}");
        assert_eq!(ours.residual.is_some(), other.residual.is_some());
        if let (Some(a), Some(b)) = (ours.residual, other.residual) {
            // The gain may differ by 1e-3 of 10 N/kg.
            assert!((a.mean - b.mean).abs() < 0.02, "{a:?} {b:?}");
        }
    }
}

#[test]
fn the_file_of_a_recorder_that_was_killed_is_read_through_its_chunks() {
    let whole_file = flight(Form { seconds: LONG_S * 2.0, ..PLAIN });
    let cut = &whole_file[..whole_file.len() * 2 / 3];
    let path = file("long_cut.mcap", cut);
    let (long, whole) = both(&path);
    assert_eq!(parts(&long).ticks(), whole.recorded.instants.len());
    let last = parts(&long).ticks();
    assert_same(&parts(&long).part(last - 300, last), &whole.recorded, last - 300, ROUNDING);
    let problems = &long.survey.container.problems;
    assert!(
        problems.iter().any(|text| text.contains("without an end of its data")),
        "{problems:?}"
    );
    assert_eq!(long.survey.messages, whole.survey.messages);
    // A summary that is wrong counts as missing; the rest of the file is still read.
    let mut bad = whole_file.clone();
    let at = bad.len() - 8 - 20;
    bad[at..at + 8].copy_from_slice(&u64::MAX.to_le_bytes());
    let long = OpenedFlight::open(&file("long_bad_summary.mcap", &bad), None).expect("a flight");
    assert!(parts(&long).ticks() > 23_900);
}

/// Middle of the chunk that lies at this share of the file, found by walking the records.
fn chunk_at(bytes: &[u8], share: f64) -> usize {
    let mut at = 8;
    loop {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight")) as usize;
        if bytes[at] == 0x06 && at as f64 > share * bytes.len() as f64 {
            return at + 9 + length / 2;
        }
        at += 9 + length;
    }
}

#[test]
fn a_damaged_chunk_far_inside_is_unknown_when_it_is_played_and_said_once() {
    let mut bytes = flight(Form { compression: None, hole_s: None, ..LONG });
    // The damage lies between two stretches, so that opening the file does not find it.
    let middle = chunk_at(&bytes, 0.36);
    bytes[middle] ^= 0x55;
    let opened = OpenedFlight::open(&file("long_damaged.mcap", &bytes), None).expect("a flight");
    let parts = parts(&opened);
    assert!(opened.survey.container.problems.is_empty());
    let near = (0.36 * parts.ticks() as f64) as usize;
    for repeat in 0..2 {
        let part = parts.part(near - 300, near + 300);
        let unknown = part.instants.iter().filter(|i| i.chi[0].is_none()).count();
        // A chunk of 16 kB holds one or two seconds of these messages.
        assert!((20..400).contains(&unknown), "{unknown}");
        let said = parts.troubles();
        assert_eq!(said.len(), usize::from(repeat == 0), "{said:?}");
    }
}

#[test]
fn a_short_flight_and_what_has_no_chunks_are_read_whole() {
    let short = file("short.mcap", &flight(PLAIN));
    assert!(OpenedFlight::open(&short, None).expect("a flight").long.is_none());
    for bytes in [b"".to_vec(), b"hello".to_vec(), super::made::ulog(), flight(PLAIN)] {
        let input = Box::new(Cursor::new(bytes));
        let found = OpenedFlight::open_long(Path::new("x"), None, input).expect("no long flight");
        assert!(found.is_none());
    }
}
