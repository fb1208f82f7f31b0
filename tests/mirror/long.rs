//! Runs that take minutes, on request (a hang is a run that does not end): `TWIN_FUZZ_INPUTS=10000000` damages so many inputs, `TWIN_HOUR=1` mirrors an hour.

#![expect(clippy::disallowed_methods, reason = "what takes how long is wall-clock time")]

use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use twin::mirror::cdr::{decode, decode_packed};
use twin::mirror::gather::gather_from;
use twin::mirror::schema::Layout;
use twin::mirror::{Map, OpenedFlight, Survey, topics};
use twin::scenario::Shadow;

use super::damage::mutate;
use super::made::{Form, PLAIN, file, flight, ulog};

/// Inputs without a request: enough to take every way.
const FEW: u64 = 20_000;

/// A message definition with everything a definition may have.
const TEXT: &str = "uint8 a\nfloat64 b\nstring name\nfloat32[] values\nInner[] inner\nstring[<=4] names\n===\nMSG: p/Inner\nint16 c\nfloat32[3] d\n";

#[test]
fn damaged_files_messages_definitions_and_maps_never_panic_or_hang() {
    let wanted = std::env::var("TWIN_FUZZ_INPUTS").ok().and_then(|text| text.parse().ok());
    let inputs: u64 = wanted.unwrap_or(FEW);
    let seed = std::env::var("TWIN_FUZZ_SEED").ok().and_then(|text| text.parse().ok()).unwrap_or(7);
    let tiny = |compression| flight(Form { seconds: 0.05, chunk_bytes: 256, compression, ..PLAIN });
    let files = [tiny(None), tiny(Some(mcap::Compression::Lz4)), ulog()];
    let layout = Layout::parse("p/msg/Outer", TEXT).expect("a definition");
    let message: Vec<u8> = [0, 1, 0, 0, 7, 0, 0, 0].into_iter().chain([2; 160]).collect();
    let map = Map::over_generic(Map::default()).expect("the generic map");
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let mut read = 0_u64;
    for i in 0..inputs {
        match i % 10 {
            0..3 => {
                let bytes = mutate(&files[rng.random_range(0..files.len())], &mut rng);
                read += u64::from(Survey::read_from(&mut &bytes[..]).is_ok());
                let _ = gather_from(&mut &bytes[..], &map);
            }
            3..6 => {
                let bytes = mutate(&message, &mut rng);
                let _ = (decode(&layout, &bytes), decode_packed(&layout, &bytes));
            }
            6..9 => {
                let text = String::from_utf8_lossy(&mutate(TEXT.as_bytes(), &mut rng)).into_owned();
                if let Ok(layout) = Layout::parse("p/msg/Outer", &text) {
                    let _ = decode(&layout, &message);
                }
                let _ = Layout::parse_ulog(&text);
            }
            _ => {
                let (name, text) = topics::SHIPPED[rng.random_range(0..topics::SHIPPED.len())];
                let text = String::from_utf8_lossy(&mutate(text.as_bytes(), &mut rng)).into_owned();
                let _ = Map::parse(&text, name);
            }
        }
    }
    // Damage seldom hits the first bytes: most files are read.
    assert!(read > inputs / 10, "{read} of {inputs}");
    if wanted.is_some() {
        eprintln!("{inputs} damaged inputs of seed {seed}: no panic, no hang");
    }
}

#[test]
fn an_hour_is_mirrored() {
    if std::env::var_os("TWIN_HOUR").is_none() {
        eprintln!("SKIPPED: an hour-long flight; set TWIN_HOUR=1");
        return;
    }
    let path = file("hour.mcap", &flight(Form { seconds: 3600.0, ..PLAIN }));
    let bytes = std::fs::metadata(&path).expect("a file").len();
    let start = Instant::now();
    let opened = OpenedFlight::open(&path, None).expect("a flight");
    let shadow = Shadow::new(&opened.recorded, None);
    let started = start.elapsed();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
    let mut times: Vec<Duration> = (0..200)
        .map(|_| {
            let start = Instant::now();
            let first = rng.random_range(0..shadow.ticks() - 1001);
            let mut flight = shadow.flight(first, shadow.tuning()).expect("inside");
            (0..1001).for_each(|_| drop(flight.tick()));
            start.elapsed()
        })
        .collect();
    times.sort();
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let memory = status.lines().find(|line| line.starts_with("VmHWM")).unwrap_or("VmHWM: unknown");
    eprintln!(
        "{} ticks, {bytes} bytes: opened in {started:?}, seek p50 {:?}, p99 {:?}, {memory}",
        shadow.ticks(),
        times[100],
        times[197]
    );
    assert!(shadow.ticks() > 359_000, "{}", shadow.ticks());
}
