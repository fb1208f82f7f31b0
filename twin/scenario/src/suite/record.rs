//! Records a failed flight by flying it again. The seed determines the flight, so no flight needs to be recorded before it fails.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::golden::{GoldenSettings, GoldenWriter};
use crate::{BuildError, Report, Scenario, fly};
use twin_record::output::{OutputError, Outputs, make_folder};
use twin_record::{Recorder, RecordingEnd, RecordingError};

/// Beginning of every golden run.
const GOLDEN_HEAD: &[u8] = b"t_s,";

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
    /// A file cannot be created or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The file of the golden run is something else.
    #[error(
        "{file}: not replaced, because its first line is no head of a golden run; check golden.file"
    )]
    NotGolden {
        /// The file.
        file: String,
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

/// Flies `scenario` and stores the flight as its golden run, in place of the one before.
pub(super) fn golden(
    scenario: &Scenario,
    settings: &GoldenSettings,
    outputs: &Outputs,
) -> Result<Report, RecordError> {
    let mut writer = GoldenWriter::new(settings);
    let mut free = scenario.clone();
    free.settings.golden = None;
    let path = scenario.folder().join(&settings.file);
    let before = std::fs::read(&path).unwrap_or_default();
    if !before.is_empty() && !before.starts_with(GOLDEN_HEAD) {
        return Err(RecordError::NotGolden { file: path.display().to_string() });
    }
    let output = outputs.replacing().reserve_with_folder(&path, "--update")?;
    let report = fly(&free, &mut |tick| writer.add(tick))?;
    output.write(writer.finish().as_bytes())?;
    Ok(report)
}

/// Flies `scenario` again and records it at `path`, or at the next free number; `report` is the report of its first flight. Returns the
/// path of the recording.
pub(super) fn flown_again(
    scenario: &Scenario,
    report: &Report,
    path: &Path,
    outputs: &Outputs,
) -> Result<PathBuf, RecordError> {
    make_folder(path.parent().unwrap_or_else(|| Path::new(".")), "--artifacts")?;
    let info = scenario.recording_info(&scenario.tuning()?)?;
    let mut recorder = Recorder::start(outputs.recording(path, "--artifacts")?, &info)?;
    let path = recorder.path().to_owned();
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
        return Ok(path);
    }
    Err(RecordError::Differs { found: again.state_hash, expected: report.state_hash.clone() })
}

/// Writes the page of a recording to `path`, or to the next free number, and returns its path.
pub(super) fn page(path: &Path, text: &str, outputs: &Outputs) -> Result<PathBuf, OutputError> {
    let output = outputs.reserve_numbered(path, "--artifacts")?;
    let path = output.path().to_owned();
    output.write(text.as_bytes())?;
    Ok(path)
}
