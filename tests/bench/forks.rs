//! What a copy of a flight costs, and how fast a fork flies.
//!
//! `cargo bench --features train --bench forks` prints for each scenario: the time of a copy, the memory of a copy (growth of the process
//! over many copies), and the time of 10 s of a fork on one core.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a bench measures wall-clock time"
)]

use std::path::Path;
use std::time::Instant;

use twin_core::flight::Flight;
use twin_scenario::Scenario;

/// Copies whose memory is measured together.
const COPIES: usize = 200;

/// Ticks before the first copy: the history of the predictor is full, and the vehicle is in contact with nothing.
const BEFORE: u64 = 500;

/// Ticks of a fork that is timed: 10 s.
const FORK_TICKS: u64 = 1000;

/// Bytes of a page of memory on the platforms that have `/proc/self/statm`.
const PAGE_BYTES: usize = 4096;

/// Scenario and overrides.
const FLIGHTS: [(&str, &[&str]); 4] = [
    ("hover", &["task.duration_s=60"]),
    ("a_300g_slow", &[]),
    ("a_300g_slow", &["predictor.kind=random_features"]),
    ("free_flight", &[]),
];

/// Resident memory of this process, bytes; 0 where the system does not tell.
fn resident() -> usize {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text.split(' ').nth(1).and_then(|pages| pages.parse::<usize>().ok());
    pages.unwrap_or(0) * PAGE_BYTES
}

fn main() {
    println!("{:42} {:>8} {:>9} {:>12}", "flight", "copy ms", "copy kB", "10 s fork, s");
    for (name, keys) in FLIGHTS {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{name}.toml"));
        let overrides: Vec<String> = keys.iter().map(|key| (*key).to_owned()).collect();
        let mut flight = Scenario::load(&file, &overrides).unwrap().build().unwrap();
        (0..BEFORE).for_each(|_| drop(flight.tick()));
        let (before, start) = (resident(), Instant::now());
        let copies: Vec<Flight> = (0..COPIES).map(|_| flight.clone()).collect();
        let copy_ms = start.elapsed().as_secs_f64() * 1e3 / COPIES as f64;
        let copy_kb = resident().saturating_sub(before) as f64 / 1e3 / COPIES as f64;
        drop(copies);
        let mut fork = flight.clone();
        let start = Instant::now();
        (0..FORK_TICKS).for_each(|_| drop(fork.tick()));
        let fork_s = start.elapsed().as_secs_f64();
        println!(
            "{:42} {copy_ms:8.3} {copy_kb:9.0} {fork_s:12.3}",
            format!("{name} {}", keys.join(" "))
        );
    }
}
