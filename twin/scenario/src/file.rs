//! Reads a scenario: the defaults, over them the file, over it `--set key=value`; every finding names its place and key.
//!
//! The text of the defaults is also the schema: a key that it does not hold is unknown, a value of another type than
//! its is wrong. Keys without a default value (optional ones, elements of a list that is empty by default, tables
//! with free names) stand in its table `example`, which is taken out before the values are used. There a list's first
//! element stands for all, and a key `"*"` for any name.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use super::document::{Entry, Origin, dotted};
use super::merge::{Finding, Schema};

/// Most segments of an override's key; scenarios nest half as deep.
const MAX_SEGMENTS: usize = 16;

/// Why a scenario is not usable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be opened or is not text.
    #[error("{}: {reason}; expected a readable TOML file in UTF-8, check the path", .file.display())]
    Unreadable {
        /// The scenario.
        file: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// The text is not TOML.
    #[error("{place}: not TOML: {found}; correct the syntax, https://toml.io shows it")]
    Syntax {
        /// File and line, or the text of the override.
        place: String,
        /// What the parser met.
        found: String,
    },
    /// A key is unknown, or its value is not allowed.
    #[error("{place}: {key}: found {found}; expected {allowed}{hint}")]
    Key {
        /// File and line, or the text of the override.
        place: String,
        /// Dotted key.
        key: String,
        /// What stands there.
        found: String,
        /// What may stand there.
        allowed: String,
        /// The likely slip and its remedy; may be empty.
        hint: String,
    },
    /// A value of the right type that the simulator has no use for, or a key that is missing.
    #[error("{place}: {key}: {reason}; compare with defaults.toml")]
    Value {
        /// File and line, or the text of the override.
        place: String,
        /// Dotted key.
        key: String,
        /// What was found and what is allowed.
        reason: String,
    },
    /// An override has no `=` or no key.
    #[error("--set {text:?}: expected key=value, for example payload.mass_kg=0.3")]
    Override {
        /// The override as given.
        text: String,
    },
}

/// The scenario in `file`, over `defaults` (the text of the defaults file), under `overrides` (each `key=value`).
///
/// # Errors
/// Where the file cannot be read, and as [`read_text`].
pub fn read<T: DeserializeOwned>(
    file: &Path,
    defaults: &str,
    overrides: &[String],
) -> Result<T, ScenarioError> {
    let text = std::fs::read_to_string(file).map_err(|error| ScenarioError::Unreadable {
        file: file.to_path_buf(),
        reason: error.to_string(),
    })?;
    read_text(&text, file, defaults, overrides)
}

/// The scenario in `text`, the content of `file`; see [`read`].
///
/// # Errors
/// For bad syntax, unknown keys, wrong types, NaN, infinity and values out of range: at the first of them.
pub fn read_text<T: DeserializeOwned>(
    text: &str,
    file: &Path,
    defaults: &str,
    overrides: &[String],
) -> Result<T, ScenarioError> {
    let names = Names { file, overrides };
    let merged = names.merged(text, defaults)?;
    merged.check_values().map_err(|finding| names.describe(finding))?;
    names.typed(&merged)
}

/// The scenario in `text` as a recording holds it, which was flown: keys that are younger than the recording have their defaults,
/// and ranges are not asked for.
///
/// # Errors
/// For bad syntax, unknown keys and wrong types.
pub fn read_recorded<T: DeserializeOwned>(
    text: &str,
    file: &Path,
    defaults: &str,
) -> Result<T, ScenarioError> {
    let names = Names { file, overrides: &[] };
    names.typed(&names.merged(text, defaults)?)
}

fn segment(segment: &serde_path_to_error::Segment) -> Option<String> {
    use serde_path_to_error::Segment;
    match segment {
        Segment::Seq { index } => Some(index.to_string()),
        Segment::Map { key } => Some(key.clone()),
        Segment::Enum { .. } | Segment::Unknown => None,
    }
}

/// The tree that `key.key=value` stands for. A value that is not TOML is taken as text, so that words need no quotes.
fn parse_override(text: &str, index: usize) -> Result<Entry, ScenarioError> {
    let refused = || ScenarioError::Override { text: text.to_owned() };
    let (key, value) = text.split_once('=').ok_or_else(refused)?;
    let segments: Vec<&str> = key.split('.').map(str::trim).collect();
    if segments.len() > MAX_SEGMENTS || segments.iter().any(|segment| segment.is_empty()) {
        return Err(refused());
    }
    let place = Origin::Override(index);
    Ok(Entry::nested(&segments, Entry::parse_value(value.trim(), place), place))
}

/// What places are called.
struct Names<'a> {
    file: &'a Path,
    overrides: &'a [String],
}

impl Names<'_> {
    /// The tree of `text` over that of `defaults`, under the overrides.
    fn merged(&self, text: &str, defaults: &str) -> Result<Entry, ScenarioError> {
        let mut merged = self.parse(defaults, Origin::Default)?;
        let schema = Schema::new(&mut merged);
        let given = self.parse(text, Origin::File)?;
        merged.merge(given, &schema).map_err(|finding| self.describe(finding))?;
        for (index, text) in self.overrides.iter().enumerate() {
            let entry = parse_override(text, index)?;
            merged.merge(entry, &schema).map_err(|finding| self.describe(finding))?;
        }
        Ok(merged)
    }

    fn typed<T: DeserializeOwned>(&self, merged: &Entry) -> Result<T, ScenarioError> {
        serde_path_to_error::deserialize(merged.to_toml()).map_err(|error| {
            let path: Vec<String> = error.path().iter().filter_map(segment).collect();
            ScenarioError::Value {
                place: self.name(merged.place_of(&path)),
                key: dotted(&path),
                reason: error.into_inner().message().trim().to_owned(),
            }
        })
    }

    fn parse(&self, text: &str, place: fn(u32) -> Origin) -> Result<Entry, ScenarioError> {
        Entry::parse(text, place)
            .map_err(|(line, found)| ScenarioError::Syntax { place: self.name(place(line)), found })
    }

    fn name(&self, place: Origin) -> String {
        match place {
            Origin::Default(line) => format!("defaults.toml:{line}"),
            Origin::File(line) => format!("{}:{line}", self.file.display()),
            Origin::Override(index) => {
                format!("--set {:?}", self.overrides.get(index).map_or("", String::as_str))
            }
        }
    }

    fn describe(&self, finding: Finding) -> ScenarioError {
        let Finding { place, key, found, allowed, hint } = finding;
        ScenarioError::Key { place: self.name(place), key, found, allowed, hint }
    }
}

#[cfg(test)]
mod tests;
