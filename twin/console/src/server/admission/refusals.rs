//! Counts what was refused, by reason, and writes at most one line in a second about it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::server::pace::now;

/// The least time between two lines in the log.
const LINE_EVERY: Duration = Duration::from_secs(1);

/// Why somebody was refused or disconnected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::server) enum Refusal {
    /// The `Host` header names another machine.
    Host,
    /// The page comes from elsewhere.
    Origin,
    /// Too many connections.
    Connections,
    /// Too many connections or clients from one address.
    Address,
    /// Too many clients.
    Clients,
    /// A waiting connection gave its place to a new one.
    Displaced,
    /// The head of a request did not arrive in time.
    Head,
    /// The body of a request did not arrive in time.
    Body,
    /// A client accepted no data.
    Stalled,
    /// A client did not answer a ping.
    Silent,
    /// Commands or messages came too fast.
    Rate,
    /// The flight had too many requests to handle.
    Busy,
    /// A frame breaks the protocol.
    Protocol,
    /// A message is not of the type that is understood here, or its text is no UTF-8.
    Data,
    /// A message is too long.
    Length,
    /// The operating system gave no connection, mostly for lack of descriptors.
    System,
}

impl Refusal {
    /// Every reason with its label in `/metrics`.
    const ALL: [(Self, &'static str); 16] = [
        (Self::Host, "host"),
        (Self::Origin, "origin"),
        (Self::Connections, "connections"),
        (Self::Address, "address"),
        (Self::Clients, "clients"),
        (Self::Displaced, "displaced"),
        (Self::Head, "head_timeout"),
        (Self::Body, "body_timeout"),
        (Self::Stalled, "stalled"),
        (Self::Silent, "silent"),
        (Self::Rate, "rate"),
        (Self::Busy, "busy"),
        (Self::Protocol, "protocol"),
        (Self::Data, "data"),
        (Self::Length, "length"),
        (Self::System, "system"),
    ];

    fn index(self) -> usize {
        self as usize
    }
}

/// Counts of refusals since the server started.
pub(in crate::server) struct Refusals {
    counts: [AtomicU64; Refusal::ALL.len()],
    log: Mutex<Log>,
}

/// The last line in the log, and the refusals since.
#[derive(Default)]
struct Log {
    last: Option<Instant>,
    untold: u64,
}

impl Refusals {
    /// Nothing was refused yet.
    pub(in crate::server) fn new() -> Self {
        Self { counts: std::array::from_fn(|_| AtomicU64::new(0)), log: Mutex::default() }
    }

    /// Counts a refusal, and logs `what` unless a line was written within the last second.
    pub(in crate::server) fn note(&self, refusal: Refusal, what: &dyn std::fmt::Display) {
        self.counts[refusal.index()].fetch_add(1, Ordering::Relaxed);
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(untold) = log.line(now()) {
            let more = if untold == 0 {
                String::new()
            } else {
                format!(" ({untold} more since the last line)")
            };
            tracing::warn!("{what}{more}");
        }
    }

    /// Each reason's label with its count.
    pub(in crate::server) fn list(&self) -> impl Iterator<Item = (&'static str, u64)> {
        Refusal::ALL
            .iter()
            .map(|(refusal, label)| (*label, self.counts[refusal.index()].load(Ordering::Relaxed)))
    }
}

impl Log {
    /// Counts a refusal at `now`. Returns the number of refusals without a line if a line is due.
    fn line(&mut self, now: Instant) -> Option<u64> {
        if self.last.is_some_and(|last| now.saturating_duration_since(last) < LINE_EVERY) {
            self.untold += 1;
            return None;
        }
        self.last = Some(now);
        Some(std::mem::take(&mut self.untold))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reason_has_the_place_of_its_label() {
        for (place, (refusal, _)) in Refusal::ALL.iter().enumerate() {
            assert_eq!(refusal.index(), place, "{refusal:?}");
        }
    }

    #[test]
    fn a_thousand_refusals_in_a_second_make_one_line_and_the_next_line_counts_them() {
        let start = now();
        let mut log = Log::default();
        let lines: Vec<u64> =
            (0..1001).filter_map(|ms| log.line(start + Duration::from_millis(ms))).collect();
        assert_eq!(lines, [0, 999]);
    }
}
