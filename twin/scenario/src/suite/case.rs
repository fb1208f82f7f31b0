//! One flight of a run, and the part of a run that a shard flies.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// One flight of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Index among all cases of the run, those of other shards included.
    pub index: usize,
    /// Name in reports; it is unique in a run.
    pub name: String,
    /// Scenario file.
    pub file: PathBuf,
    /// Overrides `key=value`; the seed is one of them.
    pub overrides: Vec<String>,
    /// Its sample, if the case belongs to a sweep.
    pub sample: Option<SweepSample>,
}

/// One sample of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepSample {
    /// Name of the sweep.
    pub sweep: String,
    /// Value of each key of the sweep, in the order of the keys.
    pub values: Vec<f64>,
}

/// A part of the cases: every `of`-th case from the `index`-th on, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of the shard, `1..=of`.
    pub index: usize,
    /// Number of shards.
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
