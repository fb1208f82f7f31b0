//! The only use of the wall clock in tests: they give up on a server that hangs. No test asserts a duration, because a loaded machine is
//! slow; a test counts ticks, or compares the times in messages.

use std::time::{Duration, Instant};

/// Time after which a waiting test fails. Every wait here is shorter, even on a machine with ten times its load.
pub(crate) const PATIENCE: Duration = Duration::from_mins(1);

/// The time that a test may still wait.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patience(Instant);

impl Patience {
    /// The whole [`PATIENCE`], from now on.
    pub(crate) fn new() -> Self {
        Self(clock())
    }

    /// Whether time is left.
    pub(crate) fn lasts(self) -> bool {
        self.0.elapsed() < PATIENCE
    }
}

/// Waits until `holds` is true; fails with `what` after [`PATIENCE`].
pub(crate) fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let patience = Patience::new();
    while !holds() {
        assert!(patience.lasts(), "not within {PATIENCE:?}: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// The wall clock; live sources in tests also take the times of their messages from it.
#[expect(clippy::disallowed_methods, reason = "patience and live streams are wall-clock time")]
pub(crate) fn clock() -> Instant {
    Instant::now()
}
