//! Golden runs: `--update` stores them, a flight must stay within their tolerances, and a message names the first divergence.

use super::Folder;

const GOLDEN: &str = "[golden]\nfile = \"stored/run.csv\"\nevery_s = 0.1\n[golden.tolerance]\nheight_m = 0.002\ntilt_rad = 0.01\n";

#[test]
fn a_flight_is_stored_repeated_and_told_where_it_first_diverges() {
    let folder = Folder::new("golden");
    let file = folder.hover("repeated", GOLDEN);
    let said = |arguments: &[&str], code: i32| {
        let output = folder.test(arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(code), "{text}");
        text
    };
    let missing = said(&[&file], 1);
    assert!(missing.contains("no file") && missing.contains("--update"), "{missing}");
    said(&[&file, "--update"], 0);
    let stored = std::fs::read_to_string(folder.path("stored/run.csv")).expect("it is stored");
    // A second of flight has ten lines and their header.
    assert_eq!(
        (stored.lines().next(), stored.lines().count()),
        (Some("t_s,height_m,tilt_rad"), 11)
    );
    said(&[&file], 0);

    // A push at 0.42 s: the lines before it do not differ, the line at 0.5 s does.
    let push = "disturbances=[{at_s=0.42,kind='push',force_n=[6.0,0.0,9.0],duration_s=0.3}]";
    let parted = said(&[&file, "--set", push], 1);
    assert!(
        parted.contains("golden run height_m") || parted.contains("golden run tilt_rad"),
        "{parted}"
    );
    assert!(
        parted.contains("broken at 0.50 s") && parted.contains("as in stored/run.csv"),
        "{parted}"
    );
    assert!(parted.contains("opens at 0.50 s"), "{parted}");
}

#[test]
fn an_update_replaces_a_golden_run_and_no_other_file() {
    let folder = Folder::new("golden-other");
    // The file that the scenario names is the scenario itself, or somebody's notes.
    for name in ["other.toml", "notes.txt"] {
        let file = folder.hover("other", &GOLDEN.replace("stored/run.csv", name));
        std::fs::write(folder.path("notes.txt"), "mine").expect("a temporary file");
        let before = std::fs::read_to_string(folder.path(name)).expect("it is there");
        let output = folder.test(&[&file, "--update"]);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(name) && said.contains("check golden.file"), "{said}");
        assert_eq!(std::fs::read_to_string(folder.path(name)).expect("it is there"), before);
    }
}

#[test]
fn a_golden_run_of_an_unknown_signal_is_refused() {
    let folder = Folder::new("golden-signal");
    let file = folder.hover("signal", &GOLDEN.replace("height_m", "hight_m"));
    let output = folder.test(&[&file]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("golden.tolerance") && said.contains("height_m"), "{said}");
}
