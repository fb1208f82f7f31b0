//! `twin evaluate residual` through the real program, with short flights.

use std::process::Command;

use twin_core::source::EFFECTS;

use super::folder::Folder;

#[test]
fn the_table_has_every_effect_in_every_output() {
    let folder = Folder::new("residual");
    let (csv, html) = (folder.path("r.csv"), folder.path("r.html"));
    let run = Command::new(env!("CARGO_BIN_EXE_twin"))
        .args(["evaluate", "residual", "scenarios/collect_0g.toml", "--json"])
        .args(["--seconds", "10", "--seeds", "2"])
        .arg("--csv")
        .arg(&csv)
        .arg("--html")
        .arg(&html)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program runs");
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let table: serde_json::Value = serde_json::from_slice(&run.stdout).expect("one JSON object");
    let variants = EFFECTS.len() + 2;
    // Two seeds: one fits, one scores.
    assert_eq!(table["flights"].as_array().map(Vec::len), Some(2 * variants));
    assert_eq!(table["foresight"].as_array().map(Vec::len), Some(variants));
    assert!(table["foresight"][0]["horizons"][0]["ratio"].is_f64());
    let sums = |row: &serde_json::Value| {
        let bands = row["band_variance"].as_array().expect("bands").iter();
        let sum: f64 = bands.filter_map(serde_json::Value::as_f64).sum();
        // Roundings of a sum of a thousand numbers.
        (sum / row["variance"].as_f64().expect("a variance") - 1.0).abs() < 1e-12
    };
    assert!(table["rows"].as_array().expect("rows").iter().all(sums));
    let text = |path| std::fs::read_to_string(path).expect("an output");
    let (csv, html) = (text(csv), text(html));
    for effect in EFFECTS {
        let without =
            |shares: &serde_json::Value| shares["variant"]["without"].as_str() == Some(effect);
        assert!(table["effects"].as_array().expect("effects").iter().any(without), "{effect}");
        assert!(csv.contains(&format!("share,without {effect},x,all,")), "{effect}");
        assert!(html.contains(&format!("without {effect}")), "{effect}");
    }
}
