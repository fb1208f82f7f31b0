//! A copy of a flight flies on as the original does: to the same state hash and the same last tick, wherever it was made.
//!
//! `TWIN_DRAWS=100 cargo test --release --test suite copied::missions -- --ignored --nocapture` copies the eight missions at that many
//! instants; without the variable it takes [`MISSION_INSTANTS`].

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use twin_core::flight::Flight;
use twin_core::flight::snapshots::{Change, SnapshotError, Snapshots};
use twin_core::source::Disturbance;
use twin_core::tick::Tick;
use twin_scenario::Scenario;

use super::flown::{flown, scenario};

/// Instants at which each of [`CASES`] is copied.
const INSTANTS: u64 = 3;

/// Instants of all missions together in the large draw.
const MISSION_INSTANTS: u64 = 16;

/// Seed of the instants.
const SEED: u64 = 0xf0_4b;

/// The eight missions of the paper.
const MISSIONS: [&str; 8] = [
    "a_300g_fast",
    "a_300g_slow",
    "a_500g_fast",
    "a_500g_slow",
    "b_300g_fast",
    "b_300g_slow",
    "b_500g_fast",
    "b_500g_slow",
];

/// Scenarios that use every kind of state: name and keys.
const CASES: [(&str, &[&str]); 12] = [
    ("hover", &["task.duration_s=4.0"]),
    ("hover", &["task.duration_s=4.0", "controller.kind=pid", "controller.outer_divisor=2"]),
    ("hover", &["task.duration_s=4.0", "controller.kind=l1", "controller.multisine.tones=4"]),
    ("hover", &["task.duration_s=4.0", "predictor.kind=persistence"]),
    ("hover", &["task.duration_s=4.0", "predictor.kind=arx_rls", "sensors.mocap_link.on=true"]),
    ("hover", &["task.duration_s=4.0", "predictor.kind=fdt", "predictor.kernel=scalar"]),
    (
        "hover",
        &["task.duration_s=4.0", "task.start=grasped", "payload.mass_kg=0.3", "wind.kind=dryden"],
    ),
    (
        "hover",
        &[
            "task.duration_s=4.0",
            "vehicle.link.on=true",
            "vehicle.mismatch.on=true",
            "vehicle.battery.on=true",
        ],
    ),
    ("free_flight", &["time_limit_s=6.0", "predictor.kind=random_features"]),
    ("gusts", &["time_limit_s=6.0"]),
    ("fault_predictor_nan", &["time_limit_s=8.0"]),
    ("reset_demo", &[]),
];

/// Copies the flight of `scenario` directly before each tick of `instants`, flies the copies to where the original ended, and compares.
fn check(scenario: &Scenario, instants: impl Fn(u64) -> Vec<u64>) {
    // The oracle is a flight that nobody copied.
    let (report, ticks) = flown(scenario);
    let last = ticks.last().expect("it flew");
    let chosen = instants(last.index);
    let mut flight = scenario.build().expect("it builds");
    let mut copies = Vec::new();
    while flight.index() <= last.index {
        if chosen.contains(&flight.index()) {
            copies.push(flight.clone());
        }
        flight.tick();
    }
    assert_eq!(
        hash(&flight),
        report.state_hash,
        "{}: a copy disturbed the original",
        scenario.name
    );
    for copy in copies {
        let at = copy.index();
        let (copy, end) = flown_to(copy, last.index);
        let place = format!("{} copied before tick {at} of {}", scenario.name, last.index);
        assert_eq!(hash(&copy), report.state_hash, "{place}");
        assert!(end == *last, "{place}: the hashes are equal but the last tick is not");
    }
}

/// Flies up to and with the tick `last`.
fn flown_to(mut flight: Flight, last: u64) -> (Flight, Tick) {
    let mut tick = flight.tick();
    while tick.index < last {
        tick = flight.tick();
    }
    (flight, tick)
}

fn hash(flight: &Flight) -> String {
    format!("{:016x}", flight.state_hash())
}

#[test]
fn a_copy_ends_with_the_hash_of_its_original_whatever_is_flown() {
    let mut rng = Pcg64::seed_from_u64(SEED);
    for (name, keys) in CASES {
        let shares: Vec<f64> = (0..INSTANTS).map(|_| rng.random()).collect();
        check(&scenario(name, keys), |last| {
            shares.iter().map(|s| (s * last as f64) as u64).collect()
        });
    }
}

#[test]
#[ignore = "flies the eight missions once for each instant; the head of this file has the command"]
fn missions_copied_at_random_instants_end_as_they_would_have() {
    let asked = std::env::var("TWIN_DRAWS").ok().and_then(|text| text.parse().ok());
    let count = asked.unwrap_or(MISSION_INSTANTS);
    let mut rng = Pcg64::seed_from_u64(SEED);
    let shares: Vec<f64> = (0..count).map(|_| rng.random()).collect();
    for (index, name) in MISSIONS.iter().enumerate() {
        let own: Vec<f64> = shares.iter().skip(index).step_by(MISSIONS.len()).copied().collect();
        check(&scenario(name, &[]), |last| own.iter().map(|s| (s * last as f64) as u64).collect());
        println!("{name}: {} copies ended with the hash of the original", own.len());
    }
}

/// Ticks of the operated flight.
const OPERATED_TICKS: u64 = 600;

/// What an operator asks of the flight before `tick`: a dragged gain, a push that is repeated, another push, a heavier payload.
fn asked(flight: &Flight, tick: u64) -> Vec<Change> {
    let push = || Disturbance::Push { force_n: [2.0, 0.0, 0.0], duration_s: 0.2 };
    let mut all = Vec::new();
    if (130..170).contains(&tick) {
        let mut tuning = *flight.tuning();
        tuning.set("slope.x", 1.0 + (tick - 130) as f64 * 0.01).expect("it is in range");
        all.push(Change::Tuning(Box::new(tuning)));
    }
    match tick {
        150 | 300 => all.push(Change::Disturb(push())),
        151 => all.push(Change::Prolong(push())),
        450 => all.push(Change::Disturb(Disturbance::PayloadMass { kg: 0.3 })),
        _ => {}
    }
    all
}

/// The operated flight directly before the tick `to`, after the changes for that tick.
fn operated(to: u64, snapshots: &mut Snapshots) -> Flight {
    let keys = ["task.start=grasped", "payload.mass_kg=0.2"];
    let mut flight = scenario("hover", &keys).build().expect("it builds");
    loop {
        let tick = flight.index();
        for change in asked(&flight, tick) {
            match &change {
                Change::Tuning(tuning) => flight.set_tuning(**tuning),
                Change::Disturb(disturbance) => flight.disturb(disturbance),
                Change::Prolong(disturbance) => flight.prolong(disturbance),
            }
            snapshots.changed(tick, change);
        }
        if tick == to {
            return flight;
        }
        snapshots.before_tick(tick, || flight.clone());
        flight.tick();
    }
}

#[test]
fn any_moment_is_rebuilt_with_all_that_was_asked_of_the_flight_before_it() {
    let mut snapshots = Snapshots::default();
    operated(OPERATED_TICKS, &mut snapshots);
    assert_eq!(snapshots.len(), 6, "one copy per second");
    for tick in [0, 99, 100, 135, 150, 151, 152, 169, 170, 200, 301, 450, 451, 599] {
        let rebuilt = snapshots.at(tick).expect("it is in memory");
        // The oracle flew there from its first tick, and was never copied back.
        let flown = operated(tick, &mut Snapshots::default());
        assert_eq!(rebuilt.tuning(), flown.tuning(), "at tick {tick}");
        let (rebuilt, flown) = (flown_to(rebuilt, tick + 60), flown_to(flown, tick + 60));
        assert_eq!(hash(&rebuilt.0), hash(&flown.0), "60 ticks after tick {tick}");
        assert!(rebuilt.1 == flown.1, "60 ticks after tick {tick}");
    }
}

#[test]
fn the_memory_is_bounded_and_what_it_cannot_give_is_said() {
    let refusal = |snapshots: &Snapshots, tick| snapshots.at(tick).err().expect("it is refused");
    assert_eq!(refusal(&Snapshots::default(), 0), SnapshotError::Empty);
    let mut snapshots = Snapshots::with_room(3);
    operated(OPERATED_TICKS, &mut snapshots);
    assert_eq!(snapshots.len(), 3);
    assert_eq!(snapshots.ticks(), Some(300..=599));
    assert_eq!(refusal(&snapshots, 299), SnapshotError::TooOld { asked: 299, oldest: 300 });
    assert_eq!(refusal(&snapshots, 600), SnapshotError::NotFlown { asked: 600, newest: 599 });
}
