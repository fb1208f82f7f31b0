//! `twin fly --fork-at` and `twin compare` as programs.

use std::process::{Command, Output};

use serde_json::Value;
use twin_record::read_ticks;

use crate::folder::Folder;

/// A hover of 1 s.
const FLIGHT: [&str; 5] =
    ["fly", "scenarios/hover.toml", "--headless", "--set", "task.duration_s=1.0"];

fn twin(arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_twin");
    Command::new(program)
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("it starts")
}

fn fly(more: &[&str]) -> Output {
    twin(&[&FLIGHT, more].concat())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

#[test]
fn a_flight_its_forks_and_the_scenarios_that_repeat_them_agree() {
    let folder = Folder::new("forks");
    let [record, out] = ["f.mcap", "again.toml"].map(|name| folder.text(name));
    let forks = ["--fork-at", "0.4", "--set", "gains.leak=1.2", "--fork-at", "0.6"];
    let outputs = ["--record", &record, "--scenario-out", &out, "--json"];
    let flown = json(&fly(&[&forks[..], &outputs[..]].concat()));
    let hash = |report: &Value| report["state_hash"].as_str().expect("a hash").to_owned();
    let (parent, forks) = (&flown["parent"], flown["forks"].as_array().expect("a list"));
    assert_eq!(forks.len(), 2);
    assert_eq!(forks[0]["changed"][0]["key"], "gains.leak");
    assert_ne!(hash(&forks[0]["report"]), hash(parent));
    assert_eq!(hash(&forks[1]["report"]), hash(parent), "an unchanged fork is the flight itself");
    for (number, fork) in (1..).zip(forks) {
        // The folder is another one than that of the scenario, so the paths in the file are absolute.
        let file = folder.text(&format!("again-fork-{number}.toml"));
        assert_eq!(fork["scenario"], file.as_str());
        assert_eq!(
            hash(&json(&twin(&["fly", &file, "--headless", "--json"]))),
            hash(&fork["report"])
        );
        let ticks = read_ticks(&folder.path(&format!("f-fork-{number}.mcap"))).expect("whole");
        assert_eq!(ticks.len(), 100, "a recording of a fork has the past, too");
    }
    let difference = forks[0]["differences"].as_array().expect("a list");
    assert!(
        difference
            .iter()
            .any(|row| row["metric"] == "tilt_peak_rad" && row["judgement"].is_string())
    );
}

#[test]
fn the_table_for_people_names_what_changed_and_what_came_of_it() {
    let output = fly(&["--fork-at", "0.4", "--set", "gains.leak=1.2"]);
    let said = text(&output.stdout);
    for part in [
        "fork 1 at 0.4 s: Completed",
        "changed: gains.leak - -> 1.2",
        "from the fork on",
        "tilt_peak_rad",
    ] {
        assert!(said.contains(part), "{part:?} is missing in {said}");
    }
    assert!(text(&output.stderr).contains("fork 1:     0.4"), "{}", text(&output.stderr));
}

#[test]
fn refusals_are_told_before_anything_is_flown_or_written() {
    let folder = Folder::new("refused");
    let record = folder.text("f.mcap");
    for (flags, wanted) in [
        (&["--fork-at", "0.4", "--set", "seed=2"][..], "cannot change in the air"),
        (&["--fork-at=-1"], "a flight begins at 0 s"),
        (&["--fork-at", "inf"], "expected a time of the flight"),
        (&["--scenario-out", "x.toml"], "--fork-at"),
    ] {
        let output = fly(&[flags, &["--record", &record]].concat());
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(wanted), "{flags:?}: {said}");
        assert!(!folder.path("f.mcap").exists(), "{flags:?}");
    }
    let live = twin(&["fly", "scenarios/hover.toml", "--fork-at", "1"]);
    assert!(text(&live.stderr).contains("--headless"), "{}", text(&live.stderr));
}

#[test]
fn recordings_are_compared_in_a_table_in_json_and_on_a_page() {
    let folder = Folder::new("compared");
    let [a, b, page] = ["a.mcap", "b.mcap", "ab.html"].map(|name| folder.text(name));
    let flown = fly(&["--record", &a, "--json"]);
    assert_eq!(flown.status.code(), Some(0), "{}", text(&flown.stderr));
    let other = fly(&["--record", &b, "--json", "--set", "gains.leak=1.2", "--set", "seed=9"]);
    let table = twin(&["compare", &a, &b, "--html", &page]);
    let said = text(&table.stdout);
    assert_eq!(table.status.code(), Some(0), "{}", text(&table.stderr));
    for part in
        ["b beside a: both flew for 1.00 s", "differs: seed 1 -> 9", "differs: gains.leak - -> 1.2"]
    {
        assert!(said.contains(part), "{part:?} is missing in {said}");
    }
    let found = json(&twin(&["compare", &a, &b, "--align", "best", "--json"]));
    let pair = &found["others"][0];
    // The metrics of a recording are those that the flight itself reported.
    let reported: Value = serde_json::from_slice(&other.stdout).expect("one JSON object");
    let rows = pair["metrics"].as_array().expect("a list");
    assert!(rows.iter().any(|row| row["metric"] == "tilt_peak_rad"));
    for row in rows {
        let name = row["metric"].as_str().expect("a name");
        assert_eq!(row["value"], reported["metrics"][name], "{name}");
    }
    let written = std::fs::read_to_string(folder.path("ab.html")).expect("the page");
    assert!(written.contains("What differs") && written.contains("position_error_m: difference"));
    let refused = twin(&["compare", &a, &b, "--align", "event:grasp"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused.stderr).contains("a has no event with \"grasp\""),
        "{}",
        text(&refused.stderr)
    );
    assert_eq!(twin(&["compare", &a]).status.code(), Some(2), "one recording is no comparison");
}
