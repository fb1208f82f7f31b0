//! Messages by a valid definition, as CDR and as ULog. `cargo +nightly fuzz run --fuzz-dir tests/fuzz message`
#![no_main]

#[allow(dead_code)]
#[path = "../../mirror/fuzzed.rs"]
mod fuzzed;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    fuzzed::of_definition(bytes);
});
