//! Records served flights: one file per flight. The flight never waits for a disk: not for a tick, and not for the end of a file.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use crate::server::pace::now;
use twin_core::tick::Tick;
use twin_record::{
    Outputs, Recorder, RecordingEnd, RecordingError, RecordingInfo, RecordingState, RecordingStatus,
};

/// The flag that asks for recordings.
const FLAG: &str = "--record";

/// Time that the disk has to take the rest of all recordings when the program ends.
const CLOSE_PATIENCE: Duration = Duration::from_secs(10);

/// Period at which the end of the recordings is looked for.
const LOOK: Duration = Duration::from_millis(5);

/// Records the flights one after the other, or none.
pub(super) struct FlightRecorder {
    path: Option<PathBuf>,
    outputs: Outputs,
    /// Number of the newest recording, from 1; the recordings after the first never replace a file.
    newest: u32,
    open: Option<Recorder>,
    /// Recordings of earlier flights whose last ticks are on their way to the disk, with their numbers, in order.
    closing: Vec<(u32, Recorder)>,
    /// How the newest of the recordings stood that are done, with its number.
    last: Option<(u32, RecordingStatus)>,
    /// Whether the failure of the open recording was told.
    told: bool,
    /// Whether any recording failed.
    failed: bool,
}

/// Something that happened to a recording, one sentence.
pub(super) enum News {
    /// A recording is finished.
    Finished(String),
    /// A recording failed, or lost ticks.
    Failed(String),
}

impl FlightRecorder {
    /// Records to `path`, an output of `outputs`; `None` records nothing.
    pub(super) fn new(path: Option<PathBuf>, outputs: Outputs) -> Self {
        Self {
            path,
            outputs,
            newest: 0,
            open: None,
            closing: Vec::new(),
            last: None,
            told: false,
            failed: false,
        }
    }

    /// Whether flights are recorded.
    pub(super) fn is_wanted(&self) -> bool {
        self.path.is_some()
    }

    /// Whether a recording failed, or could not be begun.
    pub(super) fn has_failed(&self) -> bool {
        self.failed
    }

    /// Opens the file of the next flight: `flight.mcap`, then `flight-2.mcap`, …, but never one of the `inputs` of the flight. The flight
    /// may last `planned_s` seconds. Returns a sentence for the operator if the first flight cannot have the name that was asked for.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be created; the flight goes on without a recording.
    pub(super) fn begin(
        &mut self,
        info: &RecordingInfo,
        inputs: &[PathBuf],
        planned_s: f64,
    ) -> Result<Option<String>, RecordingError> {
        let Some(path) = self.path.clone() else { return Ok(None) };
        self.told = false;
        self.newest += 1;
        let first = self.newest == 1;
        self.outputs.protect(inputs);
        match self.create(&path, first, info) {
            Ok((recorder, renamed)) => {
                self.open = Some(recorder.for_flight_of(planned_s));
                Ok(renamed.filter(|_| first))
            }
            Err(error) => {
                self.failed = true;
                let status = RecordingStatus {
                    file: path,
                    state: RecordingState::Failed,
                    bytes: 0,
                    ticks: 0,
                    dropped_ticks: 0,
                    error: Some(error.to_string()),
                    warning: None,
                };
                self.last = Some((self.newest, status));
                Err(error)
            }
        }
    }

    /// The recorder of a new file, and a sentence if its name is another than `path`.
    fn create(
        &self,
        path: &Path,
        first: bool,
        info: &RecordingInfo,
    ) -> Result<(Recorder, Option<String>), RecordingError> {
        let file = if first {
            self.outputs.recording(path, FLAG)
        } else {
            self.outputs.next_recording(path, FLAG)
        }?;
        let renamed = file.renamed();
        Ok((Recorder::start(file, info)?, renamed))
    }

    /// Records a tick. If the disk is too slow or the recording failed, it drops the tick and counts it. Returns the failure, once.
    pub(super) fn tick(&mut self, tick: &Arc<Tick>) -> Option<String> {
        match &mut self.open {
            None => {
                // The flight goes on without its recording.
                if let Some((_, last)) = &mut self.last
                    && last.state == RecordingState::Failed
                {
                    last.dropped_ticks += 1;
                }
                None
            }
            Some(open) => {
                if open.offer(Arc::clone(tick)) {
                    return None;
                }
                self.failure()
            }
        }
    }

    /// The failure of the open recording, once.
    fn failure(&mut self) -> Option<String> {
        let error = self.open.as_ref()?.status().error?;
        self.failed = true;
        (!std::mem::replace(&mut self.told, true)).then_some(error)
    }

    /// How the newest recording stands; `None` if nothing is recorded.
    pub(super) fn status(&self) -> Option<RecordingStatus> {
        if let Some(open) = &self.open {
            return Some(open.status());
        }
        match (self.closing.last(), &self.last) {
            (Some((number, closing)), last)
                if last.as_ref().is_none_or(|last| last.0 < *number) =>
            {
                Some(closing.status())
            }
            (_, last) => last.as_ref().map(|(_, status)| status.clone()),
        }
    }

    /// Ends the recording of the flight, without waiting for the disk; [`Self::news`] tells how it went.
    pub(super) fn end(&mut self, end: RecordingEnd) {
        if let Some(mut recorder) = self.open.take() {
            recorder.end(end);
            self.closing.push((self.newest, recorder));
        }
    }

    /// What happened to the recordings since the last call.
    pub(super) fn news(&mut self) -> Vec<News> {
        let mut news: Vec<News> = self.failure().map(News::Failed).into_iter().collect();
        let (done, closing): (Vec<_>, Vec<_>) = std::mem::take(&mut self.closing)
            .into_iter()
            .map(|(number, mut recorder)| (recorder.is_done(), (number, recorder)))
            .partition(|(done, _)| *done);
        self.closing = closing.into_iter().map(|(_, recorder)| recorder).collect();
        for (_, (number, recorder)) in done {
            news.extend(self.finished(number, recorder.status()));
        }
        news
    }

    fn finished(&mut self, number: u32, status: RecordingStatus) -> Option<News> {
        let news = match (&status.error, status.dropped_ticks) {
            (Some(error), _) => {
                self.failed = true;
                // A failure during the flight has been told.
                (!self.told).then(|| News::Failed(error.clone()))
            }
            (None, 0) => Some(News::Finished(said(&status))),
            (None, dropped) => Some(News::Failed(format!(
                "{}; the disk was too slow for {dropped} more",
                said(&status)
            ))),
        };
        // The disk may finish the files in another order.
        if self.last.as_ref().is_none_or(|last| last.0 < number) {
            self.last = Some((number, status));
        }
        news
    }

    /// Waits until all files are finished, but not for a disk that does not answer.
    pub(super) fn close(&mut self) -> Vec<News> {
        let (mut news, start) = (self.news(), now());
        while !self.closing.is_empty() {
            if start.elapsed() > CLOSE_PATIENCE {
                self.closing.iter_mut().for_each(|(_, recorder)| recorder.abandon());
            }
            std::thread::sleep(LOOK);
            news.extend(self.news());
        }
        news
    }
}

fn said(status: &RecordingStatus) -> String {
    format!("recorded {} ticks in {}", status.ticks, status.file.display())
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::fixture;
    use twin_scenario::Scenario;

    const HOVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/hover.toml");

    #[test]
    fn the_next_flight_begins_before_the_file_of_the_last_one_is_finished() {
        let folder = tempfile::tempdir().unwrap();
        let scenario = Scenario::load(Path::new(HOVER), &[]).unwrap();
        let info = scenario.recording_info(&scenario.tuning().unwrap()).unwrap();
        let mut flights =
            FlightRecorder::new(Some(folder.path().join("flight.mcap")), Outputs::default());
        for _ in 0..2 {
            flights.begin(&info, &[], 1.0).unwrap();
            // As many as the queue holds: the file cannot be finished when the flight ends.
            for index in 0..400 {
                assert_eq!(flights.tick(&Arc::new(fixture::tick(index))), None);
            }
            flights.end(RecordingEnd::default());
        }
        let told = flights.close();
        let finished = told.iter().filter(|news| matches!(news, News::Finished(_))).count();
        assert_eq!((finished, told.len(), flights.has_failed()), (2, 2, false));
        let status = flights.status().unwrap();
        assert_eq!((status.state, status.ticks), (RecordingState::Finished, 400));
        assert!(status.file.ends_with("flight-2.mcap") && status.bytes > 0);
    }

    #[test]
    fn the_newest_recording_is_told_of_in_whatever_order_the_disk_finishes_the_files() {
        let mut flights = FlightRecorder::new(Some("flight.mcap".into()), Outputs::default());
        let done = |file: &str| RecordingStatus {
            file: file.into(),
            state: RecordingState::Finished,
            bytes: 1,
            ticks: 1,
            dropped_ticks: 0,
            error: None,
            warning: None,
        };
        for (number, file) in [(2, "flight-2.mcap"), (1, "flight.mcap"), (3, "flight-3.mcap")] {
            assert!(matches!(flights.finished(number, done(file)), Some(News::Finished(_))));
            let newest = number.max(2);
            let status = flights.status().unwrap();
            assert_eq!(status.file, PathBuf::from(format!("flight-{newest}.mcap")));
        }
    }

    #[test]
    fn without_a_path_nothing_is_recorded() {
        let mut flight_recorder = FlightRecorder::new(None, Outputs::default());
        flight_recorder.end(RecordingEnd::default());
        assert!(flight_recorder.close().is_empty() && flight_recorder.status().is_none());
    }
}
