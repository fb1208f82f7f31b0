//! Message definitions, ROS 2 and ULog. `cargo +nightly fuzz run --fuzz-dir tests/fuzz definition`
#![no_main]

#[allow(dead_code)]
#[path = "../../mirror/fuzzed.rs"]
mod fuzzed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzzed::definition(bytes);
});
