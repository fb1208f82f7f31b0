//! The command line as a user or a CI meets it: exit codes, one JSON object, and errors that say what to do.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

/// A scenario file of its own in the test's folder, beside which `../urdf` does not exist.
fn scenario(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Flying `text` ends with exit code 2 and an error that holds every one of `words`.
fn refused(name: &str, text: &str, words: &[&str]) {
    let path = scenario(name, text);
    let output = twin(&["fly", &path.to_string_lossy(), "--headless", "--json"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{name}: {error}");
    assert!(output.stdout.is_empty(), "{name}: nothing is data");
    for word in words {
        assert!(error.contains(word), "{name}: {word:?} is not in {error}");
    }
}

#[test]
fn broken_scenarios_name_file_line_key_found_and_allowed() {
    refused(
        "unknown_key.toml",
        "[payload]\nmas_kg = 0.3\n",
        &["unknown_key.toml:2", "payload.mas_kg", "did you mean payload.mass_kg"],
    );
    refused(
        "grams.toml",
        "[payload]\nmass_kg = 300.0\n",
        &["grams.toml:2", "payload.mass_kg", "0.0..=1.0 kg", "grams", "0.3"],
    );
    refused(
        "negative.toml",
        "\n[payload]\nmass_kg = -0.1\n",
        &["negative.toml:3", "payload.mass_kg", "-0.1"],
    );
    refused("nan.toml", "time_limit_s = nan\n", &["nan.toml:1", "time_limit_s"]);
    refused("word.toml", "[task]\nkind = \"fly\"\n", &["word.toml", "task", "fly", "pick_place"]);
    refused("syntax.toml", "[payload\n", &["syntax.toml:1"]);
    refused("gain.toml", "[gains]\nleak = -2.0\n", &["gain.toml:2", "gains.leak", "0.1..=20.0"]);
}

#[test]
fn broken_vehicles_name_file_line_and_remedy() {
    let vehicle = |name: &str, body: &str| {
        scenario(&format!("{name}.urdf"), &format!("<robot name=\"r\">\n{body}\n</robot>\n"));
        format!("[vehicle]\nurdf = \"{name}.urdf\"\n")
    };
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>"
        )
    };
    let body = format!("{}\n<link name=\"b\"/>\n{}", link("a"), joint("j", "a", "b"));
    refused("no_inertia.toml", &vehicle("no_inertia", &body), &["no_inertia.urdf:3", "inertial"]);
    let body = format!("{}\n{}", link("a"), joint("j", "a", "ghost"));
    refused(
        "unknown_link.toml",
        &vehicle("unknown_link", &body),
        &["unknown_link.urdf:3", "ghost"],
    );
    let body = [link("a"), link("b"), joint("j", "a", "b"), joint("k", "b", "a")].join("\n");
    refused("cyclic.toml", &vehicle("cyclic", &body), &["cyclic.urdf"]);
    let body = link("a").replace(
        "</link>",
        "<collision><geometry><mesh filename=\"gone.stl\"/></geometry></collision></link>",
    );
    refused("mesh.toml", &vehicle("mesh", &body), &["mesh.urdf:2", "gone.stl"]);
    refused(
        "missing.toml",
        "[vehicle]\nurdf = \"nowhere.urdf\"\n",
        &["nowhere.urdf", "check the path"],
    );
}

#[test]
fn a_flight_prints_exactly_one_json_object_and_exits_by_its_verdict() {
    let short =
        ["fly", "scenarios/hover.toml", "--headless", "--json", "--set", "task.duration_s=1.0"];
    let output = twin(&short);
    assert_eq!(output.status.code(), Some(0));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["verdict"], "completed");
    assert!(
        report["metrics"]["rms_error_e8"].is_null(),
        "one second holds no metric that counts from 2 s on"
    );
    let failing = [&short[..], &["--set", "expect.verdict=crashed"]].concat();
    assert_eq!(twin(&failing).status.code(), Some(1), "an unexpected verdict fails");
}

#[test]
fn a_port_in_use_is_said_with_its_remedy() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let output = twin(&["fly", "scenarios/hover.toml", "--port", &port]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains(&port) && error.contains("--port"), "{error}");
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
