//! The pauses between attempts to connect to a server: they grow while the server sends nothing.

use std::time::Duration;

/// The first pause; a server that restarts is back soon.
const FIRST: Duration = Duration::from_millis(300);

/// The longest pause. An operator who switches a vehicle on does not wait longer for its flight.
const LONGEST: Duration = Duration::from_secs(10);

/// The next pause. It has no random part: each mirror connects to a server of its own choice, so no crowd has to be spread.
#[derive(Clone, Copy, Debug)]
pub(super) struct Backoff {
    next: Duration,
}

impl Default for Backoff {
    fn default() -> Self {
        Self { next: FIRST }
    }
}

impl Backoff {
    /// The pause before the next attempt; the one after it is twice as long.
    pub(super) fn pause(&mut self) -> Duration {
        let pause = self.next;
        self.next = (pause * 2).min(LONGEST);
        pause
    }

    /// The connection was good: data arrived on it.
    pub(super) fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_up_to_ten_seconds_and_a_good_connection_starts_over() {
        let mut backoff = Backoff::default();
        let pauses: Vec<u128> = (0..8).map(|_| backoff.pause().as_millis()).collect();
        assert_eq!(pauses, [300, 600, 1200, 2400, 4800, 9600, 10_000, 10_000]);
        backoff.reset();
        assert_eq!(backoff.pause(), FIRST);
    }
}
