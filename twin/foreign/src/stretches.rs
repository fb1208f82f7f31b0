//! Judges a long flight by stretches that are spread evenly from its start to its end: sources, clocks and the gain of the
//! thrust. Reading the whole flight would take minutes.

use super::container::Findings;
use super::effort::Settled;
use super::foreign_parts::ForeignParts;
use super::gather::{Gathered, MessageDecoder, Track};
use super::index::Index;
use super::recorded::{MirrorError, Reading, RecordedFlight, on_times, tick_count};
use super::signals::{Signals, signals_of};
use super::table::ChunkEntry;
use super::topics::{Map, Quantity};
use super::vehicles::{self, VehicleFound};
use twin_core::notation::TICK_S;

/// Duration above which a flight is read around the playhead only, s.
pub const LONG_S: f64 = 120.0;

/// Number of stretches.
pub(super) const STRETCHES: u64 = 8;

/// Length of a stretch, s: it spans a few periods of any motion, and estimating the bias of an accelerometer takes 2 s.
pub(super) const STRETCH_S: f64 = 8.0;

const NS: f64 = 1e9;

/// A long flight of another program: the results of its stretches, and access to the whole flight.
pub(super) struct JudgedFlight {
    /// Sources in use and the samples of the stretches.
    pub signals: Signals,
    /// The stretches on ticks.
    pub recorded: RecordedFlight,
    /// The vehicles in the recording.
    pub vehicles: Vec<VehicleFound>,
    /// Access to the whole flight.
    pub parts: ForeignParts,
}

/// First and last time of each stretch between two times, ns.
fn stretches(from_ns: u64, to_ns: u64) -> Vec<(u64, u64)> {
    let length_ns = (STRETCH_S * NS) as u64;
    let last_start = to_ns.saturating_sub(length_ns).max(from_ns);
    let step_ns = (last_start - from_ns) / (STRETCHES - 1);
    // The last stretch ends where the flight ends.
    let start = |k| if k + 1 == STRETCHES { last_start } else { from_ns + k * step_ns };
    (0..STRETCHES).map(|k| (start(k), start(k).saturating_add(length_ns).min(to_ns))).collect()
}

/// Step of log time backwards above which the recorder's clock was set, ns.
const SET_BACK_NS: u64 = 1_000_000_000;

/// Reads the messages of the stretches that `map` asks for; `None` if the recorder's clock was set back, which only reading whole mends.
fn gather(index: &mut Index, map: &Map, stretches: &[(u64, u64)]) -> Option<Gathered> {
    let mut collector = MessageDecoder::new(map, None);
    let mut problems = Vec::new();
    index.table.definitions.records(&mut |record| collector.take(record));
    let mut numbers: Vec<usize> =
        stretches.iter().flat_map(|(from, to)| index.between(*from, *to)).collect();
    numbers.sort_unstable();
    numbers.dedup();
    for number in numbers {
        if let Err(why) = index.unpack(number, &mut |record| collector.take(record)) {
            problems.push(why);
        }
    }
    index.table.findings.chunks_lost += problems.len() as u64;
    for why in problems {
        index.table.findings.problem(why);
    }
    let mut gathered = collector.finish();
    // The chunks were read in file order.
    let was_set = |track: &Track| {
        track.samples.windows(2).any(|pair| pair[0].log_ns > pair[1].log_ns + SET_BACK_NS)
    };
    if gathered.tracks.iter().any(was_set) {
        return None;
    }
    let inside = |ns: u64| stretches.iter().any(|(from, to)| (*from..=*to).contains(&ns));
    for track in &mut gathered.tracks {
        track.samples.retain(|sample| inside(sample.log_ns));
    }
    Some(gathered)
}

/// First and last time of the chunks that contain a pose, ns: a recorder may run for long before and after the flight.
fn pose_span(index: &Index, map: &Map) -> Option<(u64, u64)> {
    let gives_pose = |channel: &mcap::records::Channel| {
        let schema = index.table.definitions.schemas.get(channel.schema_id);
        let schema = schema.map_or("", |schema| &schema.header.name);
        let rule = map.rule(&channel.topic, schema);
        rule.is_some_and(|(_, rule)| rule.gives.contains_key(&Quantity::Position))
    };
    let channels = index.table.definitions.channels.values();
    let poses: Vec<u16> = channels.filter(|c| gives_pose(c)).map(|channel| channel.id).collect();
    let has_pose = |place: &&ChunkEntry| {
        let named = poses.iter().any(|channel| {
            place.indexes.contains_key(channel) || place.counts.contains_key(channel)
        });
        // A chunk without an index may contain anything.
        named || place.indexes.is_empty() && place.counts.is_empty()
    };
    let spans = || index.table.chunks.iter().filter(has_pose).filter_map(|place| place.span_ns);
    Some((spans().map(|span| span.0).min()?, spans().map(|span| span.1).max()?))
}

/// Judges the flight in `index` by its stretches; the findings describe the damage of the file.
///
/// # Errors
/// [`MirrorError`] if the stretches contain no pose.
pub(super) fn judge(mut index: Index, map: &Map) -> Result<(JudgedFlight, Findings), MirrorError> {
    let (from_ns, to_ns) = pose_span(&index, map).ok_or(MirrorError::NoPose)?;
    if (to_ns - from_ns) as f64 / NS <= LONG_S {
        return Err(MirrorError::NoPose);
    }
    let stretches = stretches(from_ns, to_ns);
    let gathered = gather(&mut index, map, &stretches).ok_or(MirrorError::NoPose)?;
    let (gathered, vehicles) = vehicles::one(gathered, &map.vehicle)?;
    let unread: Vec<(u64, u64)> = stretches.windows(2).map(|pair| (pair[0].1, pair[1].0)).collect();
    let mut signals = signals_of(&gathered, &unread);
    let seconds = |ns: u64| (i128::from(ns) - i128::from(signals.start_ns)) as f64 / NS;
    let (start_s, end_s) = flight_span(&signals, seconds(stretches[0].1), seconds(to_ns))?;
    let ticks = tick_count(start_s, end_s)?;
    let mut times_s = Vec::new();
    for (from, to) in &stretches {
        let number = |s: f64| ((s - start_s) / TICK_S).max(0.0);
        let inside = number(seconds(*from)).ceil() as usize..number(seconds(*to)) as usize;
        times_s.extend(inside.filter(|tick| *tick < ticks).map(|t| start_s + t as f64 * TICK_S));
        // The tick after each stretch is unknown, so that the filters restart there.
        times_s.push(seconds(*to) + super::series::LONGEST_HOLE_S);
    }
    let recorded = on_times(&signals, &map.vehicle, times_s, Reading::Stretches);
    let settled = Settled {
        effort: recorded.effort.clone(),
        mass_kg: recorded.mass_kg,
        yardsticks: recorded.yardsticks,
    };
    signals.notes.push(format!(
        "the flight lasts {:.0} s: only the part around the playhead is read, and topics, gains and scales are judged by {STRETCHES} stretches of {STRETCH_S:.0} s",
        end_s - start_s
    ));
    let findings = index.table.findings.clone();
    let parts = ForeignParts::new(index, map, signals.clone(), settled, (start_s, ticks));
    Ok((JudgedFlight { signals, recorded, vehicles, parts }, findings))
}

/// First and last time of the flight, s: those of its pose, if the first and the last stretch contain one.
fn flight_span(signals: &Signals, first_end_s: f64, end_s: f64) -> Result<(f64, f64), MirrorError> {
    let spans = [
        signals.position.as_ref().and_then(super::series::Series::span),
        signals.attitude.as_ref().and_then(super::series::Attitudes::span),
    ];
    let spans = || spans.iter().flatten();
    let start_s = spans().map(|span| span.0).reduce(f64::min).ok_or(MirrorError::NoPose)?;
    let last_s = spans().map(|span| span.1).fold(start_s, f64::max);
    let start_s = if start_s < first_end_s { start_s } else { 0.0 };
    Ok((start_s, if last_s > end_s - STRETCH_S { last_s } else { end_s }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_reach_from_the_first_to_the_last_message_and_leave_holes() {
        let (from, to) = (5_000_000_000, 3_605_000_000_000);
        let found = stretches(from, to);
        assert_eq!(found.len() as u64, STRETCHES);
        assert_eq!((found[0].0, found[STRETCHES as usize - 1].1), (from, to));
        for pair in found.windows(2) {
            assert!(pair[0].1 < pair[1].0, "{pair:?}");
        }
        // In a short flight the stretches overlap; the last still ends where the flight ends.
        let short = stretches(0, 10_000_000_000);
        assert!(short.iter().all(|(from, to)| from < to && *to <= 10_000_000_000), "{short:?}");
    }
}
