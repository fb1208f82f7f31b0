//! The prediction table: every entrant over one recording, errors by horizon beside the paper's.

use std::path::PathBuf;

use serde::Serialize;

use super::entrants::{Candidate, Paper};
use super::replay::{Replayed, replay};
use super::series::{Series, Statistics};

/// One line.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name for machines.
    pub name: String,
    /// Name for people.
    pub label: String,
    /// Numbers that were learned.
    pub parameters: Option<usize>,
    /// Hash of the data that the weights say they were trained on.
    pub trained_on: Option<String>,
    /// File of weights.
    pub weights: Option<PathBuf>,
    /// RMSE, R², ms of the paper.
    pub paper: Paper,
    /// What was found.
    #[serde(flatten)]
    pub replayed: Replayed,
}

/// The table with what it was made from.
#[derive(Clone, Debug, Serialize)]
pub struct PredictionTable {
    /// Always `prediction`.
    pub table: &'static str,
    /// The command that makes it again.
    pub command: String,
    /// The recording.
    pub recording: PathBuf,
    /// Sha-256 of the recording.
    pub recording_sha256: String,
    /// Seed of the recorded flight.
    pub seed: String,
    /// The recordings whose statistics z-score everything.
    pub training: Vec<PathBuf>,
    /// Their hash.
    pub data_hash: String,
    /// Mean and standard deviation of inputs and residual over them.
    pub statistics: Statistics,
    /// The lines.
    pub rows: Vec<Row>,
}

/// Replays `series` through the candidates, one after the other, so that their times can be compared; `done` is told the name of
/// each as it ends.
pub fn rows(
    candidates: Vec<Candidate>,
    series: &Series,
    statistics: &Statistics,
    done: &dyn Fn(&str),
) -> Vec<Row> {
    let mut rows = Vec::new();
    for mut candidate in candidates {
        let replayed = replay(&mut candidate.entrant, series, statistics);
        done(&candidate.name);
        let Candidate { name, label, parameters, trained_on, weights, paper, .. } = candidate;
        rows.push(Row { name, label, parameters, trained_on, weights, paper, replayed });
    }
    rows
}
