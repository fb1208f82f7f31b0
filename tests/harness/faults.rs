//! The fault scenarios: each passes, and each would fail without its fault. A fault with a condition begins when it is met.

use std::path::Path;

use twin_core::tick::{EventKind, Tick};
use twin_scenario::{Report, Scenario, fly};

use super::Folder;

fn load(file: &Path, overrides: &[&str]) -> Scenario {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Scenario::load(file, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

fn flown(scenario: &Scenario) -> Report {
    fly(scenario, &mut |_| {}).expect("it can be flown")
}

#[test]
fn every_fault_scenario_passes_and_fails_where_its_fault_is_taken_out() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .expect("the folder of scenarios")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| name.starts_with("fault_"))
        .collect();
    names.sort();
    assert!(names.len() >= 10, "each kind of fault has a scenario: {names:?}");
    let blind: Vec<(String, Report)> = names
        .into_iter()
        .filter_map(|name| {
            let file = folder.join(&name);
            let with = flown(&load(&file, &[]));
            assert!(with.passed, "{name}: {:#?}", with.broken);
            // This scenario's fault is a disturbance. In the others a disturbance only makes the fault visible, so the fault is left out.
            let out =
                if name == "fault_payload_jump.toml" { "disturbances=[]" } else { "faults=[]" };
            let without = flown(&load(&file, &[out]));
            without.passed.then_some((name, without))
        })
        .collect();
    assert!(blind.is_empty(), "these scenarios pass without their fault: {blind:#?}");
}

#[test]
fn a_fault_that_never_begins_is_a_failure() {
    let folder = Folder::new("never");
    let wind = "[[faults]]\nat_s = 0.2\nkind = \"gust\"\nvelocity_m_s = [1.0, 0.0, 0.0]\n";
    let never = format!("{wind}[faults.when]\nphase = \"transport\"\n");
    let late = wind.replace("0.2", "99.0");
    for (more, passes) in [(wind, true), (never.as_str(), false), (late.as_str(), false)] {
        let report = flown(&load(Path::new(&folder.hover("gust", more)), &[]));
        assert_eq!(report.passed, passes, "{more}: {:?}", report.broken);
        let told = report.broken.iter().any(|broken| broken.what.contains("failure: gust"));
        assert_ne!(told, passes);
    }
}

#[test]
fn a_fault_begins_its_delay_after_what_it_waits_for_and_lasts_its_time() {
    let folder = Folder::new("waits");
    let file = folder.hover(
        "waits",
        "[[disturbances]]\nat_s = 0.3\nkind = \"wind\"\nvelocity_m_s = [0.5, 0.0, 0.0]\n\
         [[faults]]\nat_s = 0.2\nduration_s = 0.25\nkind = \"mocap_loss\"\n\
         [faults.when]\nevent = \"disturbance\"\ntext = \"wind\"\n",
    );
    let mut told = Vec::new();
    let mut watch = |tick: &Tick| {
        let about = tick.events.iter().filter(|event| event.kind == EventKind::Disturbance);
        told.extend(about.map(|event| (tick.measurement.t_s, event.text.clone())));
    };
    let report = fly(&load(Path::new(&file), &[]), &mut watch).expect("it can be flown");
    assert!(report.passed, "{:?}", report.broken);
    let at: Vec<i32> = told.iter().map(|(t_s, _)| (t_s * 100.0).round() as i32).collect();
    // The wind acts in the tick from 0.30 to 0.31 s. The fault begins 0.2 s after that tick, and shows at the end of its first tick.
    assert_eq!(at, [31, 52, 77], "{told:?}");
}
