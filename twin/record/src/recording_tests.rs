use std::sync::Arc;

use tempfile::TempDir;

use super::*;
use crate::fixture;
use crate::{Recorder, RecordingEnd, RecordingInfo};

/// More ticks than two chunks hold, so that a cut leaves at least one whole chunk.
const TICKS: u64 = 250;

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn info() -> RecordingInfo {
    RecordingInfo {
        scenario: "unit".to_owned(),
        scenario_toml: "seed = 7\n".to_owned(),
        seed: 7,
        gains_json: "{}".to_owned(),
        limits_json: "{}".to_owned(),
        predictor_json: "{}".to_owned(),
        kernel: "scalar".to_owned(),
        urdf: "<robot name=\"r\"/>".to_owned(),
        scene: fixture::scene(),
        joint_names: vec!["joint1".to_owned(), "joint2".to_owned()],
        mirrored: false,
        per_kilogram: false,
    }
}

fn record(path: &Path, ticks: &[Tick]) {
    let mut recorder = Recorder::create(path, &info()).unwrap();
    for tick in ticks {
        recorder.record(Arc::new(tick.clone())).unwrap();
    }
    let end = RecordingEnd { state_hash: 0xabc, verdict: "placed".to_owned() };
    let written = recorder.finish(end).unwrap();
    assert_eq!((written.ticks, written.dropped), (ticks.len() as u64, 0));
}

#[test]
fn ticks_read_are_the_ticks_written_and_metadata_and_files_come_along() {
    let ticks: Vec<Tick> = (0..TICKS).map(fixture::tick).collect();
    let folder = folder();
    let path = folder.path().join("whole.mcap");
    record(&path, &ticks);
    let read = read_recording(&path).unwrap();
    // Equality of f64 compares all bits except for the sign of zero; the JSON text of both sides compares that, too.
    assert_eq!(read.ticks, ticks);
    assert_eq!(serde_json::to_string(&read.ticks).unwrap(), serde_json::to_string(&ticks).unwrap());
    assert_eq!(read.warning, None);
    assert_eq!(read.metadata["seed"], "7");
    assert_eq!(read.metadata["state_hash"], "0000000000000abc");
    assert_eq!(read.metadata["ticks"], TICKS.to_string());
    assert_eq!(read.attachments["scenario.toml"], b"seed = 7\n");
    assert_eq!(read.attachments["vehicle.urdf"], b"<robot name=\"r\"/>");
}

#[test]
fn a_cut_file_is_read_to_its_last_whole_chunk_and_says_so() {
    let ticks: Vec<Tick> = (0..TICKS).map(fixture::tick).collect();
    let folder = folder();
    let path = folder.path().join("cut.mcap");
    record(&path, &ticks);
    let bytes = std::fs::read(&path).unwrap();
    let data_end = bytes.len() - 1;
    let mut most = 0;
    for part in 1..=20 {
        std::fs::write(&path, &bytes[..data_end * part / 20]).unwrap();
        match read_recording(&path) {
            Ok(read) => {
                assert_eq!(read.ticks, ticks[..read.ticks.len()]);
                assert!(read.ticks.len() as u64 == TICKS || read.warning.is_some());
                most = most.max(read.ticks.len());
            }
            Err(error) => assert!(matches!(error, RecordingError::NoTicks { .. }), "{error}"),
        }
    }
    assert!(most >= 200, "two whole chunks of 100 ticks were expected, {most} ticks read");
}

#[test]
fn a_damaged_byte_never_yields_a_wrong_tick() {
    let ticks: Vec<Tick> = (0..TICKS).map(fixture::tick).collect();
    let folder = folder();
    let path = folder.path().join("damaged.mcap");
    record(&path, &ticks);
    let bytes = std::fs::read(&path).unwrap();
    for part in 1..60 {
        let mut damaged = bytes.clone();
        damaged[bytes.len() * part / 60] ^= 0x10;
        std::fs::write(&path, &damaged).unwrap();
        if let Ok(read) = read_recording(&path) {
            assert_eq!(read.ticks, ticks[..read.ticks.len()], "byte {}", bytes.len() * part / 60);
        }
    }
}

#[test]
fn a_text_file_an_empty_file_and_no_file_are_clear_errors() {
    let folder = folder();
    let path = folder.path().join("text.mcap");
    std::fs::write(&path, "hello, this is text").unwrap();
    let text = read_ticks(&path).unwrap_err().to_string();
    assert!(text.contains("not an MCAP file") && text.contains("hello, t"), "{text}");
    std::fs::write(&path, "").unwrap();
    assert!(matches!(read_ticks(&path), Err(RecordingError::NotMcap { .. })));
    assert!(matches!(
        read_ticks(&folder.path().join("absent.mcap")),
        Err(RecordingError::Read { .. })
    ));
}

#[test]
fn a_recorder_that_is_dropped_leaves_a_whole_file_without_an_end() {
    let folder = folder();
    let path = folder.path().join("dropped.mcap");
    let mut recorder = Recorder::create(&path, &info()).unwrap();
    recorder.record(Arc::new(fixture::tick(0))).unwrap();
    drop(recorder);
    let read = read_recording(&path).unwrap();
    assert_eq!((read.ticks.len(), read.warning), (1, None));
    assert!(!read.metadata.contains_key("state_hash"));
}

#[test]
fn what_is_flushed_can_be_read_while_the_recorder_still_writes() {
    let folder = folder();
    let path = folder.path().join("live.mcap");
    let mut recorder = Recorder::create(&path, &info()).unwrap();
    for index in 0..150 {
        recorder.record(Arc::new(fixture::tick(index))).unwrap();
    }
    // A chunk is closed after half a second; the rest is for a loaded machine.
    let readable = (0..100).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(50));
        read_ticks(&path).is_ok_and(|ticks| ticks.len() == 150)
    });
    assert!(readable, "the file was not readable within 5 s");
    recorder.finish(RecordingEnd::default()).unwrap();
}

#[test]
fn a_folder_that_does_not_exist_is_an_error_that_names_the_file() {
    let path = folder().path().join("no-such-folder/x.mcap");
    let error = Recorder::create(&path, &info()).unwrap_err().to_string();
    assert!(error.contains("x.mcap") && error.contains("--record"), "{error}");
}
