//! `twin recover` through the real program. Its reading of damaged files is tested beside it, in `twin/record`.

use super::*;

fn flight(folder: &Folder) -> PathBuf {
    let path = folder.path("flight.mcap");
    let flown = command(&[
        "fly",
        "scenarios/hover.toml",
        "--headless",
        "--record",
        &path.display().to_string(),
    ])
    .output()
    .expect("a flight");
    assert_eq!(flown.status.code(), Some(0), "{flown:?}");
    path
}

#[test]
fn a_cut_recording_becomes_a_finished_one_that_exports_and_mirrors() {
    let folder = Folder::new("recover");
    let path = flight(&folder);
    let bytes = std::fs::read(&path).expect("a recording");
    let (cut, whole) = (folder.text("cut.mcap"), folder.text("whole.mcap"));
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).expect("a file");
    let done = command(&["recover", &cut, "-o", &whole, "--json"]).output().expect("it ends");
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one object");
    assert_eq!((&json["finished"], &json["lost_more"]), (&false.into(), &true.into()), "{json}");
    let all = twin_record::read_ticks(&path).expect("ticks");
    let read = twin_record::read_recording(Path::new(&whole)).expect("a recording");
    assert_eq!(read.ticks, all[..read.ticks.len()]);
    assert!(read.ticks.len() * 2 > all.len() && read.warning.is_none());
    assert_eq!(
        read.attachments["scenario.toml"],
        twin_record::read_recording(&path).unwrap().attachments["scenario.toml"]
    );
    let csv = folder.text("f.csv");
    let exported = command(&["export", "csv", &whole, "-o", &csv]).output().expect("it ends");
    assert_eq!(exported.status.code(), Some(0), "{exported:?}");
}

#[test]
fn an_output_that_exists_stays_and_a_useless_input_leaves_nothing() {
    let folder = Folder::new("refused");
    let (text, taken, new) =
        (folder.text("t.mcap"), folder.text("taken.mcap"), folder.text("new.mcap"));
    std::fs::write(&text, "hello, this is text").expect("a file");
    std::fs::write(&taken, "precious").expect("a file");
    let refused = command(&["recover", &text, "-o", &taken]).output().expect("it ends");
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    assert_eq!(std::fs::read(&taken).expect("it is there"), b"precious");
    let useless = command(&["recover", &text, "-o", &new]).output().expect("it ends");
    assert_eq!(useless.status.code(), Some(2), "{useless:?}");
    assert!(
        String::from_utf8_lossy(&useless.stderr).contains("t.mcap") && !Path::new(&new).exists()
    );
}
