//! Brings all topics onto one clock: estimates the offset between the stamps in the messages and the recorder's log time.
//!
//! All topics whose stamps have one kind share a clock. One offset is therefore estimated per kind: the median over topics of
//! each topic's median of log time minus stamp. A topic that reaches the recorder late keeps its stamps and is not shifted.

use std::collections::BTreeMap;

use serde::Serialize;

use super::gather::{Sample, Track};
use super::topics::TimeSource;

/// Largest difference between a topic's own offset and the offset of its kind, ns. Beyond it the topic has a clock of its own.
const ANOTHER_CLOCK_NS: i64 = 1_000_000_000;

/// Largest distance between a stamp (offset added) and log time, ns. A stamp that is farther away is damaged, or its clock
/// jumped.
const FARTHEST_NS: u64 = 10_000_000_000;

/// The clock that gives a topic its times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// Log time of the recorder.
    Log,
    /// A stamp in the message, such as `header.stamp`.
    Stamp,
    /// A time in microseconds of a flight controller.
    Microseconds,
}

/// Time base of one topic: its clock, and how that clock relates to log time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timebase {
    /// The clock in use.
    pub clock: Clock,
    /// Offset from the stamp to log time, ns: log time = stamp + offset.
    pub offset_ns: i64,
    /// Median delay with which messages of this topic reach the recorder, relative to other topics of the same clock, ms.
    pub latency_ms: f64,
}

/// The time base of every track, in the order of `tracks`.
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

/// Time of a sample on the common clock, ns. A sample whose stamp is missing or implausible gets its log time.
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

/// Clock of a track and the median of its log time minus stamp, ns; `None` if more than half of the samples have no stamp.
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
