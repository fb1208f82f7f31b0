//! Unusable input through the real program: exit code 2 and a message that says what, where, what is allowed and what to do.

use std::net::TcpListener;
use std::path::Path;
use std::process::{Command, Output};

use crate::folder::Folder;

/// Runs the program in the root of the repository.
fn twin(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program starts")
}

/// Asserts exit code 2, an empty stdout, every text of `wanted` on stderr, and no panic.
fn refused(arguments: &[&str], wanted: &[&str]) {
    let output = twin(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    assert!(output.stdout.is_empty(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stdout));
    assert!(!stderr.contains("panicked"), "{arguments:?}: {stderr}");
    for part in wanted {
        assert!(stderr.contains(part), "{arguments:?}: {part:?} is missing in: {stderr}");
    }
}

/// Name, text of the scenario, and the texts that its error must contain.
const BAD_SCENARIOS: &[(&str, &str, &[&str])] = &[
    (
        "no_rotors",
        "[vehicle]\nurdf = \"URDF\"\nrotors = []\n",
        &["vehicle.rotors", "0 rotors", "3 to"],
    ),
    (
        "wide_features",
        "[predictor]\nfeatures = 100000\n",
        &[":2", "predictor.features", "100000", "1024"],
    ),
    (
        "unknown_effect",
        "[[disturbances]]\nat_s = 1.0\nkind = \"effect\"\nname = \"rain\"\non = false\n",
        &["disturbances.0.name", "rain", "downwash"],
    ),
    (
        "unknown_key",
        "title = \"x\"\n[payload]\nmas_kg = 0.3\n",
        &[":3", "payload.mas_kg", "mass_kg"],
    ),
    ("unknown_table", "\n[pailoud]\nmass_kg = 0.3\n", &[":2", "pailoud", "payload"]),
    ("not_a_number", "[payload]\nmass_kg = nan\n", &[":2", "payload.mass_kg", "NaN", "finite"]),
    ("infinite", "[payload]\n\nmass_kg = inf\n", &[":3", "payload.mass_kg", "inf"]),
    ("negative_mass", "[payload]\nmass_kg = -0.3\n", &[":2", "payload.mass_kg", "-0.3"]),
    ("grams", "[payload]\nmass_kg = 300.0\n", &[":2", "payload.mass_kg", "300", "0.3"]),
    (
        "wrong_type",
        "[payload]\nmass_kg = \"heavy\"\n",
        &[":2", "payload.mass_kg", "heavy", "number"],
    ),
    (
        "wrong_word",
        "[predictor]\nkind = \"prophet\"\n",
        &[":2", "predictor.kind", "prophet", "persistence"],
    ),
    (
        "short_list",
        "[task]\nstart_position_m = [0.0, 1.0]\n",
        &[":2", "task.start_position_m", "3"],
    ),
    ("unknown_gain", "[gains]\nslop = [1.0]\n", &[":2", "gains.slop", "slope"]),
    ("gain_range", "[gains]\nleak = -1.0\n", &["leak", "-1", "0.1", "20"]),
    (
        "heavy_change",
        "[[disturbances]]\nat_s = 1.0\nkind = \"payload_mass\"\nkg = 300.0\n",
        &[":4", "disturbances[0].kg", "300", "0.001..=2 kg", "looks like grams, write 0.3"],
    ),
    (
        "hard_push",
        "[[disturbances]]\nat_s = 1.0\nkind = \"push\"\nforce_n = [1e7, 0.0, 0.0]\nduration_s = 0.5\n",
        &[":4", "disturbances[0].force_n[0]", "10000000", "-100..=100 N"],
    ),
    (
        "long_push",
        "[[disturbances]]\nat_s = 1.0\nkind = \"push\"\nforce_n = [1.0, 0.0, 0.0]\nduration_s = 11.0\n",
        &[":5", "disturbances[0].duration_s", "11", "0..=10 s"],
    ),
    (
        "storm",
        "disturbances = [{ at_s = 1.0, kind = \"wind\", velocity_m_s = [0.0, 31.0, 0.0] }]\n",
        &[":1", "disturbances[0].velocity_m_s[1]", "31", "-30..=30 m/s"],
    ),
    ("no_toml", "[payload\nmass_kg = 0.3\n", &[":1", "not TOML"]),
    ("missing_urdf", "[vehicle]\nurdf = \"nowhere.urdf\"\n", &["nowhere.urdf"]),
    (
        "unknown_joint",
        "[vehicle]\nurdf = \"URDF\"\narm_joints = [\"elbow\"]\n",
        &["vehicle.arm_joints", "elbow", "joint1"],
    ),
    (
        "joint_twice",
        "[vehicle]\nurdf = \"URDF\"\narm_joints = [\"joint1\", \"joint1\"]\n",
        &["vehicle.arm_joints", "joint1", "twice"],
    ),
    (
        "joint_beyond_its_limit",
        "[vehicle]\nurdf = \"URDF\"\n[task]\ntransit_joints_rad = [-6.3, 0.0]\n",
        &["task.transit_joints_rad", "joint1", "-6.3", "limits"],
    ),
    (
        "odd_rate",
        "[vehicle]\nurdf = \"URDF\"\n[controller]\ninner_hz = 300.0\n",
        &["controller.inner_hz", "300", "1000"],
    ),
];

#[test]
fn a_bad_scenario_is_refused_with_file_line_key_finding_and_what_is_allowed() {
    let folder = Folder::new("scenario");
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/aerial_manipulator.urdf");
    for (name, text, wanted) in BAD_SCENARIOS {
        let file = folder
            .write(&format!("{name}.toml"), &text.replace("URDF", &urdf.display().to_string()));
        let file = file.to_str().expect("a path of ASCII");
        let mut wanted = wanted.to_vec();
        let place = format!("{name}.toml");
        wanted.push(&place);
        refused(&["fly", file, "--headless"], &wanted);
        refused(&["fly", file, "--headless", "--json"], &wanted);
    }
}

#[test]
fn a_bad_override_is_refused_by_its_own_text() {
    let hover = "scenarios/hover.toml";
    for (text, wanted) in [
        ("payload.mass_kg=nan", &["payload.mass_kg", "nan"][..]),
        ("payload.mas_kg=0.3", &["payload.mas_kg", "mass_kg"]),
        ("payload.mass_kg", &["payload.mass_kg", "key=value"]),
        ("=3", &["key=value"]),
        ("a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r=1", &["key=value"]),
    ] {
        let mut wanted = wanted.to_vec();
        wanted.push("--set");
        refused(&["fly", hover, "--headless", "--set", text], &wanted);
    }
    refused(
        &["fly", "scenarios/nowhere.toml", "--headless"],
        &["scenarios/nowhere.toml", "check the path"],
    );
    refused(
        &["fly", hover, "--headless", "--record", "/nowhere/at/all.mcap"],
        &["/nowhere/at/all.mcap", "--record"],
    );
    refused(&["fly", hover, "--speed", "NaN"], &["NaN", "0.01"]);
    refused(&["fly", hover, "--headless", "--seed", "-1"], &["-1"]);
}

/// The vehicle's URDF in which the first `old` is replaced by `new`.
fn broken_urdf(old: &str, new: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/aerial_manipulator.urdf");
    let text = std::fs::read_to_string(path).expect("the URDF");
    assert!(text.contains(old), "{old}");
    text.replacen(old, new, 1)
}

/// Number of the first line of `text` that contains `part`, counted from 1.
fn line_of(text: &str, part: &str) -> usize {
    text.lines().position(|line| line.contains(part)).expect(part) + 1
}

#[test]
fn a_bad_urdf_is_refused_with_file_line_finding_and_remedy() {
    let box_mesh = "<geometry><mesh filename=\"package://arms/palm.stl\"/></geometry>";
    let palm = "<geometry><box size=\"0.042 0.140 0.016\"/></geometry>";
    let wrist = "<parent link=\"palm\"/><child link=\"tool\"/>";
    let cases: Vec<(&str, String, &str, &[&str])> = vec![
        ("missing_mesh", broken_urdf(palm, box_mesh), "palm.stl", &["palm.stl", "package"]),
        (
            "absent_file",
            broken_urdf(palm, "<geometry><mesh filename=\"absent.stl\"/></geometry>"),
            "absent.stl",
            &["absent.stl"],
        ),
        (
            "cyclic",
            broken_urdf(wrist, "<parent link=\"palm\"/><child link=\"link1\"/>"),
            "",
            &["link1"],
        ),
        (
            "negative",
            broken_urdf("<mass value=\"2.30\"/>", "<mass value=\"-2.30\"/>"),
            "-2.30",
            &["-2.30", "above 0"],
        ),
        ("nan", broken_urdf("<mass value=\"2.30\"/>", "<mass value=\"NaN\"/>"), "NaN", &["NaN"]),
        ("no_inertia", without_inertial("link1"), "<link name=\"link1\">", &["link1", "inertia"]),
        ("not_xml", "<robot name=\"x\"><link".to_owned(), "", &[]),
        ("empty", String::new(), "", &[]),
    ];
    let folder = Folder::new("urdf");
    for (name, text, at, wanted) in &cases {
        folder.write(&format!("{name}.urdf"), text);
        let scenario =
            folder.write(&format!("{name}.toml"), &format!("[vehicle]\nurdf = \"{name}.urdf\"\n"));
        let line = if at.is_empty() { String::new() } else { format!(":{}", line_of(text, at)) };
        let place = format!("{name}.urdf{line}");
        let mut wanted = wanted.to_vec();
        wanted.push(&place);
        refused(&["fly", scenario.to_str().expect("a path of ASCII"), "--headless"], &wanted);
    }
}

/// The vehicle's URDF with a link that has no `<inertial>`.
fn without_inertial(link: &str) -> String {
    let text = broken_urdf("", "");
    let start = text.find(&format!("<link name=\"{link}\">")).expect("the link");
    let from = start + text[start..].find("<inertial>").expect("its inertial");
    let to = from + text[from..].find("</inertial>").expect("its end") + "</inertial>".len();
    format!("{}{}", &text[..from], &text[to..])
}

#[test]
fn a_port_in_use_is_refused_with_the_port_and_the_way_out() {
    let taken = TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
    let port = taken.local_addr().expect("its address").port().to_string();
    refused(&["fly", "scenarios/hover.toml", "--port", &port], &[&port, "--port"]);
    refused(&["fly", "scenarios/hover.toml", "--host", "0.0.0.0"], &["0.0.0.0", "127.0.0.1"]);
}

#[test]
fn a_recording_that_is_not_there_is_named_with_its_cause_once() {
    // The MeshCat page needs its viewer first, which may not be installed here.
    for kind in ["html", "viser", "csv"] {
        refused(&["export", kind, "nowhere.mcap"], &["nowhere.mcap", "No such file"]);
        let output = twin(&["export", kind, "nowhere.mcap"]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(said.matches("No such file").count(), 1, "{said}");
    }
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
        // The flight ends, but not as expected: the verdict is still one object.
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
        assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 1);
    }
}

#[test]
fn check_says_what_is_wrong_with_each_file() {
    let folder = Folder::new("check");
    let bad = folder.write("bad.toml", "[payload]\nmass_kg = 300.0\n");
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
fn a_training_that_cannot_be_done_says_why_and_what_to_do() {
    let folder = Folder::new("train");
    let config = folder.write("mine.toml", "d_modl = 64\n");
    let config = config.to_str().expect("a name in UTF-8");
    refused(&["train", "x.mcap", "--config", config], &["mine.toml", "d_modl", "d_model"]);
    refused(&["train", "x.mcap", "--config", "medium"], &["medium", "small, paper"]);
    refused(&["train", "x.mcap", "--epochs", "0"], &["epochs = 0", "1 to"]);
    refused(
        &["train", "x.mcap", "--model", "lstm", "--without", "long-memory"],
        &["--without", "lstm"],
    );
    if cfg!(feature = "train") {
        let empty = &folder.text("");
        refused(&["train", empty], &["no collect_*.mcap", "twin collect"]);
        let text = folder.write("flight.mcap", "no flight at all");
        let text = text.to_str().expect("a name in UTF-8");
        refused(&["train", text], &["flight.mcap", "not an MCAP file"]);
    } else {
        refused(
            &["train", "x.mcap"],
            &["without training", "cargo build --release --features train"],
        );
    }
}

#[test]
fn the_settings_of_a_training_can_be_read_back() {
    let output = twin(&["train", "--config", "paper", "--print-config"]);
    assert_eq!(output.status.code(), Some(0));
    let folder = Folder::new("settings");
    let printed = String::from_utf8(output.stdout).expect("text");
    let file = folder.write("paper.toml", &printed);
    let file = file.to_str().expect("a name in UTF-8");
    let again = twin(&["train", "--config", file, "--print-config"]);
    assert_eq!(String::from_utf8_lossy(&again.stdout), printed);
    assert!(printed.contains("d_model = 512") && printed.contains("d_ff = 2048"), "{printed}");
}
