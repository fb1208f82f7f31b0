//! `twin info` and `twin mirror` through the real program.

use std::process::{Command, Output, Stdio};

use twin_foreign::OpenedFlight;
use twin_foreign::Shadow;
use twin_foreign::shadow_score::SCORED;
use twin_record::read_ticks;

use super::made::{Form, PLAIN, file, flight};

fn twin(arguments: &[&str]) -> (Output, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_twin")).args(arguments).output().expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!stderr.contains("panicked"), "{stderr}");
    (output, stderr)
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).expect("exactly one JSON object")
}

#[test]
fn a_flight_is_surveyed_and_mirrored_to_one_json_object_each() {
    let path = file("program.mcap", &flight(PLAIN));
    let path = path.to_str().expect("text");
    let (info, _) = twin(&["info", path, "--json"]);
    assert_eq!((info.status.code(), json(&info)["messages"].as_u64()), (Some(0), Some(5000)));
    let (mirror, _) = twin(&["mirror", path, "--headless", "--json"]);
    assert_eq!(mirror.status.code(), Some(0));
    let found = json(&mirror);
    assert_eq!(found["effort"]["kind"], "fitted");
    assert_eq!(found["shadow"]["prediction"].as_array().map(Vec::len), Some(SCORED.len()));
    assert_eq!(found["forces_are_per_kilogram"], true);
}

#[test]
fn a_cut_file_is_reported_with_exit_code_1_and_still_mirrored() {
    let whole = flight(PLAIN);
    let path = file("program_cut.mcap", &whole[..whole.len() / 2]);
    let path = path.to_str().expect("text");
    let (info, _) = twin(&["info", path]);
    let text = String::from_utf8_lossy(&info.stdout).into_owned();
    assert_eq!(info.status.code(), Some(1));
    assert!(text.contains("PROBLEM") && text.contains("the file ends at byte"), "{text}");
    let (mirror, stderr) = twin(&["mirror", path, "--headless", "--json"]);
    assert_eq!(mirror.status.code(), Some(0));
    assert!(stderr.contains("the file ends at byte"), "{stderr}");
}

#[test]
fn unusable_input_is_refused_with_exit_code_2_and_what_to_do() {
    let text = file("text.mcap", b"hello, this is text");
    let bad_map = file("bad.toml", b"[[topic]]\ntopic = \"/x\"\n[topic.gives.speed]\npaths = []\n");
    let path = file("fine.mcap", &flight(PLAIN));
    let name = |path: &std::path::Path| path.to_str().expect("text").to_owned();
    for (arguments, wanted) in [
        (vec!["info".to_owned(), name(&text)], ["not an MCAP file", "hello"]),
        (vec!["info".to_owned(), "absent.mcap".to_owned()], ["absent.mcap", "check the path"]),
        (
            vec!["mirror".into(), name(&path), "--headless".into(), "--map".into(), name(&bad_map)],
            ["bad.toml", "speed"],
        ),
        (
            vec![
                "mirror".into(),
                name(&path),
                "--headless".into(),
                "--map".into(),
                "nowhere".into(),
            ],
            ["nowhere", "crazyflie"],
        ),
    ] {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (output, stderr) = twin(&arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(output.stdout.is_empty());
        assert!(stderr.matches("not an MCAP file").count() < 2, "said twice: {stderr}");
        for part in wanted {
            assert!(stderr.contains(part), "{arguments:?}: {part:?} is missing in: {stderr}");
        }
    }
}

#[test]
fn a_reader_that_stops_reading_ends_the_program_without_a_word() {
    let path = file("head.mcap", &flight(PLAIN));
    let mut child = Command::new(env!("CARGO_BIN_EXE_twin"))
        .arg("info")
        .arg(&path)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(
        (output.status.code(), String::from_utf8_lossy(&output.stderr)),
        (Some(0), "".into())
    );
}

#[test]
fn what_is_unknown_in_a_flight_is_unknown_in_its_recording_its_page_and_its_csv() {
    let path = file("program_hole.mcap", &flight(Form { hole_s: Some((6.0, 9.0)), ..PLAIN }));
    let [path, record, plot, page, csv] = [
        path.clone(),
        path.with_extension("rec.mcap"),
        path.with_extension("svg"),
        path.with_extension("html"),
        path.with_extension("csv"),
    ]
    .map(|path| path.to_str().expect("text").to_owned());
    let (first, _) = twin(&[
        "mirror",
        &path,
        "--headless",
        "--json",
        "--record",
        &record,
        "--plot",
        &plot,
        "--fly-from",
        "12.5",
    ]);
    assert_eq!(first.status.code(), Some(0), "{first:?}");
    // What was flown comes back from the file, tick by tick, the same rows known and equal.
    let opened = OpenedFlight::open(std::path::Path::new(&path), None).expect("a flight");
    let mut flown = Vec::new();
    Shadow::of(&opened).fly(&mut |tick| flown.push(tick.clone())).expect("ticks");
    assert!(read_ticks(std::path::Path::new(&record)).expect("a recording") == flown);
    let (again, _) = twin(&["mirror", &record, "--headless", "--json"]);
    let (first, again) = (json(&first), json(&again));
    for row in 0..8 {
        for key in ["coordinate_known", "residual"] {
            let of = |found: &serde_json::Value| found["shadow"]["rows"][row][key].clone();
            assert_eq!(of(&first), of(&again), "{row} {key}");
        }
    }
    assert!(first["shadow"]["rows"][0]["coordinate_known"].as_f64().expect("a share") < 0.9);
    // The made vehicle obeys its thrust, so the twin follows it; its torque is unknown.
    let divergence = &first["divergence"];
    assert_eq!(
        (&divergence["light"], &divergence["from"]["own_attitude"]),
        (&"valid".into(), &false.into())
    );
    assert_eq!(divergence["horizons"][1]["axes"].as_array().map(Vec::len), Some(3));
    assert!(std::fs::read_to_string(&plot).expect("a picture").starts_with("<svg"));
    let (csv_of, _) = twin(&["export", "csv", &record, "-o", &csv]);
    assert_eq!(csv_of.status.code(), Some(0));
    let text = std::fs::read_to_string(&csv).expect("written");
    let column = |name: &str| text.lines().next()?.split(',').position(|found| found == name);
    let cell = |tick: usize, name: &str| {
        text.lines().nth(tick + 1)?.split(',').nth(column(name)?).map(str::to_owned)
    };
    let of = |name: &str| [500, 800].map(|tick| cell(tick, name).expect("a cell").is_empty());
    assert_eq!(
        (of("chi.x"), of("residual.z"), of("residual.psi")),
        ([false, true], [false, true], [true; 2])
    );
    let (html, stderr) = twin(&["export", "html", &record, "-o", &page]);
    assert_eq!(html.status.code(), Some(0), "{stderr}");
    assert!(std::fs::read_to_string(&page).expect("a page").contains("<html"));
}

#[test]
fn a_mirrored_flight_cannot_score_a_prediction_and_says_why() {
    let path = file("program_scored.mcap", &flight(PLAIN));
    let record = path.with_extension("rec.mcap");
    let [path, record] = [&path, &record].map(|path| path.to_str().expect("text").to_owned());
    let (mirror, _) = twin(&["mirror", &path, "--headless", "--json", "--record", &record]);
    assert_eq!(mirror.status.code(), Some(0), "{mirror:?}");
    let (output, stderr) = twin(&["evaluate", "prediction", &record]);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{stderr}");
    for part in ["program_scored.rec.mcap: none of its", "follows the measurement", "twin collect"]
    {
        assert!(stderr.contains(part), "{part:?} is not in {stderr:?}");
    }
}
