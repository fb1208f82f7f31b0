//! Records served flights: one file per flight. A slow disk never slows the flight.

use std::path::PathBuf;
use std::sync::Arc;

use twin_core::tick::Tick;
use twin_record::{Outputs, Recorder, RecordingEnd, RecordingError, RecordingInfo};

/// The flag that asks for recordings.
const FLAG: &str = "--record";

/// Records the flights one after the other, or none.
pub(super) struct FlightRecorder {
    path: Option<PathBuf>,
    outputs: Outputs,
    /// Whether a flight was recorded; the further ones never replace a file.
    begun: bool,
    open: Option<Recorder>,
}

impl FlightRecorder {
    /// Records to `path`, an output of `outputs`; `None` records nothing.
    pub(super) fn new(path: Option<PathBuf>, outputs: Outputs) -> Self {
        Self { path, outputs, begun: false, open: None }
    }

    /// Whether flights are recorded.
    pub(super) fn is_wanted(&self) -> bool {
        self.path.is_some()
    }

    /// Opens the file of the next flight: `flight.mcap`, then `flight-2.mcap`, …, but never one of the `inputs` of the flight. Returns a
    /// sentence for the operator if the first flight cannot have the name that was asked for.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be created; the flight goes on without a recording.
    pub(super) fn begin(
        &mut self,
        info: &RecordingInfo,
        inputs: &[PathBuf],
    ) -> Result<Option<String>, RecordingError> {
        let Some(path) = &self.path else { return Ok(None) };
        self.outputs.protect(inputs);
        let first = !std::mem::replace(&mut self.begun, true);
        let file = if first {
            self.outputs.recording(path, FLAG)
        } else {
            self.outputs.next_recording(path, FLAG)
        }?;
        let renamed = file.renamed().filter(|_| first);
        self.open = Some(Recorder::start(file, info)?);
        Ok(renamed)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_path_nothing_is_recorded() {
        let mut flight_recorder = FlightRecorder::new(None, Outputs::default());
        assert!(matches!(flight_recorder.end(RecordingEnd::default()), Ok(None)));
    }
}
