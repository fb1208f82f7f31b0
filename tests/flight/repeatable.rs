//! The same seed gives the same flight: in memory, in a recording, and flown again from a recording.

use std::process::Command;
use std::sync::Arc;

use twin_record::{Recorder, RecordingEnd, read_recording, read_ticks};
use twin_scenario::{Scenario, Settings};

use crate::folder::Folder;

use super::flown::{flown, scenario};

/// Keys of a short flight with all random parts: noise, turbulence, and a cube in the gripper.
const SHORT: [&str; 4] =
    ["task.duration_s=2.0", "task.start=grasped", "payload.mass_kg=0.3", "wind.kind=dryden"];

/// The short flight with `seed`.
fn short(seed: u64) -> Scenario {
    let seed = format!("seed={seed}");
    let overrides: Vec<&str> = SHORT.into_iter().chain([seed.as_str()]).collect();
    scenario("hover", &overrides)
}

#[test]
fn the_same_seed_gives_the_same_ticks_and_another_seed_gives_others() {
    let ((report, ticks), (again, same)) = (flown(&short(5)), flown(&short(5)));
    assert_eq!(report, again);
    assert!(ticks == same, "the hashes are equal but a tick is not");
    let (other, different) = flown(&short(6));
    assert_ne!(report.state_hash, other.state_hash);
    assert!(ticks != different);
}

#[test]
fn the_hash_depends_on_the_command_and_not_only_on_the_seed() {
    let (report, _) = flown(&short(5));
    let mut changed = short(5);
    changed.settings.gains.scalars.insert("residual_bandwidth_hz".to_owned(), 4.9);
    assert_ne!(flown(&changed).0.state_hash, report.state_hash);
}

#[test]
fn the_hash_does_not_depend_on_the_code_that_the_c_library_chooses_for_a_processor() {
    // glibc has a sine with fused multiply-add and one without, and takes the second where this variable denies the instruction.
    // Other C libraries ignore it.
    const WITHOUT_FMA: &str = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2";
    let hash = |tunables: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_twin"));
        program.args(["fly", "scenarios/hover.toml", "--headless", "--json"]);
        for key in SHORT {
            program.args(["--set", key]);
        }
        let output = program
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("GLIBC_TUNABLES", tunables)
            .output()
            .expect("the program starts");
        let report: serde_json::Value =
            serde_json::from_slice(&output.stdout).expect("it prints a report");
        report["state_hash"].as_str().expect("it flew").to_owned()
    };
    assert_eq!(hash(""), hash(WITHOUT_FMA));
}

#[test]
fn a_recording_holds_the_ticks_to_the_last_bit_and_all_it_takes_to_fly_them_again() {
    let scenario = short(7);
    let folder = Folder::new("exact");
    let path = folder.path("flight.mcap");
    let info = scenario
        .recording_info(&scenario.tuning().expect("the gains are valid"))
        .expect("it can be recorded");
    let mut recorder = Recorder::create(&path, &info).expect("a temporary file");
    let (report, ticks) = flown(&scenario);
    for tick in &ticks {
        recorder.record(Arc::new(tick.clone())).expect("it is written");
    }
    let state_hash = u64::from_str_radix(&report.state_hash, 16).expect("a hash is hexadecimal");
    recorder.finish(RecordingEnd { state_hash, verdict: String::new() }).expect("it is closed");

    assert!(
        read_ticks(&path).expect("it is read") == ticks,
        "a tick changed on its way through the file"
    );
    let recording = read_recording(&path).expect("it is read");
    assert_eq!(recording.warning, None);
    let text =
        String::from_utf8(recording.attachments["scenario.toml"].clone()).expect("TOML is text");
    let settings: Settings = toml::from_str(&text).expect("the attached scenario is complete");
    let again = Scenario { settings, ..scenario };
    let (replayed, reticks) = flown(&again);
    assert_eq!(replayed.state_hash, report.state_hash);
    assert!(reticks == ticks, "the flight flown from its recording differs");
}
