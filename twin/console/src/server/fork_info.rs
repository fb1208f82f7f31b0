//! What clients are told about a fork.

use serde::Serialize;
use ts_rs::TS;

/// A fork of the flight.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct ForkInfo {
    /// Its identifier, which no other fork of this server has.
    pub id: u32,
    /// Its place among the colours, from 0; no other fork has it at the same time.
    pub slot: u32,
    /// For people.
    pub name: String,
    /// Time of the flight before which it begins, s.
    pub at_s: f64,
    /// Keys that were to change, `key=value` each.
    pub set: Vec<String>,
    /// Keys that differ from the flight at that moment; empty until it flies.
    pub changed: Vec<ForkChange>,
    /// How far it is.
    pub state: ForkState,
    /// Rows that `/api/forks/{id}/{from}` has.
    pub ticks: u64,
    /// Time up to which it has flown, s.
    pub flown_s: f64,
    /// How it ended; `null` until then, and for a fork that still flew after a minute.
    pub outcome: Option<ForkOutcome>,
    /// Its metrics from the fork on, beside those of the flight as it would have gone on; empty until both are flown.
    pub metrics: Vec<ForkMetric>,
}

/// How far a fork is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, TS)]
#[serde(rename_all = "snake_case")]
pub enum ForkState {
    /// Other forks fly before it.
    Waiting,
    /// It flies.
    Flying,
    /// It has flown, and so has the flight beside it.
    Flown,
    /// It was refused; the outcome says why.
    Failed,
}

/// The end of a fork.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, TS)]
pub struct ForkOutcome {
    /// The verdict, one word.
    pub verdict: String,
    /// Its reason, one sentence.
    pub reason: String,
}

/// A key that a fork changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, TS)]
pub struct ForkChange {
    /// Dotted key.
    pub key: String,
    /// Value before, as TOML.
    pub from: String,
    /// Value of the fork, as TOML.
    pub to: String,
}

/// A metric of a fork and of the flight.
#[derive(Clone, Debug, PartialEq, Serialize, TS)]
pub struct ForkMetric {
    /// Name with its unit.
    pub metric: String,
    /// Value of the fork.
    pub value: Option<f64>,
    /// Value of the flight.
    pub parent: Option<f64>,
    /// Fork minus flight.
    pub difference: Option<f64>,
    /// `better`, `worse`, `equal`, `in one only`, or empty if neither more nor less of it is better.
    pub judgement: String,
}
