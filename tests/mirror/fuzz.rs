//! Seeded damage: `TWIN_FUZZ_INPUTS=10000000 TWIN_FUZZ_SEED=1` asks for more inputs. A hang shows as a run that does not end. The same
//! bodies are targets of cargo-fuzz in `tests/fuzz`.

use rand::{RngExt, SeedableRng};
use twin_foreign::topics::SHIPPED;

use super::damage::mutate;
use super::fuzzed;
use super::made::{Form, PLAIN, flight, ulog};

/// Number of inputs without `TWIN_FUZZ_INPUTS`.
const FEW: u64 = 200_000;

/// A flight of some twenty messages in several chunks.
const TINY: Form = Form { seconds: 0.05, chunk_bytes: 256, compression: None, ..PLAIN };

/// The same flight with a hole, which makes it a long flight.
const LONG: Form = Form { seconds: 150.0, hole_s: Some((0.05, 149.95)), ..TINY };

fn asked(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn damaged_files_messages_definitions_and_maps_never_panic_or_hang() {
    let (inputs, seed) = (asked("TWIN_FUZZ_INPUTS", FEW), asked("TWIN_FUZZ_SEED", 7));
    let packed = Some(mcap::Compression::Lz4);
    let files = [flight(TINY), flight(Form { compression: packed, ..TINY }), ulog()];
    let long = [flight(LONG), flight(Form { compression: packed, ..LONG })];
    let message = fuzzed::message();
    let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
    let (mut read, mut indexed) = (0_u64, 0_u64);
    for i in 0..inputs {
        match i % 10 {
            0..2 => {
                let whole = &files[rng.random_range(0..files.len())];
                read += u64::from(fuzzed::file(&mutate(whole, &mut rng)));
            }
            2..4 => {
                let whole = &long[rng.random_range(0..long.len())];
                indexed += u64::from(fuzzed::indexed(&mutate(whole, &mut rng)));
            }
            4..6 => fuzzed::of_definition(&mutate(&message, &mut rng)),
            6..9 => fuzzed::definition(&mutate(fuzzed::DEFINITION.as_bytes(), &mut rng)),
            _ => {
                let (_, text) = SHIPPED[rng.random_range(0..SHIPPED.len())];
                fuzzed::map(&mutate(text.as_bytes(), &mut rng));
            }
        }
    }
    // Damage seldom hits the first bytes. So most files can be read, and many of them are still recognised as long.
    assert!(read > inputs / 10 && indexed > inputs / 20, "{read}, {indexed} of {inputs}");
    if inputs > FEW {
        eprintln!("{inputs} damaged inputs of seed {seed}: no panic, no hang");
    }
}

#[test]
fn a_file_cut_at_every_byte_is_read_as_far_as_it_goes_by_every_way() {
    for whole in [flight(TINY), flight(LONG), ulog()] {
        let longest = (0..=whole.len())
            .filter(|end| fuzzed::file(&whole[..*end]) | fuzzed::indexed(&whole[..*end]))
            .count();
        // A file can be read at every length, except when its first bytes, which name its kind, are missing.
        assert!(longest + 16 > whole.len(), "{longest} of {}", whole.len());
    }
}
