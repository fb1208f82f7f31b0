//! The keys in which two scenarios differ.

use serde::{Deserialize, Serialize};
use toml::Value;

use super::settings::Settings;

/// A key whose value is another one in the second scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Dotted key; elements of lists by their index.
    pub key: String,
    /// Value of the first scenario as TOML; `-` if it has none.
    pub from: String,
    /// Value of the second scenario as TOML; `-` if it has none.
    pub to: String,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {} -> {}", self.key, self.from, self.to)
    }
}

/// The keys in which `one` and `other` differ, in alphabetical order.
pub fn differences(one: &Settings, other: &Settings) -> Vec<Difference> {
    let mut found = Vec::new();
    // Settings are TOML by construction, so a side that is not cannot occur.
    if let (Ok(one), Ok(other)) = (Value::try_from(one), Value::try_from(other)) {
        compare("", Some(&one), Some(&other), &mut found);
    }
    found
}

/// Adds the differences at and below `key`. Lists of another length, and lists of numbers, are one value.
fn compare(key: &str, one: Option<&Value>, other: Option<&Value>, found: &mut Vec<Difference>) {
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match (one, other) {
        (Some(Value::Table(one)), Some(Value::Table(other))) => {
            let added = other.keys().filter(|name| !one.contains_key(*name));
            let mut names: Vec<&String> = one.keys().chain(added).collect();
            names.sort();
            for name in names {
                compare(&below(name), one.get(name), other.get(name), found);
            }
        }
        (Some(Value::Array(one)), Some(Value::Array(other)))
            if one.len() == other.len() && one.iter().all(Value::is_table) =>
        {
            for (index, pair) in one.iter().zip(other).enumerate() {
                compare(&below(&index.to_string()), Some(pair.0), Some(pair.1), found);
            }
        }
        _ if one == other => {}
        _ => {
            let text = |value: Option<&Value>| value.map_or_else(|| "-".into(), Value::to_string);
            found.push(Difference { key: key.to_owned(), from: text(one), to: text(other) });
        }
    }
}
