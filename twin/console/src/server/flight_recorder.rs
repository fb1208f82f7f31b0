//! Records served flights: one file per flight. A slow disk never slows the flight.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use twin_core::tick::Tick;
use twin_record::{Recorder, RecordingEnd, RecordingError, RecordingInfo};

/// Records the flights one after the other, or none.
pub(super) struct FlightRecorder {
    path: Option<PathBuf>,
    flights: u32,
    open: Option<Recorder>,
}

impl FlightRecorder {
    /// Records to `path`; `None` records nothing.
    pub(super) fn new(path: Option<PathBuf>) -> Self {
        Self { path, flights: 0, open: None }
    }

    /// Whether flights are recorded.
    pub(super) fn is_wanted(&self) -> bool {
        self.path.is_some()
    }

    /// Opens the file of the next flight: `flight.mcap`, then `flight-2.mcap`, …
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be created; the flight goes on without a recording.
    pub(super) fn begin(&mut self, info: &RecordingInfo) -> Result<(), RecordingError> {
        self.flights += 1;
        if let Some(path) = &self.path {
            self.open = Some(Recorder::create(&numbered(path, self.flights), info)?);
        }
        Ok(())
    }

    /// Records a tick. If the disk is too slow, it drops the tick and counts it.
    ///
    /// # Errors
    /// [`RecordingError`] once, when the file can no longer be written; the flight goes on without a recording.
    pub(super) fn tick(&mut self, tick: &Arc<Tick>) -> Result<(), RecordingError> {
        let Some(recorder) = &mut self.open else { return Ok(()) };
        let result = recorder.offer(Arc::clone(tick));
        if result.is_err() {
            self.open = None;
        }
        result.map(|_| ())
    }

    /// Closes the file; returns one sentence about its content, or `None` if nothing was recorded.
    ///
    /// # Errors
    /// [`RecordingError`] if anything could not be written.
    pub(super) fn end(&mut self, end: RecordingEnd) -> Result<Option<String>, RecordingError> {
        let Some(recorder) = self.open.take() else { return Ok(None) };
        let path = recorder.path().display().to_string();
        let written = recorder.finish(end)?;
        Ok(Some(match written.dropped {
            0 => format!("recorded {} ticks in {path}", written.ticks),
            dropped => format!(
                "recorded {} ticks in {path}; the disk was too slow for {dropped} more",
                written.ticks
            ),
        }))
    }
}

fn numbered(path: &Path, flight: u32) -> PathBuf {
    if flight < 2 {
        return path.to_owned();
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension =
        path.extension().map_or_else(|| "mcap".into(), |extension| extension.to_string_lossy());
    path.with_file_name(format!("{stem}-{flight}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restart_never_writes_over_the_flight_before() {
        let path = Path::new("out/flight.mcap");
        let names: Vec<PathBuf> = (1..4).map(|flight| numbered(path, flight)).collect();
        assert_eq!(
            names,
            ["out/flight.mcap", "out/flight-2.mcap", "out/flight-3.mcap"].map(PathBuf::from)
        );
    }

    #[test]
    fn without_a_path_nothing_is_recorded() {
        let mut flight_recorder = FlightRecorder::new(None);
        assert!(matches!(flight_recorder.end(RecordingEnd::default()), Ok(None)));
    }
}
