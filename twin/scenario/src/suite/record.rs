//! The evidence of a failure: the same flight once more, recorded. A flight is its seed, so it need not be recorded while it
//! is not known to fail.

use std::path::Path;
use std::sync::Arc;

use crate::golden::{GoldenSettings, GoldenWriter};
use crate::{BuildError, Report, Scenario, fly};
use twin_record::{Recorder, RecordingEnd, RecordingError};

/// Why there is no recording.
#[derive(Debug, thiserror::Error)]
pub(super) enum RecordError {
    /// The flight cannot be put together.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The gains are not valid.
    #[error(transparent)]
    Tuning(#[from] twin_core::tuning::TuningError),
    /// The file cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The folder cannot be made.
    #[error("{folder}: cannot make the folder: {reason}; choose another with --artifacts")]
    Folder {
        /// The folder.
        folder: String,
        /// The system's words.
        reason: String,
    },
    /// The golden run cannot be stored.
    #[error("{file}: cannot store the golden run: {reason}; check golden.file")]
    Golden {
        /// The file.
        file: String,
        /// The system's words.
        reason: String,
    },
    /// The flight is not the same twice.
    #[error(
        "flown again the state hash is {found}, it was {expected}: the flight is not deterministic"
    )]
    Differs {
        /// Of this time.
        found: String,
        /// Of the first time.
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

/// Flies `scenario`, whose first flight came to `report`, again and records it at `path`.
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
