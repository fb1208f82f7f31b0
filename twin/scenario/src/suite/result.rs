//! What became of one flight.

use std::path::PathBuf;

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use super::case::Case;
use crate::Report;

/// What became of a case.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It was flown; [`Report::passed`] says whether as expected.
    Flown(Box<Report>),
    /// It could not be flown.
    Unusable(String),
    /// It was not its turn before the run was stopped.
    NotRun,
}

/// A case and what became of it.
#[derive(Clone, Debug, Deserialize)]
pub struct CaseResult {
    /// The case.
    pub case: Case,
    /// What became of it.
    pub outcome: Outcome,
    /// Wall-clock time of the flight, s.
    pub wall_s: f64,
    /// Recording of the flight, if it failed and one was asked for.
    pub artifact: Option<PathBuf>,
    /// Its page, and the second that opens at.
    pub replay: Option<(PathBuf, f64)>,
    /// Why either is missing although it was asked for.
    pub artifact_trouble: Option<String>,
}

impl Serialize for CaseResult {
    /// Beside its fields the result in a word and in a message, for whoever reads the JSON.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { case, outcome, wall_s, artifact, replay, artifact_trouble } = self;
        let mut form = serializer.serialize_struct("CaseResult", 8)?;
        form.serialize_field("result", self.word())?;
        form.serialize_field("message", &self.message())?;
        form.serialize_field("case", case)?;
        form.serialize_field("outcome", outcome)?;
        form.serialize_field("artifact", artifact)?;
        form.serialize_field("replay", replay)?;
        form.serialize_field("artifact_trouble", artifact_trouble)?;
        form.serialize_field("wall_s", wall_s)?;
        form.end()
    }
}

impl CaseResult {
    /// Flown, and as expected.
    pub fn passed(&self) -> bool {
        self.report().is_some_and(|report| report.passed)
    }

    /// What the flight came to, if it was flown.
    pub fn report(&self) -> Option<&Report> {
        match &self.outcome {
            Outcome::Flown(report) => Some(report),
            _ => None,
        }
    }

    /// The result in a word or three.
    pub fn word(&self) -> &'static str {
        match &self.outcome {
            Outcome::Flown(report) if report.passed && report.broken.is_empty() => "passed",
            Outcome::Flown(report) if report.passed => "failed as declared",
            Outcome::Flown(_) => "FAILED",
            Outcome::Unusable(_) => "ERROR",
            Outcome::NotRun => "not run",
        }
    }
}
