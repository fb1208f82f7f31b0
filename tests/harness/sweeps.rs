//! Sweeps: samples, the share that must succeed, and shards whose reports merge.

use serde_json::Value;

use super::{Folder, TOO_LOW, twin};

/// Twelve flights of half a second at 0.7 to 1.3 m. With the check `TOO_LOW`, those up to 1 m succeed, which are about half.
fn sweep(min_success: f64) -> String {
    format!(
        "{TOO_LOW}[sweep]\nsamples = 12\nseed = 5\nmin_success = {min_success}\n[[sweep.ranges]]\n\
         key = \"task.start_position_m.2\"\nfrom = 0.7\nto = 1.3\n[[sweep.ranges]]\nkey = \"seed\"\nfrom = 1.0\nto = 99.0\n"
    )
}

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).expect("one JSON object")
}

/// Removes the numbers that depend on the clock of the machine from the report.
fn timeless(value: &mut Value) {
    match value {
        Value::Object(table) => {
            for key in ["wall_s", "real_time_factor"] {
                table.remove(key);
            }
            table.values_mut().for_each(timeless);
        }
        Value::Array(list) => list.iter_mut().for_each(timeless),
        _ => {}
    }
}

#[test]
fn enough_samples_must_succeed_and_the_interval_is_told() {
    let folder = Folder::new("share");
    for (min_success, code) in [(0.3, 0), (0.9, 1)] {
        let file = folder.hover(&format!("share_{code}"), &sweep(min_success));
        let output = folder.test(&[&file, "--json"]);
        assert_eq!(output.status.code(), Some(code), "{min_success}");
        let report = json(&output.stdout);
        let found = &report["sweeps"][0];
        assert_eq!(
            (&report["passed"], &report["failed"]),
            (&Value::from(1 - code), &Value::from(code))
        );
        assert_eq!(found["flown"], 12);
        // The stratum decides whether a sample starts above the bound: six strata lie up to 1 m. The vehicle moves by
        // millimetres, so only the samples of the two strata next to the bound may differ.
        let succeeded = found["succeeded"].as_u64().expect("a count");
        assert!((5..=7).contains(&succeeded), "{found}");
        let [low, high] = [0, 1].map(|end| found["interval_95"][end].as_f64().expect("a number"));
        let share = succeeded as f64 / 12.0;
        assert!(low < share && share < high, "{found}");
    }
}

#[test]
fn shards_merge_to_the_report_of_the_whole_run() {
    let folder = Folder::new("shards");
    let files = [folder.hover("alone", ""), folder.hover("many", &sweep(0.3))];
    let whole = folder.test(&[&files[0], &files[1], "--json"]);
    assert_eq!(whole.status.code(), Some(0));
    let parts: Vec<String> = (1..=4)
        .map(|index| {
            let shard = format!("{index}/4");
            let jobs = if index % 2 == 0 { "1" } else { "3" };
            let part =
                folder.test(&[&files[0], &files[1], "--json", "--shard", &shard, "--jobs", jobs]);
            assert_eq!(part.status.code(), Some(0), "a part of a sweep is not judged");
            let path = folder.path(&format!("{index}.json"));
            std::fs::write(&path, part.stdout).expect("a temporary file");
            path
        })
        .collect();
    let merge = |paths: &[&String]| {
        let mut arguments = vec!["test", "merge", "--json"];
        arguments.extend(paths.iter().map(|path| path.as_str()));
        twin(&arguments)
    };
    // The order of the shards does not matter.
    let merged = merge(&[&parts[2], &parts[0], &parts[3], &parts[1]]);
    assert_eq!(merged.status.code(), Some(0), "{}", String::from_utf8_lossy(&merged.stderr));
    let (mut whole, mut merged) = (json(&whole.stdout), json(&merged.stdout));
    timeless(&mut whole);
    timeless(&mut merged);
    assert_eq!(whole.to_string(), merged.to_string());

    for (paths, wanted) in [
        (vec![&parts[0], &parts[1], &parts[2]], "in no report"),
        (vec![&parts[0], &parts[0]], "give each shard once"),
    ] {
        let refused = merge(&paths);
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && said.contains(wanted), "{said}");
    }
}

#[test]
fn the_page_has_the_picture_of_the_sweep_and_a_dot_for_every_sample() {
    let folder = Folder::new("page");
    let (file, page) = (folder.hover("seen", &sweep(0.3)), folder.path("h.html"));
    assert_eq!(folder.test(&[&file, "--html", &page]).status.code(), Some(0));
    let text = std::fs::read_to_string(&page).expect("the page");
    assert!(text.contains("task.start_position_m.2") && text.contains("95 % interval"));
    let succeeded = text.matches("<circle").count();
    // A cross is two lines; the legend has one dot of each kind.
    assert!((5 + 1..=7 + 1).contains(&succeeded), "{succeeded} circles");
}
