//! Writes ticks to an MCAP file, which other programs open unaided and a replay reads back exactly.
//!
//! In: [`Tick`]s. Out: the views as `foxglove.*` messages (`/tf`, `/scene`, `/joint_states`, `/log`), and the lossless `/twin/tick`
//! and `/twin/measurement`. One thread writes. Every half second it closes and flushes a chunk, so the file of a killed run can be
//! read to its last chunk. Log time is simulated time. A thread that flies never waits for the disk if it uses [`Recorder::offer`] and
//! [`Recorder::end`]; the queue between the two threads is bounded.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::output::RecordingFile;
use crate::progress::Progress;
use crate::recording::RecordingError;
use crate::recording_info::{RecordingEnd, RecordingInfo};
use crate::recording_status::{RecordingState, RecordingStatus};
use crate::space::shortage;
use crate::track::TrackWriter;
use twin_core::tick::Tick;

/// Ticks that may wait for the disk: 5 s of flight.
const QUEUE_TICKS: usize = 500;

/// Wall-clock time after which a chunk is closed …
const CHUNK_WALL: Duration = Duration::from_millis(500);

/// … and the number of ticks after which it is closed, whichever comes first.
const CHUNK_TICKS: u32 = 100;

/// Count of the ticks that were written and dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Ticks in the file.
    pub ticks: u64,
    /// Ticks that [`Recorder::offer`] dropped because the queue was full.
    pub dropped: u64,
}

/// The metadata of the end and the number of dropped ticks; `None` if the recording ends without a word.
type Ending = Arc<Mutex<Option<(RecordingEnd, u64)>>>;

/// A recording that is being written.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    /// The queue of the thread that writes; it ends when this is `None`.
    ticks: Option<SyncSender<Arc<Tick>>>,
    ending: Ending,
    thread: Option<JoinHandle<Result<u64, RecordingError>>>,
    progress: Arc<Progress>,
    offered: u64,
    dropped: u64,
    result: Option<Result<u64, String>>,
    warning: Option<String>,
}

impl Recorder {
    /// Creates the file at `path`, which must not exist, and writes the metadata of the start.
    ///
    /// # Errors
    /// [`RecordingError`] if the file cannot be created or written.
    pub fn create(path: &Path, info: &RecordingInfo) -> Result<Self, RecordingError> {
        Self::start(RecordingFile::new(path)?, info)
    }

    /// Writes the metadata of the start to a new file; [`crate::Outputs::recording`] opens it.
    ///
    /// # Errors
    /// [`RecordingError::Create`] if the file cannot be written.
    pub fn start(file: RecordingFile, info: &RecordingInfo) -> Result<Self, RecordingError> {
        let path = file.path().to_owned();
        let progress = Arc::new(Progress::default());
        let track = TrackWriter::start(file, info, Arc::clone(&progress))?;
        let (ticks, queue) = sync_channel(QUEUE_TICKS);
        let ending = Ending::default();
        let (their_ending, told) = (Arc::clone(&ending), Arc::clone(&progress));
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || write_all(track, &queue, &their_ending).inspect_err(|_| told.fail()))
            .map_err(|error| RecordingError::create(&path, error))?;
        Ok(Self {
            path,
            ticks: Some(ticks),
            ending,
            thread: Some(thread),
            progress,
            offered: 0,
            dropped: 0,
            result: None,
            warning: None,
        })
    }

    /// Compares the free space with a flight of `planned_s` seconds. If it will not last, it says so in the log and in the status.
    #[must_use]
    pub fn for_flight_of(mut self, planned_s: f64) -> Self {
        self.warning = shortage(&self.path, planned_s);
        if let Some(warning) = &self.warning {
            tracing::warn!("{warning}");
        }
        self
    }

    /// Records a tick. It waits for the disk if the queue is full, so no tick is lost.
    ///
    /// # Errors
    /// [`RecordingError::Write`] if the file can no longer be written; the tick then counts as dropped.
    pub fn record(&mut self, tick: Arc<Tick>) -> Result<(), RecordingError> {
        self.offered += 1;
        match self.ticks.as_ref().map(|ticks| ticks.send(tick)) {
            Some(Ok(())) => Ok(()),
            _ => Err(self.failed("the thread that writes stopped")),
        }
    }

    /// Records a tick without waiting. If the queue is full, the tick is dropped and counted. Returns whether the recording goes on.
    pub fn offer(&mut self, tick: Arc<Tick>) -> bool {
        self.offered += 1;
        match self.ticks.as_ref().map(|ticks| ticks.try_send(tick)) {
            Some(Ok(())) => true,
            Some(Err(TrySendError::Full(_))) => {
                self.dropped += 1;
                true
            }
            _ => false,
        }
    }

    /// The file being written.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How the recording stands. After a failure all ticks that are not safe in the file count as dropped.
    pub fn status(&self) -> RecordingStatus {
        let ticks = self.progress.safe_ticks();
        let error = self.error();
        let state = match (&error, &self.result) {
            (Some(_), _) => RecordingState::Failed,
            (None, Some(_)) => RecordingState::Finished,
            (None, None) => RecordingState::Recording,
        };
        RecordingStatus {
            file: self.path.clone(),
            state,
            bytes: self.progress.bytes(),
            ticks,
            dropped_ticks: if error.is_some() {
                self.offered.saturating_sub(ticks)
            } else {
                self.dropped
            },
            error,
            warning: self.warning.clone(),
        }
    }

    fn error(&self) -> Option<String> {
        match &self.result {
            Some(result) => result.as_ref().err().cloned(),
            None if self.progress.has_failed() => {
                Some(self.failed("the writer stopped").to_string())
            }
            None => None,
        }
    }

    /// Tells the thread that writes to finish the file with `end`, without waiting for it; [`Self::is_done`] says when it has.
    pub fn end(&mut self, end: RecordingEnd) {
        *self.ending.lock().unwrap_or_else(PoisonError::into_inner) = Some((end, self.dropped));
        self.ticks = None;
    }

    /// Whether the thread that writes has ended. Its result is taken then, and [`Self::status`] is final.
    pub fn is_done(&mut self) -> bool {
        if self.thread.as_ref().is_some_and(JoinHandle::is_finished) {
            self.join();
        }
        self.thread.is_none()
    }

    /// Leaves the thread that writes alone: a disk that does not answer must not hold up the program.
    pub fn abandon(&mut self) {
        if self.thread.take().is_some() {
            self.result = Some(Err(self.failed("the disk does not take the rest").to_string()));
        }
    }

    /// Finishes the file with `end`, and waits for it.
    pub fn close(mut self, end: RecordingEnd) -> RecordingStatus {
        self.end(end);
        self.join();
        self.status()
    }

    /// Finishes the file with `end`, and waits for it.
    ///
    /// # Errors
    /// [`RecordingError::Write`] if a part of the file could not be written.
    pub fn finish(mut self, end: RecordingEnd) -> Result<Written, RecordingError> {
        self.end(end);
        let ticks = self.take_result()?;
        Ok(Written { ticks, dropped: self.dropped })
    }

    fn join(&mut self) {
        let result = self.take_result();
        self.result = Some(result.map_err(|error| error.to_string()));
    }

    fn take_result(&mut self) -> Result<u64, RecordingError> {
        // The thread ends when the last sender is gone.
        self.ticks = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(self.failed("the thread that writes panicked")),
            None => Err(self.failed("the thread that writes stopped earlier")),
        }
    }

    fn failed(&self, why: &str) -> RecordingError {
        RecordingError::Write {
            path: self.path.clone(),
            ticks: self.progress.safe_ticks(),
            bytes: self.progress.bytes(),
            why: self.progress.cause().unwrap_or_else(|| why.to_owned()),
        }
    }
}

impl Drop for Recorder {
    /// Waits until all recorded ticks are in the file.
    fn drop(&mut self) {
        if self.thread.is_some()
            && let Err(error) = self.take_result()
        {
            tracing::error!("{error}");
        }
    }
}

fn write_all(
    mut track: TrackWriter,
    queue: &Receiver<Arc<Tick>>,
    ending: &Mutex<Option<(RecordingEnd, u64)>>,
) -> Result<u64, RecordingError> {
    let mut opened = now();
    let mut in_chunk = 0;
    loop {
        match queue.recv_timeout(CHUNK_WALL) {
            Ok(tick) => {
                track.tick(&tick)?;
                in_chunk += 1;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                let end = ending.lock().unwrap_or_else(PoisonError::into_inner).take();
                return track.end(end.as_ref().map(|(end, dropped)| (end, *dropped)));
            }
        }
        if in_chunk >= CHUNK_TICKS || (in_chunk > 0 && opened.elapsed() >= CHUNK_WALL) {
            track.flush()?;
            in_chunk = 0;
        }
        if in_chunk == 0 {
            opened = now();
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "decides when to flush, never what is written")]
fn now() -> Instant {
    Instant::now()
}
