//! One flight to make, and which of many.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// One flight to make.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Its place among all cases, those of other shards among them.
    pub index: usize,
    /// What it is called in reports; no two cases of a run share a name.
    pub name: String,
    /// Scenario file.
    pub file: PathBuf,
    /// `key=value` overrides, the seed among them.
    pub overrides: Vec<String>,
    /// Which sample of which sweep it is.
    pub sample: Option<Sample>,
}

/// One flight of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Name of the sweep.
    pub sweep: String,
    /// Value of each of its keys.
    pub values: Vec<f64>,
}

/// A part of the cases: every `of`-th, from the `index`-th on, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which, `1..=of`.
    pub index: usize,
    /// How many there are.
    pub of: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(index, of)| {
            Some(Self { index: index.trim().parse().ok()?, of: of.trim().parse().ok()? })
        });
        parsed
            .filter(|shard| (1..=shard.of).contains(&shard.index))
            .ok_or_else(|| format!("found {text:?}, expected K/N with K in 1..=N, for example 2/4"))
    }
}
