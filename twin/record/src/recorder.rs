//! Writes ticks to an MCAP file, which other programs open unaided and a replay reads back exactly.
//!
//! In: [`Tick`]s. Out: the views as `foxglove.*` messages (`/tf`, `/scene`, `/joint_states`, `/log`), and the lossless `/twin/tick`
//! and `/twin/measurement`. One thread writes. Every half second it closes and flushes a chunk, so the file of a killed run can be
//! read to its last chunk. Log time is simulated time.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::output::RecordingFile;
use crate::recording::RecordingError;
use crate::recording_info::{RecordingEnd, RecordingInfo};
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

enum Order {
    Tick(Arc<Tick>),
    End { end: RecordingEnd, dropped: u64 },
}

/// A recording that is being written.
#[derive(Debug)]
pub struct Recorder {
    path: PathBuf,
    orders: Option<SyncSender<Order>>,
    thread: Option<JoinHandle<Result<u64, RecordingError>>>,
    dropped: u64,
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
    /// [`RecordingError::Write`] if the file cannot be written.
    pub fn start(file: RecordingFile, info: &RecordingInfo) -> Result<Self, RecordingError> {
        let path = file.path().to_owned();
        let track = TrackWriter::start(file, info)?;
        let (orders, receiver) = sync_channel(QUEUE_TICKS);
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || write_all(track, &receiver))
            .map_err(|error| RecordingError::write(&path, error))?;
        Ok(Self { path, orders: Some(orders), thread: Some(thread), dropped: 0 })
    }

    /// Records a tick. It waits for the disk if the queue is full, so no tick is lost.
    ///
    /// # Errors
    /// [`RecordingError::Write`] if the file can no longer be written.
    pub fn record(&mut self, tick: Arc<Tick>) -> Result<(), RecordingError> {
        match self.orders.as_ref().map(|orders| orders.send(Order::Tick(tick))) {
            Some(Ok(())) => Ok(()),
            _ => self.why_it_stopped(),
        }
    }

    /// Records a tick without waiting. Returns `false` if the queue was full; the tick is then dropped and counted.
    ///
    /// # Errors
    /// [`RecordingError::Write`] if the file can no longer be written.
    pub fn offer(&mut self, tick: Arc<Tick>) -> Result<bool, RecordingError> {
        match self.orders.as_ref().map(|orders| orders.try_send(Order::Tick(tick))) {
            Some(Ok(())) => Ok(true),
            Some(Err(TrySendError::Full(_))) => {
                self.dropped += 1;
                Ok(false)
            }
            _ => self.why_it_stopped().map(|()| false),
        }
    }

    /// Ticks dropped so far by [`Recorder::offer`].
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The file being written.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the metadata of the end and closes the file.
    ///
    /// # Errors
    /// [`RecordingError::Write`] if a part of the file could not be written.
    pub fn finish(mut self, end: RecordingEnd) -> Result<Written, RecordingError> {
        let order = Order::End { end, dropped: self.dropped };
        let sent = self.orders.as_ref().is_some_and(|orders| orders.send(order).is_ok());
        let ticks = self.join()?;
        if sent {
            return Ok(Written { ticks, dropped: self.dropped });
        }
        Err(RecordingError::write(&self.path, "the writer stopped before the end"))
    }

    fn why_it_stopped(&mut self) -> Result<(), RecordingError> {
        self.join()?;
        Err(RecordingError::write(&self.path, "the writer stopped"))
    }

    fn join(&mut self) -> Result<u64, RecordingError> {
        // The writer thread ends when the last sender is gone.
        self.orders = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(RecordingError::write(&self.path, "the writer thread failed")),
            None => Err(RecordingError::write(&self.path, "the writer stopped earlier")),
        }
    }
}

impl Drop for Recorder {
    /// Waits until all recorded ticks are in the file.
    fn drop(&mut self) {
        if self.thread.is_some()
            && let Err(error) = self.join()
        {
            tracing::error!("{error}");
        }
    }
}

fn write_all(mut track: TrackWriter, orders: &Receiver<Order>) -> Result<u64, RecordingError> {
    let mut opened = now();
    let mut in_chunk = 0;
    loop {
        match orders.recv_timeout(CHUNK_WALL) {
            Ok(Order::Tick(tick)) => {
                track.tick(&tick)?;
                in_chunk += 1;
            }
            Ok(Order::End { end, dropped }) => return track.end(Some((&end, dropped))),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return track.end(None),
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
