//! What clients are told about gains.

use serde::{Deserialize, Serialize};
use ts_rs::TS;

/// One value an operator may change.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct GainInfo {
    /// Unique name, `slope.x`.
    pub name: String,
    /// Symbol as in the paper.
    pub label: String,
    /// Group it is shown under.
    pub group: String,
    /// Unit, empty if none.
    pub unit: String,
    /// What it does, one sentence.
    pub help: String,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Step of a slider.
    pub step: f64,
    /// Value in force.
    pub value: f64,
    /// Value of the preset chosen last.
    pub preset_value: f64,
}

/// A gain that took effect.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct GainEcho {
    /// Name of the gain.
    pub name: String,
    /// Value in force.
    pub value: f64,
    /// First tick flown with it.
    pub tick: u64,
    /// Preset all values now agree with.
    pub preset: PresetName,
}

/// All gains.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct GainList {
    /// Every gain with its value in force.
    pub gains: Vec<GainInfo>,
    /// Preset all values agree with.
    pub preset: PresetName,
    /// First tick flown with them.
    pub tick: u64,
}

/// Name of a set of gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum PresetName {
    /// The paper's table and nothing else.
    Literal,
    /// The table with the protections.
    Paper,
    /// The default.
    Tuned,
    /// None of the others.
    Custom,
}
