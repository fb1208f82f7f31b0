//! Turns a selection into the list of flights.

use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::case::{Case, Shard};
use super::sweep::{self, SweepPlan};
use twin_input::work;

/// The flights of a run, or of one shard of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// The flights of this shard.
    pub cases: Vec<Case>,
    /// The sweeps to which samples belong.
    pub sweeps: Vec<SweepPlan>,
    /// Number of flights of all shards.
    pub total: usize,
    /// The shard, if this is a part of a run.
    pub shard: Option<Shard>,
}

/// A selection of flights.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Scenario files, folders of them, and patterns such as `scenarios/fault_*.toml`.
    pub paths: Vec<String>,
    /// Seeds for each scenario; if empty, the scenario's own seed. A sweep keeps its own seed.
    pub seeds: Vec<u64>,
    /// Number of repetitions of each flight outside of sweeps; every repetition must give the same state hash.
    pub iterations: usize,
    /// Text that the name of a case must contain.
    pub filter: Option<String>,
    /// The shard to fly.
    pub shard: Option<Shard>,
    /// Overrides `key=value` for every scenario.
    pub overrides: Vec<String>,
}

/// Why a selection contains no flight.
#[derive(Debug, thiserror::Error)]
pub enum SelectionError {
    /// A pattern is malformed.
    #[error("{pattern:?}: {reason}; expected a file, a folder, or a pattern with *, ? and [..]")]
    Pattern {
        /// The pattern as given.
        pattern: String,
        /// The error in it.
        reason: String,
    },
    /// A path matches no scenario.
    #[error(
        "{path:?}: no scenario found; expected a .toml file, a folder that has some, or a pattern that matches one"
    )]
    Nothing {
        /// The path as given.
        path: String,
    },
    /// The filter matches no case.
    #[error(
        "--filter {filter:?}: none of the {count} cases has it in its name; the first is {first:?}"
    )]
    Filter {
        /// The filter as given.
        filter: String,
        /// Number of cases before the filter.
        count: usize,
        /// Name of the first case.
        first: String,
    },
}

/// The flights of `selection` in a fixed order: files as given, files of a folder or pattern by name, then seeds, then
/// repetitions.
///
/// # Errors
/// [`SelectionError`] if a path, pattern or filter matches nothing. An empty shard is no error.
pub fn plan(selection: &Selection) -> Result<Plan, SelectionError> {
    let (mut files, mut known) = (Vec::new(), HashSet::new());
    for path in &selection.paths {
        for file in scenarios(path)? {
            if known.insert(file.clone()) {
                files.push(file);
            }
        }
    }
    let mut stems: HashMap<String, usize> = HashMap::new();
    for file in &files {
        *stems.entry(stem(file)).or_default() += 1;
    }
    let mut sweeps = Vec::new();
    let mut cases = Vec::new();
    for file in &files {
        let name = name(file, &stems);
        match sweep::expand(&name, file, &selection.overrides) {
            Some((plan, samples)) => {
                sweeps.push(plan);
                cases.extend(samples);
            }
            None => cases.extend(flights(file, &name, selection)),
        }
    }
    if let Some(filter) = &selection.filter {
        let (count, first) = (cases.len(), cases.first().map(|case| case.name.clone()));
        cases.retain(|case| case.name.contains(filter.as_str()));
        if cases.is_empty() {
            let first = first.unwrap_or_default();
            return Err(SelectionError::Filter { filter: filter.clone(), count, first });
        }
    }
    let mut samples: HashMap<&str, usize> = HashMap::new();
    for sample in cases.iter().filter_map(|case| case.sample.as_ref()) {
        work::steps(1);
        *samples.entry(&sample.sweep).or_default() += 1;
    }
    sweeps.retain_mut(|plan: &mut SweepPlan| {
        work::steps(1);
        plan.samples = samples.get(&*plan.name).copied().unwrap_or(0);
        plan.samples > 0
    });
    for (index, case) in cases.iter_mut().enumerate() {
        case.index = index;
    }
    let total = cases.len();
    if let Some(Shard { index, of }) = selection.shard {
        cases = cases.into_iter().skip(index - 1).step_by(of).collect();
    }
    Ok(Plan { cases, sweeps, total, shard: selection.shard })
}

/// Name of the file without its extension; files of the same name in different folders keep the folder in their name.
fn name(file: &Path, stems: &HashMap<String, usize>) -> String {
    work::steps(1);
    let stem = stem(file);
    let alone = stems.get(&stem).is_some_and(|count| *count == 1);
    if alone { stem } else { file.with_extension("").display().to_string() }
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn flights(file: &Path, name: &str, selection: &Selection) -> Vec<Case> {
    let seeds: Vec<Option<u64>> = match selection.seeds.as_slice() {
        [] => vec![None],
        seeds => seeds.iter().copied().map(Some).collect(),
    };
    let mut cases = Vec::new();
    for seed in seeds {
        for iteration in 1..=selection.iterations.max(1) {
            let mut name = name.to_owned();
            let mut overrides = selection.overrides.clone();
            if let Some(seed) = seed {
                let _ = write!(name, " seed {seed}");
                overrides.push(format!("seed={seed}"));
            }
            if selection.iterations > 1 {
                let _ = write!(name, " run {iteration}");
            }
            cases.push(Case { index: 0, name, file: file.to_owned(), overrides, sample: None });
        }
    }
    cases
}

/// Scenario files at `path`, without the defaults, which are no scenario.
fn scenarios(path: &str) -> Result<Vec<PathBuf>, SelectionError> {
    let nothing = || SelectionError::Nothing { path: path.to_owned() };
    let named = Path::new(path);
    if named.is_file() {
        return Ok(vec![named.to_owned()]);
    }
    let pattern = if named.is_dir() {
        named.join("*.toml").to_string_lossy().into_owned()
    } else {
        path.to_owned()
    };
    let found = glob::glob(&pattern).map_err(|error| SelectionError::Pattern {
        pattern: pattern.clone(),
        reason: error.to_string(),
    })?;
    let mut files: Vec<PathBuf> = found.filter_map(Result::ok).collect();
    files.retain(|file| {
        file.extension().is_some_and(|ending| ending == "toml") && !file.ends_with("defaults.toml")
    });
    files.sort();
    if files.is_empty() { Err(nothing()) } else { Ok(files) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selection(paths: &[&str]) -> Selection {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
        let paths = paths.iter().map(|p| folder.join(p).display().to_string()).collect();
        Selection { paths, iterations: 1, ..Selection::default() }
    }

    fn names(selection: &Selection) -> Vec<String> {
        plan(selection).unwrap().cases.into_iter().map(|case| case.name).collect()
    }

    #[test]
    fn files_folders_and_patterns_meet_each_scenario_once_and_never_the_defaults() {
        let all = names(&selection(&[""]));
        assert!(all.len() > 10 && !all.iter().any(|name| name == "defaults"), "{all:?}");
        assert_eq!(names(&selection(&["hover.toml", "ho*.toml", "hover.toml"])), ["hover"]);
        assert!(names(&selection(&["b_*"])).len() == 4);
        assert!(matches!(plan(&selection(&["absent*"])), Err(SelectionError::Nothing { .. })));
        assert!(matches!(plan(&selection(&["[x"])), Err(SelectionError::Pattern { .. })));
    }

    #[test]
    fn seeds_and_repeats_multiply_and_every_case_has_its_own_name() {
        let mut wanted = selection(&["hover.toml", "free_flight.toml"]);
        (wanted.seeds, wanted.iterations) = (vec![3, 5], 2);
        let found = names(&wanted);
        assert_eq!(found.len(), 2 * 2 * 2);
        assert_eq!(found[0], "hover seed 3 run 1");
        let distinct: std::collections::BTreeSet<&String> = found.iter().collect();
        assert_eq!(distinct.len(), found.len());
        wanted.filter = Some("seed 5".into());
        assert_eq!(names(&wanted).len(), 4);
        wanted.filter = Some("absent".into());
        assert!(plan(&wanted).unwrap_err().to_string().contains("none of the 8 cases"));
    }

    #[test]
    fn shards_share_all_cases_without_overlap() {
        let whole = selection(&[""]);
        let mut found: Vec<String> = (1..=3)
            .flat_map(|index| {
                names(&Selection { shard: Some(Shard { index, of: 3 }), ..whole.clone() })
            })
            .collect();
        let mut all = names(&whole);
        found.sort();
        all.sort();
        assert_eq!(found, all);
        for wrong in ["0/3", "4/3", "1", "a/b", "1/0", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong:?}");
        }
    }
}
