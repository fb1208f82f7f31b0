//! A request to stop, such as Ctrl+C, which readers ask for between records.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

static OF_PROCESS: LazyLock<Stop> = LazyLock::new(Stop::default);

/// A request to stop. Clones share the request.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    flag: Arc<AtomicBool>,
}

impl Stop {
    /// The request to the whole process. A signal handler makes it; every [`crate::Reader`] asks for it unless it is told otherwise.
    pub fn of_process() -> Self {
        OF_PROCESS.clone()
    }

    /// Makes the request.
    pub fn request(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Whether the request was made.
    pub fn is_requested(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// The flag that makes the request, for a signal handler.
    pub fn flag(&self) -> &Arc<AtomicBool> {
        &self.flag
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
