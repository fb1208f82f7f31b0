//! Every scenario of the repository loads, builds and flies its first second.

use std::path::{Path, PathBuf};

use super::folder::Folder;
use twin_core::control::{Gains, Preset};
use twin_scenario::{DEFAULTS, Scenario, Verdict, fly};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios")
}

/// Every scenario file except the defaults.
fn files() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder()).expect("the folder of scenarios");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|file| {
        file.extension().is_some_and(|ending| ending == "toml") && !file.ends_with("defaults.toml")
    });
    files.sort();
    files
}

/// Asserts that in the first second of flight no fault occurs, the state stays finite and nothing collides.
fn starts(scenario: &Scenario) {
    let mut flight = scenario.build().expect(&scenario.name);
    for _ in 0..100 {
        let tick = flight.tick();
        assert_eq!(tick.fault, None, "{}", scenario.name);
        let truth = tick.truth.expect("it is simulated");
        assert!(truth.chi.iter().chain(&truth.chi_dot).all(|x| x.is_finite()), "{}", scenario.name);
        assert!(truth.collision_force_n == 0.0, "{}: it starts inside something", scenario.name);
    }
}

#[test]
fn every_scenario_loads_builds_and_starts() {
    let files = files();
    assert!(files.len() >= 10, "the paper's eight, hover and the demonstration: {files:?}");
    for file in &files {
        let scenario = Scenario::load(file, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_ne!(
            scenario.settings.title,
            "unnamed",
            "{}: a scenario has a title",
            file.display()
        );
        starts(&scenario);
        scenario.scene().expect(&scenario.name);
        scenario.recording_info(&scenario.tuning().expect(&scenario.name)).expect(&scenario.name);
    }
}

#[test]
fn an_empty_file_means_the_defaults() {
    let temporary = Folder::new("empty");
    let empty = Scenario::load(&temporary.write("empty.toml", ""), &[]);
    // Model files are relative to the scenario's folder.
    let scenario = Scenario { file: folder().join("empty.toml"), ..empty.expect("it loads") };
    assert_eq!(scenario.settings.title, "unnamed");
    starts(&scenario);
}

#[test]
fn the_defaults_in_the_binary_are_the_file() {
    let text = std::fs::read_to_string(folder().join("defaults.toml")).expect("the defaults");
    assert_eq!(text, DEFAULTS);
}

#[test]
fn the_limits_of_the_defaults_are_those_of_the_presets() {
    let hover = Scenario::load(&folder().join("hover.toml"), &[]).expect("it loads");
    for preset in [Preset::Literal, Preset::Paper, Preset::Tuned] {
        assert_eq!(hover.preset_tuning(preset).gains, Gains::preset(preset), "{preset:?}");
    }
}

#[test]
fn limits_of_a_scenario_are_in_force() {
    let overrides = [
        "verdict.arena_radius_m=0.5",
        "controller.limits.residual_clip.2=1.5",
        "controller.nominal_inertia.0=2.5",
        "gains.residual_filter_on=0.0",
    ];
    let scenario = Scenario::load(&folder().join("hover.toml"), &overrides.map(str::to_owned))
        .expect("usable");
    let gains = scenario.tuning().expect("in range").gains;
    let found =
        (gains.safe_set.residual_clip[2], gains.nominal_inertia[0], gains.residual_filter_on);
    assert_eq!(found, (1.5, 2.5, false));
    // It starts 1.2 m above the origin.
    let report = fly(&scenario, &mut |_| ()).expect("it flies");
    assert_eq!(report.verdict, Verdict::FlewAway, "{}", report.reason);
}

#[test]
fn settings_survive_a_round_trip_through_toml() {
    for file in files() {
        let settings = Scenario::load(&file, &[]).expect("it loads").settings;
        let text = toml::to_string(&settings).expect("settings are TOML");
        let again: twin_scenario::Settings = toml::from_str(&text).expect("and back");
        assert!(again == settings, "{}", file.display());
    }
}

/// Dotted keys of everything in `value`; all elements of a list have the same key.
fn keys(value: &toml::Value, path: &str, found: &mut std::collections::BTreeSet<String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, inner) in table {
                keys(inner, &format!("{path}.{key}"), found);
            }
        }
        toml::Value::Array(list) if list.iter().any(toml::Value::is_table) => {
            for inner in list {
                keys(inner, path, found);
            }
        }
        _ => {
            found.insert(path.to_owned());
        }
    }
}

#[test]
fn one_scenario_has_every_key_of_the_format() {
    let all = |text: &str| {
        let mut found = std::collections::BTreeSet::new();
        keys(&text.parse::<toml::Table>().expect("TOML").into(), "", &mut found);
        found
    };
    let text =
        std::fs::read_to_string(folder().join("one_of_everything.toml")).expect("it is there");
    let has = all(&text);
    // This scenario must pass, so it cannot declare that it fails; a bound needs the name of a metric; a sweep would make it many flights,
    // and a golden run needs a file. Other scenarios cover these keys.
    let other = ["arena.objects", "expect.fails", "bounds.*.min", "bounds.*.max"];
    let missing: Vec<String> = all(DEFAULTS)
        .into_iter()
        .map(|key| key.trim_start_matches(".example").trim_start_matches('.').to_owned())
        .filter(|key| !has.contains(&format!(".{key}")) && !other.contains(&key.as_str()))
        .filter(|key| !key.starts_with("sweep.") && !key.starts_with("golden."))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}
