//! One time for all topics: what the messages' own clocks are behind the recorder's.
//!
//! All topics with stamps of one kind share a clock, so one offset is estimated per kind (the median over topics of each
//! topic's median of log time minus stamp): a topic that reaches the recorder late is not shifted for it.

use std::collections::BTreeMap;

use serde::Serialize;

use super::gather::{Sample, Track};
use super::topics::TimeSource;

/// A topic whose own offset differs from its clock's by more has a clock of its own, ns.
const ANOTHER_CLOCK_NS: i64 = 1_000_000_000;

/// A stamp farther from log time than this (its clock's offset taken away) is damage or a jump of that clock, ns.
const FARTHEST_NS: u64 = 10_000_000_000;

/// Which clock a topic's times are from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// Log time.
    Log,
    /// `header.stamp` or the like.
    Stamp,
    /// Microseconds of a flight controller.
    Microseconds,
}

/// What is known about the time of one topic.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timebase {
    /// The clock in use.
    pub clock: Clock,
    /// What was added to a stamp to get log time, ns.
    pub offset_ns: i64,
    /// By how much messages of this topic reach the recorder later than those of its clock in the median, ms.
    pub latency_ms: f64,
}

/// The time base of every track, in order.
pub fn timebases(tracks: &[Track]) -> Vec<Timebase> {
    let own: Vec<Option<(Clock, i64)>> = tracks.iter().map(own_offset).collect();
    let mut by_clock: BTreeMap<Clock, Vec<i64>> = BTreeMap::new();
    for (clock, offset) in own.iter().flatten() {
        by_clock.entry(*clock).or_default().push(*offset);
    }
    let common: BTreeMap<Clock, i64> = by_clock
        .into_iter()
        .filter_map(|(clock, offsets)| Some((clock, median(offsets)?)))
        .collect();
    own.into_iter()
        .map(|own| match own {
            None => Timebase { clock: Clock::Log, offset_ns: 0, latency_ms: 0.0 },
            Some((clock, own)) => {
                let shared = common.get(&clock).copied().unwrap_or(own);
                let differs = (i128::from(own) - i128::from(shared)).abs();
                let offset_ns = if differs > i128::from(ANOTHER_CLOCK_NS) { own } else { shared };
                Timebase {
                    clock,
                    offset_ns,
                    latency_ms: own.saturating_sub(offset_ns) as f64 * 1e-6,
                }
            }
        })
        .collect()
}

/// Time of a sample on the common clock, ns; log time where its stamp cannot be right.
pub fn common_ns(sample: &Sample, base: &Timebase) -> i64 {
    let log_ns = i64::try_from(sample.log_ns).unwrap_or(i64::MAX);
    match (base.clock, sample.stamp_ns) {
        (Clock::Log, _) | (_, None) => log_ns,
        (_, Some(stamp_ns)) => {
            let ns = stamp_ns.saturating_add(base.offset_ns);
            if ns.abs_diff(log_ns) > FARTHEST_NS { log_ns } else { ns }
        }
    }
}

/// Clock and median of log time minus stamp; `None` if most messages have no stamp.
fn own_offset(track: &Track) -> Option<(Clock, i64)> {
    let clock = match track.rule.time {
        TimeSource::Log => return None,
        TimeSource::Stamp { .. } => Clock::Stamp,
        TimeSource::Microseconds { .. } => Clock::Microseconds,
    };
    let offsets: Vec<i64> = track
        .samples
        .iter()
        .filter_map(|sample| i64::try_from(sample.log_ns).ok()?.checked_sub(sample.stamp_ns?))
        .collect();
    if offsets.len() * 2 < track.samples.len() {
        return None;
    }
    Some((clock, median(offsets)?))
}

fn median(mut values: Vec<i64>) -> Option<i64> {
    values.sort_unstable();
    values.get(values.len() / 2).copied()
}
