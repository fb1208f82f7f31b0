//! How far the thread that writes a recording has come; any other thread may ask.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// What the thread that writes tells the others.
#[derive(Debug, Default)]
pub(super) struct Progress {
    bytes: AtomicU64,
    safe_ticks: AtomicU64,
    failed: AtomicBool,
    cause: Mutex<Option<String>>,
}

impl Progress {
    /// Bytes written so far.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Ticks in closed chunks.
    pub(super) fn safe_ticks(&self) -> u64 {
        self.safe_ticks.load(Ordering::Relaxed)
    }

    /// Notes how far the file has grown.
    pub(super) fn grow_to(&self, bytes: u64) {
        self.bytes.fetch_max(bytes, Ordering::Relaxed);
    }

    /// Notes that `ticks` are in closed chunks.
    pub(super) fn keep(&self, ticks: u64) {
        self.safe_ticks.store(ticks, Ordering::Relaxed);
    }

    /// Notes that the recording failed.
    pub(super) fn fail(&self) {
        self.failed.store(true, Ordering::Relaxed);
    }

    /// Whether the recording failed.
    pub(super) fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Keeps the first error of the system. Later ones are its consequences: a compression that was never ended, for instance.
    pub(super) fn blame(&self, error: &std::io::Error) {
        let mut cause = self.cause.lock().unwrap_or_else(PoisonError::into_inner);
        cause.get_or_insert_with(|| error.to_string());
    }

    /// The first error of the system, if there was one.
    pub(super) fn cause(&self) -> Option<String> {
        self.cause.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
