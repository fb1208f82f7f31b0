//! SIGINT, SIGTERM and SIGHUP: every file is finished, stdout has its object, and the exit code is 128 + signal.

use std::io::{BufRead, BufReader, Read};

use super::*;

/// The signals that ask a program to end, and their numbers.
const SIGNALS: [(&str, i32); 3] = [("INT", 2), ("TERM", 15), ("HUP", 1)];

/// Bytes of a recording that has begun, and is far from its end.
const BEGUN_BYTES: u64 = 300_000;

#[test]
fn a_headless_flight_finishes_its_recording_and_prints_its_verdict() {
    let folder = Folder::new("headless");
    for (name, number) in SIGNALS {
        let path = folder.path(&format!("{name}.mcap"));
        let record = path.display().to_string();
        let mut words = vec!["fly"];
        words.extend(LONG_HOVER);
        words.extend(["--headless", "--json", "--record", &record]);
        let child = start(&words);
        until_it_has(&path, BEGUN_BYTES);
        signal(&child, name);
        let (code, json, said) = ended(child);
        assert_eq!(code, Some(128 + number), "{name}: {said}");
        assert_eq!(json["verdict"], "interrupted", "{name}: {json}");
        assert_eq!(json["recording"]["state"], "finished", "{name}: {json}");
        let metadata = finished(&path);
        assert!(metadata["verdict"].starts_with("interrupted: SIG"), "{metadata:?}");
        assert_eq!(metadata["state_hash"], json["state_hash"], "{name}");
    }
}

#[test]
fn a_served_flight_finishes_its_recording() {
    let folder = Folder::new("served");
    for (name, number) in SIGNALS {
        let path = folder.path(&format!("{name}.mcap"));
        let record = path.display().to_string();
        let child = start(&served_hover(&record));
        until_it_has(&path, BEGUN_BYTES);
        signal(&child, name);
        let (code, _, said) = ended(child);
        assert_eq!(code, Some(128 + number), "{name}: {said}");
        let metadata = finished(&path);
        assert!(metadata["verdict"].starts_with("interrupted: SIG"), "{metadata:?}");
    }
}

#[test]
fn a_second_signal_ends_the_program_at_once() {
    let folder = Folder::new("twice");
    let path = folder.path("twice.mcap");
    let record = path.display().to_string();
    let mut words = vec!["fly"];
    words.extend(LONG_HOVER);
    words.extend(["--headless", "--json", "--record", &record]);
    let child = start(&words);
    until_it_has(&path, BEGUN_BYTES);
    // A stopped program receives both signals before it does anything else; the system chooses their order.
    for name in ["STOP", "INT", "TERM", "CONT"] {
        signal(&child, name);
    }
    let (code, json, _) = ended(child);
    assert!([130, 143].contains(&code.expect("a code")) && json.is_null(), "{code:?}: {json}");
}

#[test]
fn a_mirror_that_waits_for_its_stream_or_its_file_ends() {
    let folder = Folder::new("waits");
    let absent = folder.text("absent.mcap");
    // Port 9 belongs to the discard service, which nobody runs.
    for words in [vec!["mirror", "ws://127.0.0.1:9"], vec!["mirror", &absent, "--follow"]] {
        for (name, number) in SIGNALS {
            let child = start(&words);
            until_it_catches(&child);
            signal(&child, name);
            let (code, _, said) = ended(child);
            assert_eq!(code, Some(128 + number), "{words:?} {name}: {said}");
        }
    }
}

#[test]
fn a_headless_mirror_finishes_its_recording_and_draws_no_half_picture() {
    let folder = Folder::new("mirror");
    let (flight, beside) = (folder.text("flight.mcap"), folder.path("beside.mcap"));
    let flown = command(&[
        "fly",
        "scenarios/hover.toml",
        "--headless",
        "--record",
        &flight,
        "--set",
        "task.duration_s=120",
        "--set",
        "time_limit_s=200",
    ])
    .output()
    .expect("a flight");
    assert!(flown.status.code().is_some_and(|code| code < 2), "{flown:?}");
    let (record, plot) = (beside.display().to_string(), folder.text("plot.svg"));
    let child =
        start(&["mirror", &flight, "--headless", "--json", "--record", &record, "--plot", &plot]);
    until_it_has(&beside, 100_000);
    signal(&child, "TERM");
    let (code, json, said) = ended(child);
    assert_eq!(code, Some(143), "{said}");
    assert_eq!(json["verdict"], "interrupted", "{json}");
    assert_eq!(json["shadow"]["ticks"].to_string(), finished(&beside)["ticks"]);
    assert!(!folder.path("plot.svg").exists());
}

#[test]
fn a_collection_finishes_the_recordings_that_it_began_and_writes_no_table() {
    let folder = Folder::new("collect");
    let out = folder.text("data");
    let child = start(&[
        "collect",
        "--paper",
        "--out",
        &out,
        "--seconds",
        "3000",
        "--payloads",
        "0,200",
        "--jobs",
        "2",
        "--json",
    ]);
    let begun = ["data/collect_0g.mcap", "data/collect_200g.mcap"].map(|name| folder.path(name));
    for path in &begun {
        until_it_has(path, BEGUN_BYTES);
    }
    signal(&child, "INT");
    let (code, json, said) = ended(child);
    assert_eq!(code, Some(130), "{said}");
    assert_eq!(
        (&json["verdict"], &json["not_begun"]),
        (&"interrupted".into(), &1.into()),
        "{json}"
    );
    assert_eq!(json["flights"].as_array().map(Vec::len), Some(2), "{json}");
    for path in &begun {
        assert!(finished(path)["verdict"].starts_with("interrupted: SIGINT"));
    }
    assert!(
        !folder.path("data/collect.json").exists() && !folder.path("data/test_300g.mcap").exists()
    );
}

/// A scenario of a hover of `seconds` in `folder`.
fn hover(folder: &Folder, name: &str, seconds: u32) -> String {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("urdf/aerial_manipulator.urdf");
    let text = format!(
        "title = \"{name}\"\ntime_limit_s = 3600.0\n[vehicle]\nurdf = \"{}\"\n[payload]\nmass_kg = 0.0\n[task]\nkind = \"hover\"\n\
         start_position_m = [0.0, 0.0, 1.2]\nduration_s = {seconds}.0\n",
        urdf.display()
    );
    let path = folder.path(&format!("{name}.toml"));
    std::fs::write(&path, text).expect("a temporary file");
    path.display().to_string()
}

#[test]
fn scenarios_as_tests_report_what_was_not_run() {
    let folder = Folder::new("test");
    let cases = [hover(&folder, "one", 1), hover(&folder, "two", 3500), hover(&folder, "three", 1)];
    let (junit, html) = (folder.text("j.xml"), folder.text("r.html"));
    let mut words = vec!["test", "--jobs", "1", "--json", "--junit", &junit, "--html", &html];
    words.extend(cases.iter().map(String::as_str));
    let mut child = start(&words);
    let mut said = BufReader::new(child.stderr.take().expect("its messages"));
    let mut line = String::new();
    while !line.starts_with("passed") {
        line.clear();
        assert!(said.read_line(&mut line).is_ok_and(|bytes| bytes > 0), "no case passed");
    }
    signal(&child, "HUP");
    let mut rest = String::new();
    said.read_to_string(&mut rest).expect("text");
    let (code, json, _) = ended(child);
    assert_eq!(code, Some(129), "{rest}");
    assert_eq!((&json["verdict"], &json["not_run"]), (&"interrupted".into(), &2.into()), "{json}");
    let results: Vec<_> = json["cases"]
        .as_array()
        .expect("cases")
        .iter()
        .map(|case| case["result"].clone())
        .collect();
    assert_eq!(results, ["passed", "not run", "not run"]);
    let junit = std::fs::read_to_string(&junit).expect("a report");
    assert_eq!(junit.matches("<skipped").count(), 2, "{junit}");
    assert!(
        junit.contains("interrupted by a signal") && junit.contains("</testsuites>"),
        "{junit}"
    );
    let html = std::fs::read_to_string(&html).expect("a page");
    assert!(html.contains("interrupted by a signal: 2 not run"), "{html}");
    let merged = folder.path("shard.json");
    std::fs::write(&merged, json.to_string()).expect("a file");
    let merged = command(&["test", "merge", &merged.display().to_string(), "--json"])
        .output()
        .expect("it ends");
    assert_eq!(merged.status.code(), Some(1), "{merged:?}");
}

#[test]
fn a_table_is_whole_or_absent() {
    let folder = Folder::new("tables");
    let long = hover(&folder, "long", 3500);
    let (csv, cache) = (folder.text("t.csv"), folder.text("cache"));
    let tracking = vec![
        "evaluate", "tracking", &long, "--seeds", "9", "--rows", "pid", "--csv", &csv, "--json",
        "--cache", &cache,
    ];
    let l1 = vec!["evaluate", "l1", &long, "--csv", &csv, "--json"];
    for words in [tracking, l1] {
        let child = start(&words);
        until_it_catches(&child);
        signal(&child, "TERM");
        let (code, json, said) = ended(child);
        assert_eq!(code, Some(143), "{words:?}: {said}");
        assert_eq!(json["verdict"], "interrupted", "{words:?}: {json}");
        assert!(!folder.path("t.csv").exists(), "{words:?}");
    }
}

#[test]
fn an_export_is_whole_or_absent() {
    let folder = Folder::new("exports");
    let flight = folder.text("flight.mcap");
    let flown = command(&["fly", "scenarios/hover.toml", "--headless", "--record", &flight])
        .output()
        .expect("a flight");
    assert_eq!(flown.status.code(), Some(0), "{flown:?}");
    for (kind, out) in [("csv", "f.csv"), ("viser", "f.viser")] {
        let path = folder.path(out);
        let child = start(&["export", kind, &flight, "-o", &path.display().to_string()]);
        until_it_catches(&child);
        signal(&child, "INT");
        // A short export may be done before the signal arrives.
        let (code, _, said) = ended(child);
        let whole = code == Some(0);
        assert!(whole || code == Some(130), "{kind}: {code:?}: {said}");
        assert_eq!(path.exists(), whole, "{kind}: {said}");
    }
}
