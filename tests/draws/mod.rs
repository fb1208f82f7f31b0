//! A scenario fuzzer: every key of the format gets values within its range, corners, zeros and extremes among them. Whatever the values, a
//! flight must end with a verdict, or the program must refuse the scenario in words.
//!
//! `TWIN_DRAWS=20000 cargo test --release --test suite draws` flies that many; `TWIN_DRAW=417` flies one again.

mod draw;
mod flown;
mod values;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

use draw::Draw;
use flown::{Folder, Outcome, fly, run_program};

/// Draws of one test run: about a minute on two cores.
const DRAWS: u64 = 300;

/// Of so many draws one also runs in the real program, for its exit code.
const PROGRAM_EVERY: u64 = 10;

/// At most so many failures are made small and printed.
const SHOWN: usize = 10;

/// The draws that the environment asks for, or the usual ones.
fn wanted() -> Vec<u64> {
    let number = |name| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    match number("TWIN_DRAW") {
        Some(one) => vec![one],
        None => (1..=number("TWIN_DRAWS").unwrap_or(DRAWS)).collect(),
    }
}

/// The keys of a failing draw that it needs to fail, as arguments of `twin fly`.
fn smallest(folder: &Folder, draw: &Draw, failed: &Outcome) -> String {
    let mut draw = draw.clone();
    let mut index = 0;
    while index < draw.keys.len() {
        let mut less = draw.clone();
        less.keys.remove(index);
        if fly(folder, &less).kind() == failed.kind() {
            draw = less;
        } else {
            index += 1;
        }
    }
    let set = draw.keys.iter().map(|(key, value)| format!("--set '{key}={value}'"));
    set.collect::<Vec<_>>().join(" ")
}

/// The key that a refusal names, or its beginning.
fn refused_key(words: &str) -> String {
    let key = words.split(": ").find(|part| !part.contains(['/', ' ']));
    key.map_or_else(|| words.chars().take(60).collect(), str::to_owned)
}

#[test]
fn any_scenario_within_the_ranges_ends_with_a_verdict_or_is_refused_in_words() {
    let folder = Folder::new(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("draws"));
    let (failures, flown) = (Mutex::new(Vec::new()), Mutex::new(0_u64));
    let refused = Mutex::new(BTreeMap::<String, u64>::new());
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(flown::remember_panic));
    let one = |number: u64| {
        let draw = Draw::new(number);
        let mut outcome = fly(&folder, &draw);
        if number.is_multiple_of(PROGRAM_EVERY) && !outcome.is_failure() {
            outcome = run_program(&folder, &draw, &outcome);
        }
        if let Outcome::Refused(words) = &outcome {
            let mut refused = refused.lock().expect("no draw panics here");
            *refused.entry(refused_key(words)).or_default() += 1;
        } else if outcome.is_failure() {
            let small = smallest(&folder, &draw, &outcome);
            let mut failures = failures.lock().expect("no draw panics here");
            failures.push(format!("draw {number}: {outcome}\n    {small}"));
        } else {
            *flown.lock().expect("no draw panics here") += 1;
        }
    };
    let numbers = wanted();
    std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        for first in 0..threads {
            let (numbers, one) = (&numbers, &one);
            scope.spawn(move || numbers.iter().skip(first).step_by(threads).for_each(|n| one(*n)));
        }
    });
    std::panic::set_hook(hook);
    let failures = failures.into_inner().expect("every thread has ended");
    let flown = flown.into_inner().expect("every thread has ended");
    let refused = refused.into_inner().expect("every thread has ended");
    println!("{flown} flown, {} failed, refused by key: {refused:?}", failures.len());
    let shown = failures.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join("\n");
    assert!(failures.is_empty(), "{} of {} draws:\n{shown}", failures.len(), numbers.len());
    // A fuzzer whose scenarios are nearly all refused would show nothing.
    assert!(
        numbers.len() < 100 || flown * 2 > numbers.len() as u64,
        "{flown} flown, refused by key: {refused:?}"
    );
}
