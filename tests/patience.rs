//! The one place where a test looks at the clock on the wall: to give up on a server that hangs. No test asserts how long anything
//! took, because a loaded machine takes longer; a test counts ticks or compares times that messages carry.

use std::time::{Duration, Instant};

/// Time after which a test that still waits has failed. Nothing here takes longer, also on a machine with ten times the load it can bear.
pub(crate) const PATIENCE: Duration = Duration::from_mins(1);

/// Time that a test still waits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience(Instant);

impl Patience {
    /// All of [`PATIENCE`], from now on.
    pub(crate) fn new() -> Self {
        Self(clock())
    }

    /// Whether some of it is left.
    pub(crate) fn lasts(self) -> bool {
        self.0.elapsed() < PATIENCE
    }
}

/// Waits until something holds, and fails with its name if that takes too long.
pub(crate) fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let patience = Patience::new();
    while !holds() {
        assert!(patience.lasts(), "not within {PATIENCE:?}: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// The clock on the wall; also for a source whose messages carry its time.
#[expect(clippy::disallowed_methods, reason = "patience and live streams are wall-clock time")]
pub(crate) fn clock() -> Instant {
    Instant::now()
}
