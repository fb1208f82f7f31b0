//! What a fork changes, and that a scenario repeats it. The oracle is always a flight from the first tick on: a fork of a copy must end as
//! the scenario does whose keys change at the same time.

use std::collections::BTreeMap;

use twin_core::tick::{EventKind, Tick};
use twin_scenario::fork::{Fork, ForkError, Forked, MOST_FORKS, Order, fly_forked, plans};
use twin_scenario::{Judgement, Scenario, Verdict, fly};

/// Time of the forks, s. It is no multiple of a tick, so the fork begins with the tick after it.
const AT_S: f64 = 2.503;

/// The first tick of the forks: 251 · 0.01 s is the first time at or after [`AT_S`].
const FIRST: u64 = 251;

/// The keys of a hover of 5 s with a payload.
const HOVER: [&str; 3] = ["task.duration_s=5.0", "task.start=grasped", "payload.mass_kg=0.2"];

fn hover(more: &[&str]) -> Scenario {
    let keys: Vec<String> = HOVER.iter().chain(more).map(|key| (*key).to_owned()).collect();
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/hover.toml");
    Scenario::load(std::path::Path::new(file), &keys).expect("it loads")
}

fn order(at_s: f64, set: &[&str]) -> Order {
    Order { at_s, set: set.iter().map(|key| (*key).to_owned()).collect() }
}

/// Flies `scenario` with its forks; the ticks of each flight by its number.
fn forked(
    scenario: &Scenario,
    orders: &[Order],
) -> Result<(Forked, BTreeMap<usize, Vec<Tick>>), ForkError> {
    let mut ticks: BTreeMap<usize, Vec<Tick>> = BTreeMap::new();
    let flown = fly_forked(scenario, plans(scenario, orders)?, &mut |flights, tick| {
        for flight in flights {
            ticks.entry(*flight).or_default().push(tick.clone());
        }
    })?;
    Ok((flown, ticks))
}

/// The fork of a hover with these keys, and the ticks of the hover and of the fork.
fn fork(set: &[&str]) -> (Fork, [Vec<Tick>; 2]) {
    let (mut flown, mut ticks) = forked(&hover(&[]), &[order(AT_S, set)]).expect("it is allowed");
    let ticks = [0, 1].map(|flight| ticks.remove(&flight).expect("it flew"));
    (flown.forks.remove(0), ticks)
}

/// Kind of an event, and a part of its sentence.
type Sentence<'a> = Option<(EventKind, &'a str)>;

/// The sentences of a tick's events.
fn said(tick: &Tick) -> Vec<(EventKind, &str)> {
    tick.events.iter().map(|event| (event.kind, event.text.as_str())).collect()
}

#[test]
fn an_unchanged_fork_is_the_flight_itself_and_has_no_difference() {
    let scenario = hover(&[
        "changes=[{at_s=1.0,set=[\"gains.leak=1.5\"]},{at_s=4.0,set=[\"gains.leak=1.8\"]}]",
        // A demand on the flight is none on its fork, and no difference either.
        "bounds={flight_s={min=1.0}}",
    ]);
    let (flown, ticks) =
        forked(&scenario, &[order(AT_S, &[]), order(0.0, &[])]).expect("it is allowed");
    for (number, fork) in (1..).zip(&flown.forks) {
        assert_eq!(fork.report.state_hash, flown.parent.state_hash);
        assert!(ticks[&number] == ticks[&0], "fork {number}");
        assert!(fork.changed.is_empty());
        assert!(fork.rows.iter().all(|row| row.judgement == Judgement::Equal), "{:?}", fork.rows);
    }
}

#[test]
fn each_kind_of_change_acts_from_the_first_tick_after_the_fork_and_is_repeated_by_a_scenario() {
    let fault = "faults=[{kind=\"motor_efficiency\",at_s=3.0,rotor=1,factor=0.85}]";
    let disturbance = "disturbances=[{kind=\"push\",at_s=3.0,force_n=[3,0,0],duration_s=0.3}]";
    // The keys, and the sentence that begins the fork; a fault speaks later.
    let kinds: [(&[&str], Sentence); 10] = [
        (&["gains.preset=paper"], Some((EventKind::Gain, "->"))),
        (&["gains.adapter_on=0"], Some((EventKind::Gain, "LRA (adapter_on) 1 -> 0"))),
        (
            &["predictor.kind=persistence"],
            Some((EventKind::Gain, "predictor random_features -> persistence")),
        ),
        (&["predictor.kind=fdt", "predictor.kernel=scalar"], Some((EventKind::Gain, "-> fdt"))),
        (&["controller.kind=pid"], Some((EventKind::Gain, "controller adaptive -> pid"))),
        (&["payload.mass_kg=0.35"], Some((EventKind::Disturbance, "payload is now 350 g"))),
        (
            &["wind.velocity_m_s=[2,0,0]"],
            Some((EventKind::Disturbance, "wind is now [2.0 0.0 0.0] m/s")),
        ),
        (&["aero.downwash=false"], Some((EventKind::Disturbance, "downwash switched off"))),
        (&[fault], None),
        (&[disturbance], None),
    ];
    for (set, sentence) in kinds {
        let (fork, [parent, ticks]) = fork(set);
        let before = FIRST as usize;
        assert!(ticks[..before] == parent[..before], "{set:?}: the past changed");
        assert_ne!(fork.report.state_hash, String::new());
        assert!(ticks[before..] != parent[before..], "{set:?} changed nothing");
        assert!(!fork.changed.is_empty(), "{set:?}");
        if let Some((kind, text)) = sentence {
            let said = said(&ticks[before]);
            assert!(
                said.iter().any(|told| told.0 == kind && told.1.contains(text)),
                "{set:?}: {said:?}"
            );
        }
        let again = fly(&fork.scenario, &mut |_| {}).expect("it builds");
        assert_eq!(
            again.state_hash, fork.report.state_hash,
            "{set:?}: the scenario flies another flight"
        );
        assert!(again.passed, "{set:?}: it expects the verdict of the fork, {:?}", again.broken);
    }
}

#[test]
fn only_the_gains_that_a_fork_names_change() {
    let (fork, [_, ticks]) = fork(&["gains.leak=1.25"]);
    let keys: Vec<&str> = fork.changed.iter().map(|difference| difference.key.as_str()).collect();
    assert_eq!(keys, ["gains.leak"]);
    assert_eq!(said(&ticks[FIRST as usize]), [(EventKind::Gain, "ν (leak) 2 -> 1.25")]);
}

#[test]
fn a_fork_of_a_scenario_with_changes_keeps_those_of_later() {
    let scenario = hover(&["changes=[{at_s=4.0,set=[\"gains.leak=1.8\"]}]"]);
    let (flown, ticks) =
        forked(&scenario, &[order(AT_S, &["payload.mass_kg=0.3"])]).expect("it is allowed");
    assert_eq!(said(&ticks[&1][400]), [(EventKind::Gain, "ν (leak) 2 -> 1.8")]);
    let again = fly(&flown.forks[0].scenario, &mut |_| {}).expect("it builds");
    assert_eq!(again.state_hash, flown.forks[0].report.state_hash);
}

#[test]
fn a_change_that_a_flight_in_the_air_cannot_make_is_refused_with_what_can() {
    let refusals = [
        ("seed=7", "seed: 1 -> 7 cannot change in the air; gains.*, predictor.*"),
        ("task.duration_s=9.0", "task.duration_s: 5.0 -> 9.0 cannot change"),
        ("vehicle.urdf=other.urdf", "vehicle.urdf"),
        ("gains.leak=-1", "gains.leak: found -1"),
        ("gains.leek=1", "did you mean gains.leak?"),
        ("payload.mass_kg=0", "payload.mass_kg: found 0"),
        ("predictor.kind=oracle", "rehearses whole flights"),
        ("predictor.weights=missing.safetensors", "cannot change"),
        (
            "faults=[{kind=\"predictor_nan\",at_s=3.0,duration_s=0.1}]",
            "predictor_nan is built into the predictor",
        ),
        (
            "disturbances=[{kind=\"drop_payload\",at_s=1.0}]",
            "at_s = 1 is before the change at 2.503 s",
        ),
        ("nonsense", "expected key=value"),
    ];
    for (key, wanted) in refusals {
        let set: Vec<&str> =
            if key.starts_with("predictor.weights") { vec![key, "seed=3"] } else { vec![key] };
        let error = plans(&hover(&[]), &[order(AT_S, &set)]).err().expect(key).to_string();
        assert!(error.contains(wanted) && error.contains("2.503 s"), "{key}: {error}");
    }
}

#[test]
fn forks_at_no_time_of_the_flight_and_seven_at_once_are_refused() {
    let error = |orders: &[Order]| forked(&hover(&[]), orders).expect_err("refused").to_string();
    for at_s in [-1.0, f64::NAN] {
        assert!(error(&[order(at_s, &[])]).contains("a flight begins at 0 s"));
    }
    let late = error(&[order(AT_S, &[]), order(6.0, &[])]);
    assert!(
        late.contains("fork at 6 s: the flight ended at 5.0") && late.contains("choose an earlier"),
        "{late}"
    );
    let many = vec![order(1.0, &[]); MOST_FORKS + 1];
    assert!(error(&many).contains("7 forks asked for, at most 6"));
}

#[test]
fn a_flight_that_crashed_is_forked_before_the_crash_and_refused_after_it() {
    // A rotor that gives nothing ends the flight; the fork at which it is repaired does not exist, so the fork crashes, too.
    let scenario = hover(&["faults=[{kind=\"motor_efficiency\",at_s=2.0,rotor=1,factor=0.0}]"]);
    let (flown, _) = forked(&scenario, &[order(1.0, &["gains.leak=1.5"])]).expect("it is allowed");
    assert!(
        matches!(flown.parent.verdict, Verdict::Crashed | Verdict::FlewAway),
        "{:?}",
        flown.parent
    );
    assert_eq!(flown.forks[0].report.verdict, flown.parent.verdict);
    let error = forked(&scenario, &[order(4.5, &[])]).expect_err("refused").to_string();
    assert!(error.contains(&flown.parent.reason), "{error}");
}
