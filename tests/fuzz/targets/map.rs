//! Topic maps. `cargo +nightly fuzz run --fuzz-dir tests/fuzz map`
#![no_main]

#[allow(dead_code)]
#[path = "../../mirror/fuzzed.rs"]
mod fuzzed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzzed::map(bytes);
});
