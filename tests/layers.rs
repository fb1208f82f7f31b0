//! Who may use whom: the list of the architecture against the `use crate::…` lines of the code.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Layer, and the layers it may use. `main` (the `cli` folder) may use all.
const MAY_USE: &[(&str, &[&str])] = &[
    ("notation", &[]),
    ("filter", &[]),
    ("tick", &["notation"]),
    ("source", &["tick", "notation"]),
    ("model", &["notation"]),
    ("plant", &["model", "source", "tick", "notation", "filter"]),
    ("residual", &["tick", "notation", "filter"]),
    ("control", &["source", "tick", "notation", "filter"]),
    ("task", &["model", "tick", "notation", "filter"]),
    ("tuning", &["control", "residual", "notation"]),
    ("flight", &["source", "residual", "control", "task", "tuning", "tick", "notation"]),
    ("mirror", &["source", "model", "tick", "notation"]),
    (
        "scenario",
        &[
            "flight", "plant", "mirror", "residual", "control", "task", "model", "source",
            "tuning", "tick", "notation",
        ],
    ),
    ("server", &["flight", "scenario", "mirror", "model", "source", "tuning", "tick", "notation"]),
];

/// Foreign crates that one layer alone may know.
const ONLY_IN: &[(&str, &[&str])] = &[
    ("rapier3d_f64", &["plant"]),
    ("urdf_rs", &["model"]),
    ("mcap", &["mirror"]),
    ("foxglove", &["mirror"]),
    ("axum", &["server"]),
    ("tokio", &["server"]),
];

fn sources(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, out);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            out.push(path);
        }
    }
}

/// Production text of every file under `twin/` by layer: tests are cut off.
fn by_layer() -> BTreeMap<String, Vec<(PathBuf, String)>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("twin");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut layers: BTreeMap<String, Vec<(PathBuf, String)>> = BTreeMap::new();
    for file in files {
        let inside = file.strip_prefix(&root).unwrap().to_path_buf();
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let is_test = ["tests", "refusals", "fixture", "typescript"].contains(&name.as_str());
        let layer =
            inside.components().next().unwrap().as_os_str().to_string_lossy().replace(".rs", "");
        if !is_test {
            let text = std::fs::read_to_string(&file).unwrap();
            let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned();
            layers.entry(layer).or_default().push((inside, text));
        }
    }
    layers
}

/// Words that follow `prefix` on lines that are no comment.
fn words_after<'a>(text: &'a str, prefix: &'a str) -> impl Iterator<Item = String> + 'a {
    text.lines().filter(|line| !line.trim_start().starts_with("//")).flat_map(move |line| {
        line.match_indices(prefix).map(move |(at, _)| {
            line[at + prefix.len()..]
                .chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect()
        })
    })
}

#[test]
fn every_layer_uses_only_what_it_may() {
    let layers = by_layer();
    let mut broken = Vec::new();
    for (layer, allowed) in MAY_USE {
        for (file, text) in layers.get(*layer).into_iter().flatten() {
            for used in words_after(text, "crate::") {
                let known = MAY_USE.iter().any(|(name, _)| *name == used);
                if known && used != *layer && !allowed.contains(&used.as_str()) {
                    broken.push(format!("{} uses {used}", file.display()));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn every_module_has_a_place_in_the_list() {
    let outside = ["lib", "main", "build", "cli"];
    let missing: Vec<String> = by_layer()
        .into_keys()
        .filter(|layer| {
            !outside.contains(&layer.as_str()) && !MAY_USE.iter().any(|(name, _)| name == layer)
        })
        .collect();
    assert!(missing.is_empty(), "say in this test what these may use: {missing:?}");
}

#[test]
fn foreign_crates_stay_in_their_layer() {
    let mut broken = Vec::new();
    for (layer, files) in by_layer() {
        for (krate, homes) in ONLY_IN {
            for (file, text) in &files {
                let used = text.lines().any(|line| {
                    !line.trim_start().starts_with("//") && line.contains(&format!("{krate}::"))
                });
                if used && !homes.contains(&layer.as_str()) && layer != "build" {
                    broken.push(format!("{} uses {krate}", file.display()));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Longest hand-written file, lines.
const LONGEST: usize = 400;

#[test]
fn rooms_are_small_and_nothing_is_left_for_later() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    sources(&root.join("twin"), &mut files);
    sources(&root.join("tests"), &mut files);
    let later = ["TO", "DO"].concat();
    for file in
        files.iter().filter(|file| !file.components().any(|c| c.as_os_str() == "node_modules"))
    {
        let text = std::fs::read_to_string(file).unwrap();
        assert!(
            text.lines().count() <= LONGEST,
            "{} is longer than {LONGEST} lines",
            file.display()
        );
        assert!(!text.contains(&later), "{} leaves something for later", file.display());
    }
}
