//! The time offset between two recorded flights.
//!
//! Recordings of this program have one tick per control period, so an offset is a number of ticks: tick `i` of the other flight belongs to
//! tick `i + offset` of the first one.

use serde::Serialize;

use super::Flown;
use twin_core::notation::TICK_S;
use twin_core::tick::Tick;

/// Largest number of samples of a flight in the coarse search.
const COARSE_SAMPLES: usize = 1500;

/// Share of the shorter flight that an offset must leave for the comparison. With less, two flights that rest at one place fit everywhere.
const LEAST_OVERLAP: f64 = 0.5;

/// How two flights are aligned.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Alignment {
    /// Their first ticks belong together.
    Start,
    /// The first events whose kind or sentence contains this text belong together.
    Event(String),
    /// The offset at which the positions are closest.
    Best,
}

/// Why flights cannot be aligned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AlignError {
    /// There is nothing to compare.
    #[error("no flight was given; name two recordings or more")]
    NoFlight,
    /// A flight has no such event.
    #[error("{flight} has no event with {text:?}; its events are: {events}")]
    NoEvent {
        /// Name of the flight.
        flight: String,
        /// Text that was asked for.
        text: String,
        /// Kinds of its events.
        events: String,
    },
    /// The flights have no tick in common.
    #[error(
        "{first} and {other} have no time in common when they are aligned so; align them at the start"
    )]
    Apart {
        /// Name of the first flight.
        first: String,
        /// Name of the other flight.
        other: String,
    },
}

/// Seconds of a number of ticks.
pub(super) fn seconds(ticks: isize) -> f64 {
    ticks as f64 * TICK_S
}

/// The offset between two flights, ticks.
pub(super) fn offset_ticks(
    first: &Flown,
    other: &Flown,
    alignment: &Alignment,
) -> Result<isize, AlignError> {
    let [one, two] = [first, other].map(|flown| &flown.recording.ticks[..]);
    let offset = match alignment {
        Alignment::Start => 0,
        Alignment::Event(text) => event(first, text)? - event(other, text)?,
        Alignment::Best => best(one, two),
    };
    if overlap(one, two, offset).is_empty() {
        let (first, other) = (first.name.clone(), other.name.clone());
        return Err(AlignError::Apart { first, other });
    }
    Ok(offset)
}

/// Place of the first tick with the event.
fn event(flown: &Flown, text: &str) -> Result<isize, AlignError> {
    let ticks = &flown.recording.ticks;
    let kind = |event: &twin_core::tick::Event| format!("{:?}", event.kind).to_lowercase();
    let wanted = text.to_lowercase();
    let has = |tick: &Tick| {
        tick.events
            .iter()
            .any(|event| kind(event) == wanted || event.text.to_lowercase().contains(&wanted))
    };
    ticks.iter().position(has).map(usize::cast_signed).ok_or_else(|| {
        let mut kinds: Vec<String> = ticks.iter().flat_map(|tick| &tick.events).map(kind).collect();
        kinds.sort();
        kinds.dedup();
        let events = if kinds.is_empty() { "none".to_owned() } else { kinds.join(", ") };
        AlignError::NoEvent { flight: flown.name.clone(), text: text.to_owned(), events }
    })
}

/// The pairs of ticks that belong together.
pub(super) fn overlap<'a>(
    one: &'a [Tick],
    two: &'a [Tick],
    offset: isize,
) -> Vec<(&'a Tick, &'a Tick)> {
    let skip = |ticks: isize| usize::try_from(ticks).unwrap_or(0);
    one.iter().skip(skip(offset)).zip(two.iter().skip(skip(-offset))).collect()
}

/// The offset at which the mean squared distance of the positions is least; of equal ones the one nearest to zero.
fn best(one: &[Tick], two: &[Tick]) -> isize {
    let [one, two] = [one, two].map(|ticks| ticks.iter().map(position).collect::<Vec<_>>());
    let shorter = one.len().min(two.len());
    let least = ((shorter as f64 * LEAST_OVERLAP) as usize).max(1);
    let coarse = (one.len().max(two.len()) / COARSE_SAMPLES).max(1);
    let (low, high) = (
        least.cast_signed() - two.len().cast_signed(),
        one.len().cast_signed() - least.cast_signed(),
    );
    let step = coarse.cast_signed();
    let offsets = (0..=(high - low) / step).map(|index| low + index * step).chain([0]);
    let near = nearest(offsets, &one, &two, coarse);
    nearest((near - step).max(low)..=(near + step).min(high), &one, &two, 1)
}

/// The best of `offsets`, judged by every `stride`-th sample.
fn nearest(
    offsets: impl Iterator<Item = isize>,
    one: &[[f64; 3]],
    two: &[[f64; 3]],
    stride: usize,
) -> isize {
    let judged = offsets.map(|offset| (distance(one, two, offset, stride), offset));
    let less =
        |a: &(f64, isize), b: &(f64, isize)| a.0.total_cmp(&b.0).then(a.1.abs().cmp(&b.1.abs()));
    judged.min_by(less).map_or(0, |(_, offset)| offset)
}

/// Mean squared distance of the positions, m²; infinite if none is known.
fn distance(one: &[[f64; 3]], two: &[[f64; 3]], offset: isize, stride: usize) -> f64 {
    let skip = |ticks: isize| usize::try_from(ticks).unwrap_or(0);
    let pairs = one[skip(offset).min(one.len())..].iter().zip(&two[skip(-offset).min(two.len())..]);
    let (mut count, mut sum) = (0.0, 0.0);
    for (a, b) in pairs.step_by(stride) {
        let squared: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
        if squared.is_finite() {
            count += 1.0;
            sum += squared;
        }
    }
    if count > 0.0 { sum / count } else { f64::INFINITY }
}

/// Position of the base, m; NaN where it is unknown.
fn position(tick: &Tick) -> [f64; 3] {
    let measured = |row: usize| tick.measurement.chi.get(row).unwrap_or(f64::NAN);
    std::array::from_fn(|row| {
        tick.truth.as_ref().map_or_else(|| measured(row), |truth| truth.chi[row])
    })
}
