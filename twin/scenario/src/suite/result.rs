//! The result of one case.

use std::path::PathBuf;

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use super::case::Case;
use crate::Report;

/// The outcome of a case.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The case was flown; [`Report::passed`] says whether the flight met its demands.
    Flown(Box<Report>),
    /// The case could not be flown; the text gives the reason.
    Unusable(String),
    /// The run stopped before the case was flown.
    NotRun,
}

/// A case and its outcome.
#[derive(Clone, Debug, Deserialize)]
pub struct CaseResult {
    /// The case.
    pub case: Case,
    /// Its outcome.
    pub outcome: Outcome,
    /// Wall-clock time of the flight, s.
    pub wall_s: f64,
    /// Recording of the flight, if it failed and evidence was asked for.
    pub artifact: Option<PathBuf>,
    /// Replay page of the flight, and the second of the flight at which it opens.
    pub replay: Option<(PathBuf, f64)>,
    /// Why recording or page is missing although evidence was asked for.
    pub artifact_trouble: Option<String>,
}

impl Serialize for CaseResult {
    /// Writes the fields, and for readers of the JSON also the result as a word and as a message.
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
    /// True if the case was flown and met its demands.
    pub fn passed(&self) -> bool {
        self.report().is_some_and(|report| report.passed)
    }

    /// The report of the flight, if the case was flown.
    pub fn report(&self) -> Option<&Report> {
        match &self.outcome {
            Outcome::Flown(report) => Some(report),
            _ => None,
        }
    }

    /// The result in one to three words.
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
