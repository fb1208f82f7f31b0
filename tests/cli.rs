//! The command line as a user or a CI meets it: exit codes, one JSON object, what `check` says.

use std::path::Path;
use std::process::{Command, Output};

fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

#[test]
fn with_json_stdout_is_exactly_one_object() {
    let keys = [
        "scenario",
        "seed",
        "verdict",
        "reason",
        "flight_s",
        "real_time_factor",
        "state_hash",
        "metrics",
    ];
    for (overrides, code) in [
        (&["--set", "task.duration_s=0.5"][..], 0),
        // It ends, but not as expected: the verdict is still one object.
        (&["--set", "task.duration_s=0.5", "--set", "expect.verdict=crashed"], 1),
    ] {
        let mut arguments = vec!["fly", "scenarios/hover.toml", "--headless", "--json"];
        arguments.extend(overrides);
        let output = twin(&arguments);
        assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
        let value: serde_json::Value =
            serde_json::from_slice(&output.stdout).expect("one JSON value and nothing else");
        for key in keys {
            assert!(value.get(key).is_some_and(|found| !found.is_null()), "{key} in {value}");
        }
        assert_eq!(value["scenario"], "hover");
        assert!(value["metrics"]["rms_error_e8"].is_null(), "it counts from 2 s on: {value}");
        assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 1);
    }
}

#[test]
fn check_says_what_is_wrong_with_each_file() {
    let bad = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bad.toml");
    std::fs::write(&bad, "[payload]\nmass_kg = 300.0\n").expect("a temporary file");
    let output = twin(&[
        "check",
        "scenarios/hover.toml",
        bad.to_str().expect("a path of ASCII"),
        "urdf/cube.urdf",
    ]);
    let stdout = String::from_utf8_lossy(&output.stdout);
    assert!(!output.status.success(), "{stdout}");
    let lines: Vec<&str> = stdout.lines().collect();
    assert_eq!(lines.len(), 3, "{stdout}");
    assert!(lines[0].starts_with("ok") && lines[2].starts_with("ok"), "{stdout}");
    assert!(lines[1].contains("bad.toml:2") && lines[1].contains("payload.mass_kg"), "{stdout}");
}

#[test]
fn every_shipped_scenario_and_model_is_usable() {
    let list = |folder: &str, ending: &str| {
        let mut files: Vec<String> =
            std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder))
                .unwrap()
                .map(|entry| entry.unwrap().path().to_string_lossy().into_owned())
                .filter(|path| path.ends_with(ending))
                .collect();
        files.sort();
        files
    };
    let files = [list("scenarios", ".toml"), list("urdf", ".urdf")].concat();
    let arguments: Vec<&str> =
        std::iter::once("check").chain(files.iter().map(String::as_str)).collect();
    let output = twin(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stdout));
}
