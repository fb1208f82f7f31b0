//! Computes when the next tick is due. Only this file reads the wall clock.

use std::time::{Duration, Instant};

use twin_core::notation::TICK_S;

/// A flight that lags more than this behind its deadlines does not catch up; its deadlines move instead.
const MOST_LAG: Duration = Duration::from_millis(100);

/// The parts of a tick whose time is measured: the stages of [`twin_core::flight::Stage`] in their order, then publishing.
pub(super) const STAGES: [&str; 7] =
    ["source", "predict", "task", "adapt", "control", "record", "publish"];

/// The wall-clock time.
#[expect(clippy::disallowed_methods, reason = "pacing and timing a served flight")]
pub(super) fn now() -> Instant {
    Instant::now()
}

/// Deadlines of ticks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    speed: Option<f64>,
    due: Instant,
}

impl Pace {
    /// Deadlines from `now` on for `speed` simulated seconds per second (positive, finite); `None` is as fast as possible.
    pub(super) fn new(speed: Option<f64>, now: Instant) -> Self {
        Self { speed, due: now }
    }

    /// The requested speed, simulated seconds per second; `None` is as fast as possible.
    pub(super) fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// Time until the next tick is due.
    pub(super) fn wait(&self, now: Instant) -> Duration {
        match self.speed {
            None => Duration::ZERO,
            Some(_) => self.due.saturating_duration_since(now),
        }
    }

    /// How long ago the next tick was due; zero without a requested speed, because ticks then have no deadlines.
    pub(super) fn late(&self, now: Instant) -> Duration {
        match self.speed {
            None => Duration::ZERO,
            Some(_) => now.saturating_duration_since(self.due),
        }
    }

    /// Sets the next deadline after a tick. It lies one period after the last deadline, so that delays do not add up. If the
    /// machine cannot keep up, the deadline moves to `now`, and the flight falls behind the wall clock.
    pub(super) fn ticked(&mut self, now: Instant) {
        let Some(speed) = self.speed else { return };
        self.due += Duration::from_secs_f64(TICK_S / speed);
        if now.saturating_duration_since(self.due) > MOST_LAG {
            self.due = now;
        }
    }
}

/// Upper edges of the bins of the lateness histogram, ms.
pub(super) const EDGES_MS: [f64; 9] = [0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 25.0, 100.0];

/// Histogram of the delay between the deadline of a tick and its begin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lateness {
    pub(super) counts: [u64; EDGES_MS.len() + 1],
    pub(super) sum_s: f64,
    pub(super) max_s: f64,
}

impl Lateness {
    /// Counts a tick that began `late` after its deadline.
    pub(super) fn count(&mut self, late: Duration) {
        let late_s = late.as_secs_f64();
        let class = EDGES_MS.iter().position(|edge| late_s * 1e3 <= *edge);
        self.counts[class.unwrap_or(EDGES_MS.len())] += 1;
        self.sum_s += late_s;
        self.max_s = self.max_s.max(late_s);
    }
}

/// Measures the real-time factor and the wall-clock time of each stage since the last reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meter {
    since: Instant,
    ticks: u32,
    spent: [Duration; STAGES.len()],
}

/// The result of a [`Meter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    /// Simulated seconds per second.
    pub real_time_factor: f64,
    /// Mean time of each of the [`STAGES`] per tick, ms.
    pub cost_ms: [f64; STAGES.len()],
}

impl Meter {
    /// A meter that starts at `now`.
    pub(super) fn new(now: Instant) -> Self {
        Self { since: now, ticks: 0, spent: [Duration::ZERO; STAGES.len()] }
    }

    /// Counts a tick; `spent` has the wall-clock time of each of the [`STAGES`].
    pub(super) fn count(&mut self, spent: [Duration; STAGES.len()]) {
        self.ticks += 1;
        for (sum, part) in self.spent.iter_mut().zip(spent) {
            *sum += part;
        }
    }

    /// Returns the result since the last reading, and starts a new measurement at `now`.
    pub(super) fn read(&mut self, now: Instant) -> Reading {
        let ticks = f64::from(self.ticks);
        let wall_s = now.saturating_duration_since(self.since).as_secs_f64();
        let cost_ms = self.spent.map(|spent| spent.as_secs_f64() * 1e3 / ticks.max(1.0));
        *self = Self::new(now);
        Reading {
            real_time_factor: if wall_s > 0.0 { ticks * TICK_S / wall_s } else { 0.0 },
            cost_ms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn a_late_tick_does_not_move_the_deadlines_after_it() {
        let start = now();
        let mut pace = Pace::new(Some(1.0), start);
        // Each tick begins 3 ms late, yet the hundredth deadline is one second after the start.
        for tick in 0..100 {
            assert_eq!(pace.wait(start), 10 * MS * tick);
            pace.ticked(start + 10 * MS * tick + 3 * MS);
        }
        assert_eq!(pace.wait(start), Duration::from_secs(1));
    }

    #[test]
    fn a_machine_that_is_too_slow_is_not_hurried_afterwards() {
        let start = now();
        let mut pace = Pace::new(Some(1.0), start);
        let late = start + Duration::from_secs(5);
        pace.ticked(late);
        assert_eq!(pace.wait(late), Duration::ZERO);
        pace.ticked(late + MS);
        assert_eq!(pace.wait(late + MS), 9 * MS);
    }

    #[test]
    fn speed_scales_the_period_and_no_speed_never_waits() {
        let start = now();
        let mut pace = Pace::new(Some(4.0), start);
        pace.ticked(start);
        assert_eq!(pace.wait(start), Duration::from_micros(2500));
        let mut free = Pace::new(None, start);
        free.ticked(start);
        assert_eq!(free.wait(start), Duration::ZERO);
    }

    #[test]
    fn the_meter_divides_simulated_by_wall_clock_time() {
        let start = now();
        let mut meter = Meter::new(start);
        (0..50).for_each(|_| meter.count([MS, MS, MS, MS, MS, MS, 2 * MS]));
        let reading = meter.read(start + Duration::from_secs(2));
        // The flight took 2 s for 50 ticks of 10 ms; the tolerance is a few roundings of numbers below 10.
        assert!((reading.real_time_factor - 0.25).abs() < 1e-12);
        assert!((reading.cost_ms[0] - 1.0).abs() < 1e-9 && (reading.cost_ms[6] - 2.0).abs() < 1e-9);
        assert!(meter.read(start + Duration::from_secs(3)).real_time_factor.abs() < 1e-12);
    }
}
