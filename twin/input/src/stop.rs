//! The request to stop that readers ask for between pieces: the signal of the process, or in a test a request of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::interruption::inbox;

/// A request to stop. Clones share the request.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// Number of the signal that made the request; 0 until one did.
    signal: Arc<AtomicUsize>,
}

impl Stop {
    /// The request that a signal makes to the whole process; every [`crate::Reader`] asks for it unless it is told otherwise.
    pub fn of_process() -> Self {
        Self { signal: Arc::clone(inbox()) }
    }

    /// Whether the request was made.
    pub fn is_requested(&self) -> bool {
        self.signal.load(Ordering::Relaxed) != 0
    }

    /// Makes the request, as a signal would.
    #[cfg(test)]
    pub(crate) fn request(&self) {
        let signal = crate::interruption::Signal::Interrupt;
        self.signal.store(signal.number().into(), Ordering::Relaxed);
    }
}

/// The error of a read that a request to stop has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("reading was stopped on request")]
pub struct Stopped;

impl From<Stopped> for std::io::Error {
    fn from(stopped: Stopped) -> Self {
        Self::other(stopped)
    }
}

/// Whether `error` is the end of a read on request.
pub fn is_stop(error: &std::io::Error) -> bool {
    let inner: Option<&Stopped> = error.get_ref().and_then(|inner| inner.downcast_ref());
    inner.is_some()
}
