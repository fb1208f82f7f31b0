//! Scenario files over defaults, and the messages for broken ones.

use proptest::prelude::*;
use serde::Deserialize;

use super::*;

const DEFAULTS: &str = r#"
seed = 1
time_limit_s = 120.0
[payload]
mass_kg = 0.3
size_m = 0.05
[task]
kind = "pick_place"
speed_m_s = 1.0
[wind]
velocity_m_s = [0.0, 0.0, 0.0]
[[vehicle.rotors]]
position_m = [0.23, 0.23, 0.04]
spin = "ccw"
[faults]
list = []
[bounds]
[example.gains]
leak = 1.0
slope = [1.0]
[[example.faults.list]]
kind = "rotor"
at_s = 1.0
[example.bounds."*"]
max = 1.0
"#;

#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Scenario {
    seed: u64,
    time_limit_s: f64,
    payload: Payload,
    task: Task,
    wind: Wind,
    vehicle: Vehicle,
    faults: Faults,
    #[serde(default)]
    gains: Gains,
    bounds: std::collections::BTreeMap<String, Bound>,
}
#[derive(Debug, Deserialize, PartialEq)]
struct Payload {
    mass_kg: f64,
    size_m: f64,
}
#[derive(Debug, Deserialize, PartialEq)]
struct Task {
    kind: Kind,
    speed_m_s: f64,
}
#[derive(Debug, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
enum Kind {
    PickPlace,
    SCurve,
}
#[derive(Debug, Deserialize, PartialEq)]
struct Wind {
    velocity_m_s: [f64; 3],
}
#[derive(Debug, Deserialize, PartialEq)]
struct Vehicle {
    rotors: Vec<Rotor>,
}
#[derive(Debug, Deserialize, PartialEq)]
struct Rotor {
    position_m: [f64; 3],
    spin: String,
}
#[derive(Debug, Deserialize, PartialEq)]
struct Faults {
    list: Vec<Fault>,
}
#[derive(Debug, Deserialize, PartialEq)]
struct Fault {
    kind: String,
    at_s: f64,
}
#[derive(Debug, Default, Deserialize, PartialEq)]
#[serde(default)]
struct Gains {
    leak: Option<f64>,
    slope: Option<Vec<f64>>,
}
#[derive(Debug, Deserialize, PartialEq)]
struct Bound {
    max: f64,
}

fn read(text: &str, overrides: &[&str]) -> Result<Scenario, ScenarioError> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    read_text(text, Path::new("scenarios/test.toml"), DEFAULTS, &overrides)
}

/// The whole message of a refusal.
fn refused(text: &str, overrides: &[&str]) -> String {
    let error = read(text, overrides).expect_err(text).to_string();
    assert!(!error.ends_with('.') && !error.ends_with(' '), "{error}");
    error
}

#[test]
fn an_empty_file_is_the_defaults() {
    let scenario = read("", &[]).unwrap();
    let mut alone: toml::Table = DEFAULTS.parse().unwrap();
    alone.remove("example");
    assert_eq!(scenario, alone.try_into().unwrap());
}

#[test]
fn the_file_goes_over_the_defaults_and_overrides_over_both() {
    let text = "time_limit_s = 60\n[payload]\nmass_kg = 0.5\nsize_m = 0.04\n";
    let overrides = ["payload.mass_kg=0.2", "task.kind=s_curve", "wind.velocity_m_s=[1, 0, 2.5]"];
    let scenario = read(text, &overrides).unwrap();
    assert_eq!(scenario.payload, Payload { mass_kg: 0.2, size_m: 0.04 });
    assert_eq!(scenario.task, Task { kind: Kind::SCurve, speed_m_s: 1.0 });
    assert_eq!(scenario.wind, Wind { velocity_m_s: [1.0, 0.0, 2.5] });
    assert_eq!((scenario.seed, scenario.time_limit_s as i64), (1, 60));
}

#[test]
fn keys_of_the_example_may_be_given_and_are_no_default() {
    let text = "gains.leak = 2\n[[faults.list]]\nkind = \"rotor\"\nat_s = 3\n[bounds.grasp_slip_mm]\nmax = 2\n";
    let scenario = read(text, &["faults.list.0.at_s=4"]).unwrap();
    assert_eq!(scenario.gains, Gains { leak: Some(2.0), slope: None });
    assert_eq!(scenario.faults.list, [Fault { kind: "rotor".into(), at_s: 4.0 }]);
    assert_eq!(scenario.bounds["grasp_slip_mm"], Bound { max: 2.0 });
}

#[test]
fn a_list_of_tables_is_replaced_as_a_whole() {
    let rotor = "[[vehicle.rotors]]\nposition_m = [1, 2, 3]\nspin = \"cw\"\n";
    assert_eq!(read(&rotor.repeat(2), &[]).unwrap().vehicle.rotors.len(), 2);
}

#[test]
fn messages_name_place_key_finding_and_remedy() {
    for (text, message) in [
        (
            "\n[payload]\nmass_kg = 300\n",
            "scenarios/test.toml:3: payload.mass_kg: found 300; expected 0 or 0.001..=2 kg; 300 looks like grams, write 0.3",
        ),
        (
            "[payload]\nmas_kg = 0.3",
            "scenarios/test.toml:2: payload.mas_kg: found an unknown key; expected one of mass_kg, size_m; did you mean payload.mass_kg?",
        ),
        (
            "speed_m_s = 1.0",
            "scenarios/test.toml:1: speed_m_s: found an unknown key; expected one of bounds, faults, gains, payload, seed, task, time_limit_s, vehicle, wind; did you mean task.speed_m_s?",
        ),
        (
            "time_limit_s = \"long\"",
            "scenarios/test.toml:1: time_limit_s: found the text \"long\"; expected a number",
        ),
        (
            "seed = 1.5",
            "scenarios/test.toml:1: seed: found the number 1.5; expected a whole number",
        ),
        (
            "payload = 3",
            "scenarios/test.toml:1: payload: found the whole number 3; expected a table",
        ),
        (
            "wind.velocity_m_s = [0.0,\n nan, 0.0]",
            "scenarios/test.toml:2: wind.velocity_m_s[1]: found NaN; expected a finite number",
        ),
        (
            "wind.velocity_m_s = [0.0, \"a\", 0.0]",
            "scenarios/test.toml:1: wind.velocity_m_s[1]: found the text \"a\"; expected a number",
        ),
        (
            "task.kind = \"pick\"",
            "scenarios/test.toml:1: task.kind: unknown variant `pick`, expected `pick_place` or `s_curve`; compare with defaults.toml",
        ),
    ] {
        assert_eq!(refused(text, &[]), message);
    }
}

#[test]
fn more_is_refused() {
    for (text, words) in [
        ("[payload\n", "scenarios/test.toml:1: not TOML: "),
        ("seed = 1\nseed = 2\n", "scenarios/test.toml:2: not TOML: "),
        ("time_limit_s = inf\n", "test.toml:1: time_limit_s: found inf"),
        ("time_limit_s = 1e400\n", "test.toml:1: "),
        ("seed = 99999999999999999999\n", "test.toml:1: "),
        ("seed = -1\n", "test.toml:1: seed: found -1; expected 0"),
        ("seed = 1979-05-27\n", "test.toml:1: seed: found the date 1979-05-27"),
        ("wind.velocity_m_s = [1.0]\n", "test.toml:1: wind.velocity_m_s: invalid length 1"),
        (
            "[[faults.list]]\nkind = \"a\"\nat = 3\n",
            "test.toml:3: faults.list[0].at: found an unknown key",
        ),
        ("[[faults.list]]\nkind = \"a\"\n", "test.toml:1: faults.list[0]: missing field `at_s`"),
        ("[bounds.a]\nmin = 1.0\n", "test.toml:2: bounds.a.min: found an unknown key"),
        ("[example]\n", "test.toml:1: example: found an unknown key"),
        ("gains.slope = [1.0, -3.0]", "test.toml:1: gains.slope[1]: found -3; expected 0..=20 1/s"),
    ] {
        let error = refused(text, &[]);
        assert!(error.contains(words), "{words}\n{error}");
    }
}

#[test]
fn overrides_are_named_by_their_text() {
    for (text, words) in [
        (
            "payload.mass_kg=5e2",
            "--set \"payload.mass_kg=5e2\": payload.mass_kg: found 500; expected 0 or 0.001..=2 kg; 500 looks like grams, write 0.5",
        ),
        ("payload.mass_kg=heavy", "found the text \"heavy\"; expected a number"),
        ("payload.mass=1", "did you mean payload.mass_kg?"),
        ("payload.mass_kg", "expected key=value"),
        (".=1", "expected key=value"),
        ("=1", "expected key=value"),
        (&format!("{}a=1", "a.".repeat(100_000)), "expected key=value"),
        (
            "wind.velocity_m_s.3=1",
            "--set \"wind.velocity_m_s.3=1\": wind.velocity_m_s[3]: found index 3; expected 0..=2",
        ),
        ("wind.velocity_m_s.x=1", "expected a list"),
    ] {
        let error = refused("", &[text]);
        assert!(error.contains(words), "{words}\n{error}");
    }
}

#[test]
fn a_recording_older_than_a_key_or_a_range_is_still_read() {
    let text = "seed = 4\n[payload]\nmass_kg = 300.0\n";
    let file = Path::new("scenario.toml");
    let read: Scenario = read_recorded(text, file, DEFAULTS).unwrap();
    assert_eq!((read.seed, read.payload.mass_kg, read.payload.size_m), (4, 300.0, 0.05));
    let error = read_recorded::<Scenario>("sed = 4\n", file, DEFAULTS).unwrap_err();
    assert!(error.to_string().contains("did you mean seed?"), "{error}");
}

#[test]
fn a_missing_file_is_named() {
    let error = super::read::<Scenario>(Path::new("no/such.toml"), DEFAULTS, &[]).unwrap_err();
    assert!(error.to_string().starts_with("no/such.toml: "), "{error}");
}

proptest! {
    #[test]
    fn no_text_panics(text in "[a-z_.=\\[\\]{}\"'0-9 \n#-]{0,60}", key in "[a-z._0-9=]{0,12}") {
        let _ = read(&text, &[&key, &text]);
    }

    #[test]
    fn defaults_cut_or_edited_do_not_panic(at in 0..DEFAULTS.len(), with in "[\\[\\]=\".,0-9a-z\n]{0,4}") {
        let _ = read(&DEFAULTS[..at], &[]);
        let edited = format!("{}{with}{}", &DEFAULTS[..at], &DEFAULTS[at..]);
        let _ = read(&edited, &[]);
    }
}

/// A scenario with `count` faults.
fn faults(count: usize) -> String {
    let fault = |n: usize| format!("[[faults.list]]\nkind = \"rotor\"\nat_s = {n}.5\n");
    (0..count).map(fault).collect()
}

#[test]
fn the_work_of_a_scenario_grows_with_its_faults_and_not_with_their_square() {
    let growth = twin_input::work::growth(300, &mut |count| {
        let text = faults(count);
        let parsed = Entry::parse(&text, Origin::File);
        assert!(parsed.is_ok());
    });
    assert!(
        growth < twin_input::work::LINEAR,
        "four times the faults took {growth:.1} times the steps"
    );
}

#[test]
fn as_many_elements_in_a_list_as_the_budget_allows_are_read_and_one_more_is_refused() {
    let most = twin_input::budget::LIST_ITEMS.count();
    assert!(Entry::parse(&faults(most), Origin::File).is_ok());
    let (line, said) = Entry::parse(&faults(most + 1), Origin::File).unwrap_err();
    // Each fault has three lines; the first that is too many begins after the others.
    assert_eq!(line as usize, 3 * most + 1);
    assert!(said.contains("found 20001 elements in one list, at most 20000"), "{said}");
}

#[test]
fn as_many_values_as_the_budget_allows_are_read_and_one_more_is_refused() {
    let most = twin_input::budget::TOML_VALUES.count();
    // Each line gives a list and its elements.
    let lists = |values: usize| {
        let line = |n: usize| format!("a{n} = [{}]\n", "1,".repeat(999));
        let whole: String = (0..values / 1000).map(line).collect();
        (0..values % 1000).fold(whole, |text, n| text + &format!("b{n} = 1\n"))
    };
    assert!(Entry::parse(&lists(most), Origin::File).is_ok());
    let (line, said) = Entry::parse(&lists(most + 1), Origin::File).unwrap_err();
    assert_eq!(line, 501);
    assert!(said.contains("found 500001 values, at most 500000"), "{said}");
}

#[test]
fn deep_nesting_is_refused_on_a_small_stack() {
    let read = || {
        let deep = 100_000;
        let texts = [
            format!("a{} = 1\n", ".a".repeat(deep)),
            format!("[a{}]\n", ".a".repeat(deep)),
            format!("a = {}{}\n", "[".repeat(deep), "]".repeat(deep)),
        ];
        texts.iter().all(|text| Entry::parse(text, Origin::File).is_err())
    };
    let thread = std::thread::Builder::new().stack_size(512 << 10).spawn(read).unwrap();
    assert!(thread.join().unwrap());
}
