//! `kill -9` at any instant costs at most half a second of a recording.

use super::disk::address;
use super::*;

/// Ticks of half a second, which is the longest time that a chunk stays open, and of the time that a loaded machine may take for a write
/// and for the answer about the newest tick.
const MOST_LOST: u64 = 50 + 25;

/// Ticks at which the program is killed; primes, so that they meet every phase of a chunk.
const INSTANTS: [u64; 4] = [67, 131, 181, 239];

#[test]
fn kill_9_loses_at_most_half_a_second() {
    let folder = Folder::new("killed");
    for instant in INSTANTS {
        let (path, whole) = (
            folder.path(&format!("{instant}.mcap")),
            folder.path(&format!("{instant}-whole.mcap")),
        );
        let record = path.display().to_string();
        let mut child = start(&["fly", "scenarios/hover.toml", "--port", "0", "--record", &record]);
        // It stays open: a program whose messages cannot be written may end by itself.
        let mut said = std::io::BufReader::new(child.stderr.take().expect("its messages"));
        let address = address(&mut said);
        let mut flown = 0;
        until("the instant", || {
            let state = crate::server::console::api(address, "/api/state");
            flown = state["tick"].as_u64().unwrap_or(0);
            flown >= instant
        });
        child.kill().expect("it is killed");
        child.wait().expect("it is dead");
        let salvage = command(&["recover", &record, "-o", &whole.display().to_string()])
            .output()
            .expect("it ends");
        assert_eq!(salvage.status.code(), Some(0), "{salvage:?}");
        let read = twin_record::read_recording(&whole).expect("a recording").ticks.len() as u64;
        let lost = flown.saturating_sub(read);
        println!("killed after {flown} ticks: {read} salvaged, {lost} lost");
        assert!(lost <= MOST_LOST, "killed after {flown} ticks: {read} salvaged, {lost} lost");
    }
}
