//! Records a failed flight by flying it again. The seed determines the flight, so no flight needs to be recorded before it fails.

use std::path::Path;
use std::sync::Arc;

use crate::golden::{GoldenSettings, GoldenWriter};
use crate::{BuildError, Report, Scenario, fly};
use twin_record::{Recorder, RecordingEnd, RecordingError};

/// Why a flight cannot be recorded.
#[derive(Debug, thiserror::Error)]
pub(super) enum RecordError {
    /// The flight cannot be assembled.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A gain is not valid.
    #[error(transparent)]
    Tuning(#[from] twin_core::tuning::TuningError),
    /// The file cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The folder cannot be created.
    #[error("{folder}: cannot make the folder: {reason}; choose another with --artifacts")]
    Folder {
        /// The folder.
        folder: String,
        /// The error of the system.
        reason: String,
    },
    /// The golden run cannot be stored.
    #[error("{file}: cannot store the golden run: {reason}; check golden.file")]
    Golden {
        /// The file.
        file: String,
        /// The error of the system.
        reason: String,
    },
    /// The second flight differs from the first.
    #[error(
        "the second flight has the state hash {found}, the first had {expected}: the flight is not deterministic"
    )]
    Differs {
        /// State hash of the second flight.
        found: String,
        /// State hash of the first flight.
        expected: String,
    },
}

/// Flies `scenario` and stores the flight as its golden run.
pub(super) fn golden(
    scenario: &Scenario,
    settings: &GoldenSettings,
) -> Result<Report, RecordError> {
    let mut writer = GoldenWriter::new(settings);
    let mut free = scenario.clone();
    free.settings.golden = None;
    let report = fly(&free, &mut |tick| writer.add(tick))?;
    let folder = scenario.file.parent().unwrap_or_else(|| Path::new("."));
    let path = folder.join(&settings.file);
    let refused = |error: std::io::Error| RecordError::Golden {
        file: path.display().to_string(),
        reason: error.to_string(),
    };
    std::fs::create_dir_all(path.parent().unwrap_or(folder)).map_err(refused)?;
    std::fs::write(&path, writer.finish()).map_err(refused)?;
    Ok(report)
}

/// Flies `scenario` again and records it at `path`; `report` is the report of its first flight.
pub(super) fn flown_again(
    scenario: &Scenario,
    report: &Report,
    path: &Path,
) -> Result<(), RecordError> {
    let folder = path.parent().unwrap_or_else(|| Path::new("."));
    std::fs::create_dir_all(folder).map_err(|error| RecordError::Folder {
        folder: folder.display().to_string(),
        reason: error.to_string(),
    })?;
    let mut recorder = Recorder::create(path, &scenario.recording_info(&scenario.tuning()?)?)?;
    let mut trouble = None;
    let again = fly(scenario, &mut |tick| {
        if trouble.is_none() {
            trouble = recorder.record(Arc::new(tick.clone())).err();
        }
    })?;
    if let Some(trouble) = trouble {
        return Err(trouble.into());
    }
    recorder.finish(RecordingEnd {
        state_hash: u64::from_str_radix(&again.state_hash, 16).unwrap_or_default(),
        verdict: format!("{}: {}", again.verdict, again.reason),
    })?;
    if again.state_hash == report.state_hash {
        return Ok(());
    }
    Err(RecordError::Differs { found: again.state_hash, expected: report.state_hash.clone() })
}
