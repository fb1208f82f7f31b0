//! MCAP and ULog files, read from start to end and put onto ticks. `cargo +nightly fuzz run --fuzz-dir tests/fuzz file`
#![no_main]

#[allow(dead_code)]
#[path = "../../mirror/fuzzed.rs"]
mod fuzzed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = fuzzed::file(bytes);
});
