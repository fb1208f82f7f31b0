//! Which crate may use which (by `Cargo.toml`), which module of `core` may use which (by `use` lines), and that files stay short.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::reading::{plain, without_tests};

/// For each crate below `twin/`, from the lowest to the highest, the crates of this workspace that it may use.
const CRATES: &[(&str, &[&str])] = &[
    ("input", &[]),
    ("core", &[]),
    ("plant", &["core", "input"]),
    ("record", &["core", "input", "plant"]),
    ("foreign", &["core", "input", "plant", "record"]),
    ("scenario", &["core", "input", "plant", "record"]),
    ("console", &["core", "foreign", "input", "plant", "record", "scenario"]),
    ("lab", &["core", "foreign", "input", "plant", "record", "scenario"]),
];

/// For each module of `core` the other modules of `core` that it may use.
const MODULES_OF_CORE: &[(&str, &[&str])] = &[
    ("elementary", &[]),
    ("normal", &["elementary"]),
    ("notation", &["elementary"]),
    ("quantity", &["notation"]),
    ("force_budget", &[]),
    ("foreseen", &["notation"]),
    ("tick", &["force_budget", "foreseen", "notation"]),
    ("source", &["notation", "quantity", "tick"]),
    ("filter", &["elementary"]),
    // The registry of the values in force names the types that hold them.
    ("tuning", &["control", "notation", "quantity", "residual"]),
    ("control", &["elementary", "filter", "notation", "source", "tick"]),
    ("residual", &["elementary", "filter", "foreseen", "normal", "notation", "tick"]),
    ("task", &["elementary", "filter", "notation", "tick"]),
    (
        "flight",
        &["control", "foreseen", "notation", "residual", "source", "task", "tick", "tuning"],
    ),
    ("fixture", &["elementary", "foreseen", "notation", "tick"]),
];

/// External packages that only these crates may depend on; `root` is the program with its tests.
const ONLY_IN: &[(&str, &[&str])] = &[
    ("rapier3d-f64", &["plant"]),
    ("urdf-rs", &["plant"]),
    ("roxmltree", &["plant"]),
    ("libm", &["core"]),
    ("burn-tensor", &["lab"]),
    ("safetensors", &["core", "lab"]),
    ("rustfft", &["lab"]),
    ("mcap", &["record", "foreign"]),
    ("foxglove", &["record", "foreign", "console"]),
    ("tungstenite", &["foreign"]),
    ("quick-junit", &["scenario"]),
    ("glob", &["scenario"]),
    ("plotters", &["scenario", "lab"]),
    ("flate2", &["console"]),
    ("axum", &["console"]),
    ("hyper", &["console"]),
    ("hyper-util", &["console"]),
    ("tokio", &["console"]),
    ("tokio-tungstenite", &["console"]),
    ("clap", &["root"]),
    ("indicatif", &["root"]),
    ("anyhow", &["root"]),
    ("signal-hook", &["root"]),
    ("rustix", &["record"]),
];

/// Features that the crate `core` must not use: files, clocks, threads, unseeded randomness.
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

/// Calls that make, replace or rename a file, or print past [`OPENER`].
const OPENING: &[&str] = &[
    "File::create",
    "File::options",
    "OpenOptions",
    "fs::write",
    "fs::rename",
    "fs::copy",
    "fs::hard_link",
    "fs::create_dir",
    "fs::remove_file",
    "io::stdout",
    "io::stderr().write",
    "print!(",
    "println!(",
];

/// The module that opens every output.
const OPENER: &str = "twin/record/src/output";

/// Largest number of lines of a file.
const MOST_LINES: usize = 400;

/// Files that the build generates.
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

/// The text without comments and test modules.
fn code(text: &str) -> String {
    let body = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or("");
    body.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Modules that are named after `crate::`, alone or in braces.
fn uses(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, root) in code.match_indices("crate::") {
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
    found
}

/// The comma-separated items of a `{…}` group up to its end; nested groups stay whole.
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

#[test]
fn the_reader_of_use_lines_finds_every_form() {
    let text = "use crate::tick::{Tick, Pose};\nuse crate::{flight::{Flight, Parts}, notation::N};\n\
                fn f(x: &crate::plant::Articulation) {} use mycrate::server::X; // crate::scenario\n";
    let found = uses(&code(text));
    assert_eq!(
        found.iter().map(String::as_str).collect::<Vec<_>>(),
        ["flight", "notation", "plant", "tick"]
    );
}

/// The names under `[dependencies]` in the `Cargo.toml` of a crate below `twin/`, or of the program for `root`.
fn dependencies(name: &str) -> BTreeSet<String> {
    let folder =
        if name == "root" { repository().into() } else { repository().join("twin").join(name) };
    let text =
        std::fs::read_to_string(folder.join("Cargo.toml")).expect("every crate has a manifest");
    let manifest: toml::Table = text.parse().expect("cargo reads it too");
    manifest["dependencies"].as_table().expect("a table").keys().cloned().collect()
}

#[test]
fn every_crate_depends_only_on_crates_below_it() {
    let mut lower = BTreeSet::new();
    for (name, allowed) in CRATES {
        for used in *allowed {
            assert!(
                lower.contains(used),
                "{name} may use {used}, which does not stand below it in CRATES"
            );
        }
        lower.insert(*name);
        for used in dependencies(name) {
            if let Some(used) = used.strip_prefix("twin-") {
                assert!(
                    allowed.contains(&used),
                    "{name} depends on {used}; it may depend on {allowed:?}"
                );
            }
        }
    }
}

#[test]
fn every_crate_is_in_the_list() {
    let folders = std::fs::read_dir(repository().join("twin")).expect("the crates lie there");
    let found: BTreeSet<String> = folders
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.join("Cargo.toml").exists())
        .map(|path| path.file_name().expect("a name").to_string_lossy().into_owned())
        .collect();
    let listed: BTreeSet<String> = CRATES.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(found, listed);
}

#[test]
fn packages_of_others_stay_behind_their_doors() {
    for name in CRATES.iter().map(|(name, _)| *name).chain(["root"]) {
        for used in dependencies(name) {
            if let Some((_, homes)) = ONLY_IN.iter().find(|(package, _)| *package == used) {
                assert!(homes.contains(&name), "{name} depends on {used}; only {homes:?} may");
            }
        }
    }
}

/// Name of the module of `core` that a file belongs to.
fn module(path: &Path) -> String {
    let below = path.strip_prefix("twin/core/src").expect("it lies in core");
    let first = below.components().next().expect("a name").as_os_str().to_string_lossy();
    first.trim_end_matches(".rs").to_owned()
}

#[test]
fn every_module_of_core_uses_only_what_the_list_allows() {
    let allowed: BTreeMap<&str, &[&str]> = MODULES_OF_CORE.iter().copied().collect();
    let mut wrong = Vec::new();
    for (path, text) in files("twin/core/src", &[".rs"]) {
        let module = module(&path);
        if module == "lib" {
            continue;
        }
        let Some(allowed) = allowed.get(module.as_str()) else {
            wrong.push(format!("{}: module {module:?} is not in the list", path.display()));
            continue;
        };
        for used in uses(&code(&text)) {
            let known = MODULES_OF_CORE.iter().any(|(name, _)| *name == used);
            if known && used != module && !allowed.contains(&used.as_str()) {
                wrong.push(format!("{} uses {used}; {module} may use {allowed:?}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_list_of_modules_of_core_holds_no_circle() {
    // Removes modules that use none of the remaining ones, until none can be removed.
    let mut left: BTreeMap<&str, &[&str]> = MODULES_OF_CORE.iter().copied().collect();
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
fn the_loop_touches_no_file_clock_thread_or_unseeded_chance() {
    let mut wrong = Vec::new();
    for (path, text) in files("twin/core/src", &[".rs"]) {
        let code = code(&text);
        wrong.extend(
            IMPURE
                .iter()
                .filter(|word| code.contains(**word))
                .map(|word| format!("{}: {word}", path.display())),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn only_the_opener_makes_files_and_prints() {
    let mut wrong = Vec::new();
    let mut found = BTreeSet::new();
    for (path, text) in files("twin", &[".rs"]) {
        let name = path.file_name().expect("a name").to_string_lossy();
        let test = name.ends_with("tests.rs") || name == "typescript.rs";
        if test || name == "build.rs" {
            continue;
        }
        let code = without_tests(&plain(&text));
        for call in OPENING.iter().filter(|call| code.contains(**call)) {
            if path.starts_with(OPENER) {
                found.insert(*call);
            } else {
                wrong.push(format!("{}: {call}; open it through {OPENER}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // The reader finds calls where they are.
    assert!(found.contains("OpenOptions") && found.contains("io::stdout"), "{found:?}");
}

#[test]
fn rooms_are_small_and_nothing_is_left_for_later() {
    // The words are put together here, so that this file does not contain them.
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
