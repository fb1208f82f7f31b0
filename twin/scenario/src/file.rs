//! Reads a scenario: the file overrides the defaults, and `--set key=value` overrides the file. Every error names place and key.
//!
//! The text of the defaults is also the schema: a key that it does not contain is unknown, and a value of another type is wrong. Keys
//! without a default value (optional keys, elements of a list that is empty by default, tables with free names) stand in its table
//! `example`, which is removed before the values are used. In that table the first element of a list stands for every element, and a key
//! `"*"` for any name.

use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use super::document::{Entry, Origin, dotted};
use super::merge::{Finding, Schema};
use twin_input::budget::SCENARIO_BYTES;

/// Largest number of segments in the key of an override; scenarios nest half as deep.
const MAX_SEGMENTS: usize = 16;

/// Reason why a scenario is not usable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be opened or is not text.
    #[error("{}: {reason}; expected a readable TOML file in UTF-8, check the path", .file.display())]
    Unreadable {
        /// The scenario.
        file: PathBuf,
        /// Error of the operating system.
        reason: String,
    },
    /// The text is not TOML, or has more lists and values than the budget allows.
    #[error("{place}: {found}")]
    Syntax {
        /// File and line, or the text of the override.
        place: String,
        /// Message of the parser.
        found: String,
    },
    /// A key is unknown, or its value is not allowed.
    #[error("{place}: {key}: found {found}; expected {allowed}{hint}")]
    Key {
        /// File and line, or the text of the override.
        place: String,
        /// Dotted key.
        key: String,
        /// Value or key that was found.
        found: String,
        /// Allowed values or keys.
        allowed: String,
        /// The likely mistake and its correction; may be empty.
        hint: String,
    },
    /// A value has the right type but makes no sense for the simulator, or a key is missing.
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

/// The scenario in `file`, which overrides `defaults` (the text of the defaults file); `overrides` (each `key=value`) override both.
///
/// # Errors
/// [`ScenarioError`] if the file cannot be read, and the errors of [`read_text`].
pub fn read<T: DeserializeOwned>(
    file: &Path,
    defaults: &str,
    overrides: &[String],
) -> Result<T, ScenarioError> {
    let text = twin_input::file::read_text(file, SCENARIO_BYTES).map_err(|error| {
        ScenarioError::Unreadable { file: file.to_path_buf(), reason: error.to_string() }
    })?;
    read_text(&text, file, defaults, overrides)
}

/// The scenario in `text`, the content of `file`; see [`read`].
///
/// # Errors
/// The first of: bad syntax, unknown key, wrong type, NaN, infinity, value out of range.
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

/// The scenario in `text`, which a recording contains. Keys that are newer than the recording get their defaults, and ranges are not
/// checked, because the scenario was already flown.
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

/// The tree of the override `key.key=value`. A value that is not TOML is read as text, so words need no quotes.
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

/// Names of the files, for the places in errors.
struct Names<'a> {
    file: &'a Path,
    overrides: &'a [String],
}

impl Names<'_> {
    /// The tree of `text` merged over that of `defaults`, then the overrides.
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
