//! Brings all topics onto one clock: estimates the offset between the stamps in the messages and the recorder's log time.
//!
//! All topics whose stamps have one kind share a clock. One offset is therefore estimated per kind: the median over topics of
//! each topic's median of log time minus stamp. A topic that reaches the recorder late keeps its stamps and is not shifted.

use std::collections::{BTreeMap, BTreeSet};

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

/// Mends the clocks of `tracks`, so that one damaged stamp, or a clock that was set during the flight, neither stretches the recording nor
/// tears it apart. Returns one sentence for each event.
///
/// Between two neighbouring messages, log time and stamp advance alike. Where they do not, the one that advanced further was damaged or
/// set, and is shifted back.
pub fn mend(tracks: &mut [Track]) -> Vec<String> {
    let mut events: BTreeSet<String> = BTreeSet::new();
    for track in tracks {
        let shifts = if track.samples.iter().any(|sample| sample.stamp_ns.is_some()) {
            mend_pairs(&mut track.samples)
        } else {
            mend_log(&mut track.samples)
        };
        events.extend(shifts.iter().map(|shift| format!("{}: {shift}", track.topic)));
    }
    events.into_iter().collect()
}

/// Log time as a signed number, ns.
fn log_of(sample: &Sample) -> i128 {
    i128::from(sample.log_ns)
}

/// Mends samples with stamps; the events name what was shifted.
fn mend_pairs(samples: &mut [Sample]) -> Vec<String> {
    let mut steps: Vec<(usize, &str, i128)> = Vec::new();
    let (mut log_shift, mut stamp_shift) = (0_i128, 0_i128);
    let mut last: Option<(i128, i128)> = None;
    for (at, sample) in samples.iter_mut().enumerate() {
        let Some(stamp) = sample.stamp_ns else {
            sample.log_ns = u64::try_from(log_of(sample) + log_shift).unwrap_or(sample.log_ns);
            continue;
        };
        let (log, stamp) = (log_of(sample), i128::from(stamp));
        if let Some((last_log, last_stamp)) = last {
            let (by_log, by_stamp) = (log - last_log, stamp - last_stamp);
            let differs = by_log - by_stamp;
            if differs.abs() > i128::from(FARTHEST_NS) {
                if by_log.abs() > by_stamp.abs() {
                    log_shift -= differs;
                    steps.push((at, "log time", differs));
                } else {
                    stamp_shift += differs;
                    steps.push((at, "stamp", -differs));
                }
            }
        }
        last = Some((log, stamp));
        sample.log_ns = u64::try_from(log + log_shift).unwrap_or(sample.log_ns);
        sample.stamp_ns = i64::try_from(stamp + stamp_shift).ok();
    }
    told(&steps)
}

/// Sentences for steps: one that is taken back at once was one damaged message.
fn told(steps: &[(usize, &str, i128)]) -> Vec<String> {
    let mut said = Vec::new();
    let mut at = 0;
    while let Some((place, what, by)) = steps.get(at) {
        let back = steps.get(at + 1).filter(|(next, same, back)| {
            *next == place + 1 && same == what && (by + back).abs() < i128::from(FARTHEST_NS)
        });
        if back.is_some() {
            said.push(format!("the {what} of message {place} is damaged and was mended"));
            at += 2;
        } else {
            let by_s = *by as f64 * 1e-9;
            said.push(format!(
                "the {what} steps by {by_s:.1} s at message {place}; it was taken back"
            ));
            at += 1;
        }
    }
    said
}

/// Mends samples that have log times alone: drops one that lies far from both neighbours, and takes a step backwards back.
fn mend_log(samples: &mut Vec<Sample>) -> Vec<String> {
    let logs: Vec<i128> = samples.iter().map(log_of).collect();
    let far = |a: i128, b: i128| (a - b).abs() > i128::from(FARTHEST_NS);
    let alone = |at: usize| {
        let before = at.checked_sub(1).and_then(|at| logs.get(at));
        match (before, logs.get(at + 1)) {
            (Some(before), Some(after)) => far(logs[at], *before) && !far(*before, *after),
            _ => false,
        }
    };
    let damaged: Vec<usize> = (0..logs.len()).filter(|at| alone(*at)).collect();
    let mut said: Vec<String> = damaged
        .iter()
        .map(|at| format!("the log time of message {at} is damaged; the message is left out"))
        .collect();
    let mut at = 0;
    samples.retain(|_| {
        at += 1;
        damaged.binary_search(&(at - 1)).is_err()
    });
    let (mut shift, mut last) = (0_i128, None);
    for (at, sample) in samples.iter_mut().enumerate() {
        let log = log_of(sample);
        if let Some(last) = last
            && last - log > i128::from(ANOTHER_CLOCK_NS)
        {
            shift += last - log;
            let by_s = (log - last) as f64 * 1e-9;
            said.push(format!(
                "the log time steps by {by_s:.1} s at message {at}; it was taken back"
            ));
        }
        last = Some(log);
        sample.log_ns = u64::try_from(log + shift).unwrap_or(sample.log_ns);
    }
    said
}

fn median(mut values: Vec<i64>) -> Option<i64> {
    values.sort_unstable();
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: i64 = 1_000_000_000;
    const EPOCH: i64 = 1_700_000_000 * SECOND;

    /// A hundred messages of 10 ms; `change` changes log time and stamp of each.
    fn samples(change: impl Fn(usize, &mut Sample)) -> Vec<Sample> {
        let one = |at: usize| {
            let ns = i64::try_from(at).unwrap() * SECOND / 100;
            let mut sample = Sample {
                log_ns: u64::try_from(EPOCH + ns).unwrap(),
                stamp_ns: Some(5 * SECOND + ns),
                values: Vec::new(),
            };
            change(at, &mut sample);
            sample
        };
        (0..100).map(one).collect()
    }

    #[test]
    fn one_damaged_log_time_or_stamp_is_mended_to_its_true_value() {
        let wanted = samples(|_, _| {});
        let mut log =
            samples(|at, s| s.log_ns += if at == 40 { 6_300_000_000 * 1_000_000_000 } else { 0 });
        assert_eq!(mend_pairs(&mut log), ["the log time of message 40 is damaged and was mended"]);
        assert_eq!(log, wanted);
        let mut stamp = samples(|at, s| {
            s.stamp_ns = s.stamp_ns.map(|t| if at == 7 { t / 9 + 900 * SECOND } else { t });
        });
        assert_eq!(mend_pairs(&mut stamp), ["the stamp of message 7 is damaged and was mended"]);
        assert_eq!(stamp, wanted);
    }

    #[test]
    fn a_clock_that_is_set_during_the_flight_is_taken_back() {
        let wanted = samples(|_, _| {});
        let mut log = samples(|at, s| s.log_ns -= if at >= 50 { 3600 * 1_000_000_000 } else { 0 });
        let said = mend_pairs(&mut log);
        assert!(said.len() == 1 && said[0].contains("-3600.0 s at message 50"), "{said:?}");
        assert_eq!(log, wanted);
    }

    #[test]
    fn without_stamps_a_damaged_message_is_left_out_and_time_never_runs_back() {
        let mut log = samples(|at, s| {
            s.stamp_ns = None;
            s.log_ns += if at == 40 { 6_300_000_000 * 1_000_000_000 } else { 0 };
            s.log_ns -= if at >= 70 { 50 * 1_000_000_000 } else { 0 };
        });
        let said = mend_log(&mut log);
        assert_eq!((said.len(), log.len()), (2, 99), "{said:?}");
        assert!(log.windows(2).all(|pair| pair[0].log_ns <= pair[1].log_ns));
    }

    #[test]
    fn zero_stamps_and_regular_clocks_are_left_as_they_are() {
        let mut zero = samples(|at, s| s.stamp_ns = s.stamp_ns.filter(|_| at % 3 > 0));
        let wanted = zero.clone();
        assert!(mend_pairs(&mut zero).is_empty());
        assert_eq!(zero, wanted);
    }
}
