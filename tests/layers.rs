//! Who may use whom, read from the `use` lines and paths of the source; and that its rooms stay small.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// For each module what it may use of this crate besides itself.
const MAY_USE: &[(&str, &[&str])] = &[
    ("elementary", &[]),
    ("normal", &["elementary"]),
    ("notation", &["elementary"]),
    ("tick", &["notation"]),
    ("filter", &["elementary"]),
    ("source", &["notation", "tick"]),
    ("model", &["elementary", "notation", "task"]),
    ("plant", &["elementary", "filter", "model", "normal", "notation", "source", "tick"]),
    ("residual", &["elementary", "filter", "normal", "notation", "tick"]),
    ("control", &["elementary", "filter", "notation", "source", "tick"]),
    ("task", &["elementary", "filter", "notation", "tick"]),
    // The registry of the values in force names what they belong to.
    ("tuning", &["control", "notation", "residual"]),
    ("flight", &["control", "notation", "residual", "source", "task", "tick", "tuning"]),
    ("mirror", &["elementary", "filter", "model", "notation", "source", "tick"]),
    (
        "scenario",
        &[
            "control",
            "elementary",
            "filter",
            "flight",
            "mirror",
            "model",
            "notation",
            "plant",
            "residual",
            "source",
            "task",
            "tick",
            "tuning",
        ],
    ),
    (
        "server",
        // Beyond the flight it shows, the server names what an operator may choose.
        &[
            "control",
            "elementary",
            "flight",
            "mirror",
            "model",
            "notation",
            "residual",
            "scenario",
            "source",
            "tick",
            "tuning",
        ],
    ),
    (
        "replay",
        // A page is what a console would be sent.
        &["mirror", "notation", "residual", "scenario", "server", "tick", "tuning"],
    ),
    ("suite", &["elementary", "mirror", "scenario", "tick", "tuning"]),
    (
        "evaluate",
        &["elementary", "flight", "mirror", "notation", "residual", "scenario", "tick", "tuning"],
    ),
    ("learn", &["elementary", "mirror", "normal", "notation", "residual", "scenario", "tick"]),
    (
        "cli",
        &[
            "evaluate", "learn", "mirror", "model", "notation", "plant", "replay", "residual",
            "scenario", "server", "suite", "tick",
        ],
    ),
    ("main", &["cli"]),
    ("lib", &[]),
    ("build", &[]),
];

/// Crates that only these modules may name.
const ONLY_IN: &[(&str, &[&str])] = &[
    ("rapier3d_f64", &["plant"]),
    ("parry3d_f64", &["plant"]),
    ("glam", &["plant"]),
    ("urdf_rs", &["model"]),
    ("roxmltree", &["model"]),
    ("burn", &["learn"]),
    ("burn_tensor", &["learn"]),
    ("safetensors", &["learn", "residual"]),
    ("libm", &["elementary"]),
    ("mcap", &["mirror"]),
    ("quick_junit", &["suite"]),
    ("plotters", &["evaluate", "learn", "scenario", "suite"]),
    ("glob", &["suite"]),
    ("flate2", &["replay"]),
    ("base64", &["mirror", "replay"]),
    ("tungstenite", &["mirror"]),
    ("foxglove", &["mirror", "server"]),
    ("axum", &["server"]),
    ("tokio", &["server"]),
    ("clap", &["cli"]),
    ("indicatif", &["cli"]),
];

/// What the core of the loop must not touch: files, clocks, threads, unseeded randomness.
const PURE: &[&str] =
    &["flight", "control", "residual", "task", "filter", "notation", "tick", "source", "tuning"];
const IMPURE: &[&str] = &[
    "std::fs",
    "std::net",
    "std::thread",
    "std::time",
    "std::env",
    "std::process",
    "tokio",
    "rand::rng(",
    "thread_rng",
];

/// Most lines of a file.
const MOST_LINES: usize = 400;

/// Files that the build makes.
const GENERATED: &[&str] = &["protocol.ts", "package-lock.json"];

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files below `folder` whose names end in one of `endings`, by their path in the repository.
fn files(folder: &str, endings: &[&str]) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![repository().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the repository") {
            let path = entry.expect("an entry").path();
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            if path.is_dir() {
                if name != "node_modules" && name != "dist" {
                    folders.push(path);
                }
            } else if endings.iter().any(|ending| name.ends_with(ending)) {
                let text = std::fs::read_to_string(&path).expect("source is text");
                found.push((
                    path.strip_prefix(repository()).expect("it lies in it").to_owned(),
                    text,
                ));
            }
        }
    }
    found.sort();
    found
}

/// The top-level module that a file of `twin/` belongs to.
fn module(path: &Path) -> String {
    let first = path
        .components()
        .nth(1)
        .expect("it lies in twin/")
        .as_os_str()
        .to_string_lossy()
        .into_owned();
    first.trim_end_matches(".rs").to_owned()
}

/// The text without comments and test modules: what the crate is made of.
fn code(text: &str) -> String {
    let body = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or("");
    body.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Modules of this crate named after `crate::` or `twin::`, alone or in braces.
fn uses(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for root in ["crate::", "twin::"] {
        for (at, _) in code.match_indices(root) {
            let before = code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let rest = &code[at + root.len()..];
            let names = match rest.strip_prefix('{') {
                Some(group) => top_level(group),
                None => vec![rest],
            };
            found.extend(names.into_iter().map(first_word).filter(|name| !name.is_empty()));
        }
    }
    found
}

/// The comma-separated items of a `{…}` group up to its end, nested groups kept whole.
fn top_level(group: &str) -> Vec<&str> {
    let (mut depth, mut start, mut items) = (0_usize, 0, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                items.push(group[start..at].trim());
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                items.push(group[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    items
}

fn first_word(text: &str) -> String {
    text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

fn names_crate(code: &str, name: &str) -> bool {
    [format!("{name}::"), format!("use {name};")].iter().any(|form| {
        code.match_indices(form.as_str()).any(|(at, _)| {
            let before = code[..at].chars().next_back();
            !before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':')
        })
    })
}

#[test]
fn the_reader_of_use_lines_finds_every_form() {
    let text = "use crate::tick::{Tick, Pose};\nuse crate::{flight::{Flight, Parts}, notation::N};\n\
                fn f(x: &crate::plant::Articulation) {} use mycrate::server::X; // crate::scenario\n";
    let found = uses(&code(text));
    assert_eq!(
        found.iter().map(String::as_str).collect::<Vec<_>>(),
        ["flight", "notation", "plant", "tick"]
    );
    assert!(names_crate("use mcap::Writer;", "mcap") && !names_crate("crate::mcap::x", "mcap"));
}

#[test]
fn every_module_uses_only_what_lies_below_it() {
    let allowed: BTreeMap<&str, &[&str]> = MAY_USE.iter().copied().collect();
    let mut wrong = Vec::new();
    for (path, text) in files("twin", &[".rs"]) {
        let module = module(&path);
        let Some(allowed) = allowed.get(module.as_str()) else {
            wrong.push(format!("{}: module {module:?} is not in the list", path.display()));
            continue;
        };
        for used in uses(&code(&text)) {
            let known = MAY_USE.iter().any(|(name, _)| *name == used);
            if known && used != module && !allowed.contains(&used.as_str()) {
                wrong.push(format!("{} uses {used}; {module} may use {allowed:?}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_module_of_the_crate_is_in_the_list_and_the_list_holds_no_circle() {
    let map = std::fs::read_to_string(repository().join("twin/lib.rs")).expect("the map");
    for name in map.lines().filter_map(|line| line.strip_prefix("pub mod ")) {
        let name = name.trim_end_matches(';');
        assert!(MAY_USE.iter().any(|(known, _)| *known == name), "{name}");
    }
    // Strike out what uses nothing that is left, until nothing is left.
    let mut left: BTreeMap<&str, &[&str]> = MAY_USE.iter().copied().collect();
    while !left.is_empty() {
        let free: Vec<&str> = left
            .iter()
            .filter(|(_, uses)| !uses.iter().any(|used| left.contains_key(used)))
            .map(|(n, _)| *n)
            .collect();
        assert!(!free.is_empty(), "a circle among {:?}", left.keys());
        left.retain(|name, _| !free.contains(name));
    }
}

#[test]
fn outside_crates_stay_behind_their_doors() {
    let mut wrong = Vec::new();
    for (path, text) in files("twin", &[".rs"]) {
        let (module, code) = (module(&path), code(&text));
        for (name, homes) in ONLY_IN {
            if module != "build" && !homes.contains(&module.as_str()) && names_crate(&code, name) {
                wrong.push(format!("{} names {name}; only {homes:?} may", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_loop_touches_no_file_clock_thread_or_unseeded_chance() {
    let mut wrong = Vec::new();
    for (path, text) in files("twin", &[".rs"]) {
        if PURE.contains(&module(&path).as_str()) {
            let code = code(&text);
            wrong.extend(
                IMPURE
                    .iter()
                    .filter(|word| code.contains(**word))
                    .map(|word| format!("{}: {word}", path.display())),
            );
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn rooms_are_small_and_nothing_is_left_for_later() {
    // Put together here, so that this file does not contain them.
    let later = [["to", "do!"], ["unimple", "mented!"], ["TO", "DO"], ["FIX", "ME"]]
        .map(|parts| parts.concat());
    let endings = [".rs", ".ts", ".tsx", ".css", ".html", ".mjs", ".py"];
    let mut wrong = Vec::new();
    for (path, text) in
        ["twin", "tests", "web/src"].iter().flat_map(|folder| files(folder, &endings))
    {
        if GENERATED.iter().any(|name| path.ends_with(name)) {
            continue;
        }
        let lines = text.lines().count();
        if lines > MOST_LINES {
            wrong.push(format!(
                "{} has {lines} lines, at most {MOST_LINES} are allowed",
                path.display()
            ));
        }
        wrong.extend(
            later
                .iter()
                .filter(|word| text.contains(word.as_str()))
                .map(|word| format!("{}: {word}", path.display())),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
