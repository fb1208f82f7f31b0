//! A token bucket that may run into debt: whoever asks for more than its rate waits, and nothing that it sent is lost.
//!
//! A command is always carried out, and its cost is charged. A connection in debt is not read until the debt is paid, so the rest of its
//! messages waits in the socket.

use std::time::{Duration, Instant};

use crate::server::command::Command;
use crate::server::gains::Change;

/// What one connection may ask in a second, and the size of its bucket. A frame costs 1.
pub(in crate::server) const ONE_PER_S: f64 = 200.0;

/// What all connections together may ask in a second: as much as ten that ask all they may.
pub(in crate::server) const ALL_PER_S: f64 = 10.0 * ONE_PER_S;

/// What one connection may ask in a second although all together ask too much: more than a hand on a slider does.
const FAIR_PER_S: f64 = 60.0;

/// Number of waits in a row after which a client is told to slow down. Two quick restarts make only one wait.
const WARNED_AFTER: u32 = 10;

/// Number of waits in a row after which the connection ends: three seconds of a flood.
const CLOSED_AFTER: u32 = 600;

/// The cost of `command`, in frames. It grows with the work that the command makes for the flight and for the other clients.
pub(in crate::server) fn cost(command: &Command) -> f64 {
    match command {
        Command::Change(Change::Gain(_)) | Command::Pause(_) | Command::Speed(_) => 1.0,
        Command::Disturb(_) => 2.0,
        // Every client gets the list of all gains.
        Command::Change(Change::Preset(_)) => 10.0,
        // A step flies as fast as the machine can: a thousand ticks are a tenth of a second of work.
        Command::Step(ticks) => 1.0 + f64::from(*ticks) / 50.0,
        // Only the last of the seeks that wait is flown, so a dragged slider may send fifty in a second.
        Command::Seek(_) | Command::NameFork { .. } | Command::DropFork(_) => 4.0,
        // A fork flies on a thread of its own, one after the other, and at most six are kept; every client gets their list.
        Command::Fork(_) => 20.0,
        // The vehicle is built anew, every client gets the scene, and a recording begins: one in a second.
        Command::Restart { .. } => ONE_PER_S,
    }
}

/// The reaction to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::server) enum Pace {
    /// Handle it now.
    Go,
    /// Handle it after this time.
    Wait(Duration),
    /// Handle it after this time, and tell the client to slow down.
    Warn(Duration),
    /// End the connection.
    Close,
}

/// A bucket that grows by its size in a second. Its debt is never more than that, so nobody waits for longer than a second.
#[derive(Clone, Copy, Debug)]
pub(in crate::server) struct Bucket {
    per_s: f64,
    tokens: f64,
    last: Instant,
}

impl Bucket {
    /// A full bucket at `now`.
    pub(in crate::server) fn new(per_s: f64, now: Instant) -> Self {
        Self { per_s, tokens: per_s, last: now }
    }

    /// Takes `cost` from the bucket.
    pub(in crate::server) fn charge(&mut self, cost: f64, now: Instant) {
        let elapsed_s = now.saturating_duration_since(self.last).as_secs_f64();
        self.tokens = (self.tokens + elapsed_s * self.per_s).min(self.per_s);
        self.tokens = (self.tokens - cost).max(-self.per_s);
        self.last = now;
    }

    /// The time from `now` until the debt is paid; zero without a debt.
    pub(in crate::server) fn debt(&self, now: Instant) -> Duration {
        let paid = now.saturating_duration_since(self.last);
        Duration::from_secs_f64((-self.tokens).max(0.0) / self.per_s).saturating_sub(paid)
    }
}

/// What is left to one connection.
#[derive(Clone, Copy, Debug)]
pub(in crate::server) struct Budget {
    own: Bucket,
    /// The share that a connection has although all together are in debt.
    fair: Bucket,
    waits: u32,
}

impl Budget {
    /// A full budget at `now`.
    pub(in crate::server) fn new(now: Instant) -> Self {
        Self { own: Bucket::new(ONE_PER_S, now), fair: Bucket::new(FAIR_PER_S, now), waits: 0 }
    }

    /// Takes `cost` from the budget.
    pub(in crate::server) fn charge(&mut self, cost: f64, now: Instant) {
        self.own.charge(cost, now);
        self.fair.charge(cost, now);
        if self.own.tokens >= ONE_PER_S / 2.0 {
            self.waits = 0;
        }
    }

    /// Charges a frame that arrived at `now`, and decides about it. `all` is the debt of all connections together.
    pub(in crate::server) fn frame(&mut self, now: Instant, all: Duration) -> Pace {
        self.charge(1.0, now);
        let own = self.own.debt(now);
        let wait = if self.fair.debt(now).is_zero() { own } else { own.max(all) };
        if wait.is_zero() {
            return Pace::Go;
        }
        // A connection is not blamed for the debt of the others.
        self.waits += u32::from(!own.is_zero());
        match self.waits {
            waits if waits > CLOSED_AFTER => Pace::Close,
            WARNED_AFTER if !own.is_zero() => Pace::Warn(wait),
            _ => Pace::Wait(wait),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::pace::now;

    fn after(start: Instant, s: f64) -> Instant {
        start + Duration::from_secs_f64(s)
    }

    #[test]
    fn a_steady_150_per_second_never_waits() {
        let start = now();
        let mut budget = Budget::new(start);
        let frames =
            (1..3000).map(|n| budget.frame(after(start, f64::from(n) / 150.0), Duration::ZERO));
        assert!(frames.into_iter().all(|pace| pace == Pace::Go));
    }

    #[test]
    fn a_flood_waits_is_warned_once_and_then_closed() {
        let start = now();
        let mut budget = Budget::new(start);
        let (mut clock, mut answers) = (start, Vec::new());
        for _ in 0..2000 {
            let answer = budget.frame(clock, Duration::ZERO);
            if let Pace::Wait(time) | Pace::Warn(time) = answer {
                clock += time;
            }
            answers.push(answer);
        }
        let count =
            |wanted: fn(&Pace) -> bool| answers.iter().filter(|&answer| wanted(answer)).count();
        assert_eq!(count(|pace| *pace == Pace::Go), ONE_PER_S as usize);
        assert_eq!(count(|pace| matches!(pace, Pace::Warn(_))), 1);
        assert_eq!(answers[ONE_PER_S as usize + CLOSED_AFTER as usize], Pace::Close);
        // Each of the frames that waited did so for one part in ONE_PER_S of a second.
        let waited_s = (clock - start).as_secs_f64();
        assert!((waited_s - f64::from(CLOSED_AFTER) / ONE_PER_S).abs() < 0.1, "{waited_s}");
    }

    #[test]
    fn a_restart_costs_a_second_and_a_pause_forgives() {
        let start = now();
        let mut budget = Budget::new(start);
        let restart = Command::Restart { seed: None, scenario: None };
        budget.charge(cost(&restart), start);
        assert_eq!(budget.own.debt(start), Duration::ZERO);
        budget.charge(cost(&restart), start);
        assert_eq!(budget.own.debt(start), Duration::from_secs(1));
        assert_eq!(budget.frame(after(start, 2.0), Duration::ZERO), Pace::Go);
    }

    #[test]
    fn the_debt_of_all_blames_nobody_and_leaves_a_fair_share() {
        let start = now();
        let all = Duration::from_millis(1);
        let (mut modest, mut greedy) = (Budget::new(start), Budget::new(start));
        for n in 1..3000 {
            let modest = modest.frame(after(start, f64::from(n) / 50.0), all);
            assert_eq!(modest, Pace::Go, "50 per second are less than the fair share");
            let greedy = greedy.frame(after(start, f64::from(n) / 100.0), all);
            assert!(matches!(greedy, Pace::Go) || greedy == Pace::Wait(all), "{greedy:?}");
            assert!(n < 1000 || greedy == Pace::Wait(all));
        }
    }

    #[test]
    fn nobody_waits_for_more_than_a_second() {
        let start = now();
        let mut all = Bucket::new(ALL_PER_S, start);
        (0..1000).for_each(|_| all.charge(ONE_PER_S, start));
        assert_eq!(all.debt(start), Duration::from_secs(1));
        assert_eq!(all.debt(after(start, 1.0)), Duration::ZERO);
    }
}
