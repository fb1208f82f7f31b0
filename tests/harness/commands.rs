//! Exit codes, refusals and `twin diff`.

use super::{Folder, TOO_LOW, twin};

#[test]
fn exit_codes_tell_passed_failed_and_could_not_run_apart() {
    let folder = Folder::new("codes");
    let good = folder.hover("good", "");
    let bad = folder.hover("bad", TOO_LOW);
    let declared = folder.hover("declared", &format!("{TOO_LOW}[expect]\nfails = \"height_m\"\n"));
    let unkept = folder.hover("unkept", "[expect]\nfails = \"height_m\"\n");
    let unusable = folder.hover("unusable", "wrong_key = 1\n");
    for (files, code) in [
        (vec![&good], 0),
        (vec![&good, &declared], 0),
        (vec![&good, &bad], 1),
        (vec![&unkept], 1),
        (vec![&good, &bad, &unusable], 2),
    ] {
        let files: Vec<&str> = files.iter().map(|file| file.as_str()).collect();
        let output = folder.test(&files);
        let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(code), "{files:?}: {stdout}");
    }
    let absent = twin(&["test", "absent/*.toml"]);
    assert_eq!(absent.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&absent.stderr).contains("absent/*.toml"));
}

#[test]
fn checks_that_could_not_fail_or_be_judged_are_refused_with_their_key() {
    let folder = Folder::new("refused");
    for (name, more, wanted) in [
        (
            "signal",
            "[[checks]]\nsignal = \"hight_m\"\nmax = 1.0\n",
            ["checks.0.signal", "height_m"],
        ),
        ("limit", "[[checks]]\nsignal = \"height_m\"\n", ["checks.0.max", "cannot fail"]),
        (
            "quantile",
            "[[checks]]\nsignal = \"height_m\"\nstatistic = \"quantile\"\nmax = 1.0\n",
            ["checks.0.quantile", "0.0..=1.0"],
        ),
        (
            "window",
            "[[checks]]\nsignal = \"height_m\"\nfrom_s = 2.0\nto_s = 1.0\nmax = 1.0\n",
            ["checks.0.to_s", "ends before"],
        ),
        (
            "rotor",
            "[[faults]]\nat_s = 0.5\nkind = \"motor_efficiency\"\nrotor = 4\nfactor = 0.5\n",
            ["faults.rotor", "0..=3"],
        ),
    ] {
        let output = folder.test(&[&folder.hover(name, more)]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{name}: {stderr}");
        assert!(wanted.iter().all(|word| stderr.contains(word)), "{name}: {stderr}");
    }
}

#[test]
fn fail_fast_begins_nothing_after_a_failure() {
    let folder = Folder::new("fast");
    let files = [folder.hover("a", TOO_LOW), folder.hover("b", ""), folder.hover("c", "")];
    let mut arguments = vec!["--fail-fast", "--jobs", "1", "--json"];
    arguments.extend(files.iter().map(String::as_str));
    let output = folder.test(&arguments);
    assert_eq!(output.status.code(), Some(1));
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(value["failed"], 1);
    assert_eq!(value["not_run"], 2);
}

#[test]
fn two_recordings_are_compared_to_the_first_tick_and_channel_that_differ() {
    let folder = Folder::new("diff");
    let [a, b, c] = ["a.mcap", "b.mcap", "c.mcap"].map(|name| folder.path(name));
    let push = "disturbances=[{at_s=0.6,kind='push',force_n=[1.0,0.0,0.0],duration_s=0.2}]";
    for (file, more) in [(&a, "seed=1"), (&b, "seed=1"), (&c, push)] {
        let flown = twin(&[
            "fly",
            "scenarios/hover.toml",
            "--headless",
            "--set",
            "task.duration_s=1.0",
            "--set",
            more,
            "--record",
            file,
        ]);
        assert!(flown.status.success(), "{}", String::from_utf8_lossy(&flown.stderr));
    }
    let same = twin(&["diff", &a, &b]);
    assert_eq!(same.status.code(), Some(0), "{}", String::from_utf8_lossy(&same.stdout));
    let other = twin(&["diff", &a, &c, "--json"]);
    assert_eq!(other.status.code(), Some(1));
    let value: serde_json::Value = serde_json::from_slice(&other.stdout).expect("one JSON object");
    // The push acts within the tick that begins at 0.6 s: number 60, measured at 0.61 s.
    assert_eq!(value["first"]["tick"], 60, "{}", value["first"]);
    assert!(value["first"]["channel"].as_str().is_some_and(|c| c.starts_with("measurement.")));
    assert!(value["channels"].as_array().is_some_and(|channels| !channels.is_empty()));
    assert_eq!(twin(&["diff", &a, "absent.mcap"]).status.code(), Some(2));
}
