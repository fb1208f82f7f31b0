//! Long MCAP files, read part by part through their index. `cargo +nightly fuzz run --fuzz-dir tests/fuzz indexed`
#![no_main]

#[allow(dead_code)]
#[path = "../../mirror/fuzzed.rs"]
mod fuzzed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = fuzzed::indexed(bytes);
});
