//! Estimates the present time on the clock of a stream, and the delay of its messages.

use std::collections::VecDeque;

/// Limits of a plausible step in log time, s. If log time steps back by more than the first, or forward by more than the second
/// beyond the elapsed time, a new flight began or the clock was set.
const BACK_S: f64 = 0.5;
const AHEAD_S: f64 = 60.0;

/// Delays of messages stay in memory for the first time, in bins of the second, s. After a pause of the stream the clock
/// therefore settles again within that time.
const REMEMBERED_S: f64 = 3.0;
const BIN_S: f64 = 0.1;

/// Smallest and largest time behind the stream, s.
const LAG_S: (f64, f64) = (0.15, 60.0);

/// Margin for interpolation beyond the longest delay, s.
const ROOM_S: f64 = 0.1;

/// The clock of a stream, estimated from the arrival times of its messages.
#[derive(Clone, Debug, Default)]
pub(super) struct Pulse {
    /// Bins of delays, oldest first. The newest stays in memory however old it is.
    bins: VecDeque<Bin>,
    /// Arrival time of the last message on our own clock, s, and its log time, s.
    last_s: Option<(f64, f64)>,
}

/// Range of delays (own time minus log time) of the messages that arrived within one bin, s.
#[derive(Clone, Copy, Debug)]
struct Bin {
    began_s: f64,
    least: f64,
    most: f64,
}

impl Pulse {
    /// Adds a message with log time `log_s` that arrived at `now_s` of our own clock. Returns true if a new flight began or the
    /// clock was set.
    pub(super) fn heard(&mut self, log_s: f64, now_s: f64) -> bool {
        let anew = self.last_s.is_some_and(|(heard_s, logged_s)| {
            let step_s = log_s - logged_s;
            step_s < -BACK_S || step_s > AHEAD_S + now_s - heard_s
        });
        if anew {
            self.bins.clear();
        }
        self.last_s = Some((now_s, log_s));
        let found = now_s - log_s;
        match self.bins.back_mut().filter(|bin| now_s - bin.began_s < BIN_S) {
            Some(bin) => {
                (bin.least, bin.most) = (bin.least.min(found), bin.most.max(found));
            }
            None => self.bins.push_back(Bin { began_s: now_s, least: found, most: found }),
        }
        while self.bins.front().is_some_and(|bin| now_s - bin.began_s > REMEMBERED_S) {
            self.bins.pop_front();
        }
        anew
    }

    fn least_s(&self) -> Option<f64> {
        self.bins.iter().map(|bin| bin.least).reduce(f64::min)
    }

    /// The present time on the clock of the stream, s; `None` before the first message.
    pub(super) fn now_s(&self, now_s: f64) -> Option<f64> {
        Some(now_s - self.least_s()?)
    }

    /// Time behind the present by which all messages have arrived, s.
    pub(super) fn lag_s(&self) -> f64 {
        let most_s = self.bins.iter().map(|bin| bin.most).reduce(f64::max);
        let delay_s = most_s.zip(self.least_s()).map_or(0.0, |(most, least)| most - least);
        (delay_s + ROOM_S).clamp(LAG_S.0, LAG_S.1)
    }

    /// Time since the last message arrived, s.
    pub(super) fn silent_s(&self, now_s: f64) -> f64 {
        self.last_s.map_or(0.0, |(heard_s, _)| now_s - heard_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_is_that_of_the_fastest_messages_and_the_lag_that_of_the_slowest() {
        let mut pulse = Pulse::default();
        for i in 0..500 {
            let log_s = f64::from(i) * 0.01;
            // The delay is 5 ms, and 80 ms for every tenth message.
            let way_s = if i % 10 == 3 { 0.08 } else { 0.005 };
            assert!(!pulse.heard(log_s, 100.0 + log_s + way_s));
        }
        let now = pulse.now_s(104.995).unwrap();
        assert!((now - 4.99).abs() < 1e-9, "{now}");
        assert!((pulse.lag_s() - 0.175).abs() < 1e-9, "{}", pulse.lag_s());
    }

    #[test]
    fn a_stream_that_stood_still_goes_on_and_one_that_starts_again_begins_anew() {
        let mut pulse = Pulse::default();
        for i in 0..100 {
            pulse.heard(f64::from(i) * 0.01, 10.0 + f64::from(i) * 0.01);
        }
        // The stream pauses for 5 s and continues where it stopped.
        assert!(!pulse.heard(1.0, 16.0));
        assert!((pulse.now_s(16.1).unwrap() - 1.1).abs() < 1e-9);
        assert!(!pulse.heard(1.01, 16.01));
        // The pause lasts one second here: the time by which everything has arrived is right at once, the clock itself after
        // three seconds.
        for i in 0..500 {
            let (log_s, now_s) = (1.02 + f64::from(i) * 0.01, 17.02 + f64::from(i) * 0.01);
            assert!(!pulse.heard(log_s, now_s));
            let reached_s = pulse.now_s(now_s).unwrap() - pulse.lag_s();
            assert!((log_s - reached_s - 0.1).abs() < 0.06, "{log_s} {reached_s}");
        }
        assert!(pulse.lag_s() < 0.2);
        // First a clock that was set, then a new flight from its start.
        assert!(pulse.heard(900.0, 23.0));
        assert!(pulse.heard(0.0, 23.1));
        assert!((pulse.now_s(23.2).unwrap() - 0.1).abs() < 1e-9);
    }

    #[test]
    fn what_comes_a_chunk_at_a_time_is_followed_from_as_far_behind_as_a_chunk_is_long() {
        let mut pulse = Pulse::default();
        for i in 0..400_u32 {
            assert!(!pulse.heard(f64::from(i) * 0.01, f64::from(i / 100 + 1)), "{i}");
        }
        // The first message of a chunk arrives 0.99 s later, relative to its log time, than the last one.
        assert!((pulse.lag_s() - 1.09).abs() < 1e-9, "{}", pulse.lag_s());
    }
}
