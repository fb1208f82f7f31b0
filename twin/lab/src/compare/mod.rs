//! Recorded flights beside each other: aligned in time, with their metrics, signals and settings.
//!
//! In: [`Recording`]s, the first of which the others are compared with. Out: [`Comparison`], and a page of it. State: none.

mod align;
mod page;

use serde::Serialize;

use twin_core::tick::Tick;
use twin_record::Recording;
use twin_scenario::differences::{Difference, differences};
use twin_scenario::file::read_recorded;
use twin_scenario::metrics::Metrics;
use twin_scenario::settings::TaskKind;
use twin_scenario::{DEFAULTS, Row, Settings, Values, metrics_side_by_side};

pub use align::{AlignError, Alignment};
pub use page::page;

/// Most flights that are compared at a time: more curves cannot be told apart.
pub const MOST_FLIGHTS: usize = 6;

/// Signals of a comparison, by the names that a scenario's checks use.
pub(crate) const SIGNALS: [&str; 9] = [
    "position_error_m",
    "height_m",
    "speed_m_s",
    "tilt_rad",
    "residual_z_n",
    "estimate_z_n",
    "innovation_mean",
    "rotor_command_n",
    "payload_height_m",
];

/// Facts in the metadata of a recording that are compared. The seed is a key of the scenario.
const FACTS: [&str; 5] = ["scenario", "version", "git", "kernel", "verdict"];

/// A recorded flight with its name.
#[derive(Debug)]
pub struct Flown {
    /// Name in legends and tables.
    pub name: String,
    /// The recording.
    pub recording: Recording,
}

/// Flights compared with the first of them.
#[derive(Debug, Serialize)]
pub struct Comparison {
    /// Name of the first flight.
    pub first: String,
    /// The other flights.
    pub others: Vec<Pair>,
}

/// A flight compared with the first one.
#[derive(Debug, Serialize)]
pub struct Pair {
    /// Name of the flight.
    pub name: String,
    /// What is added to its times so that they are those of the first flight, s.
    pub offset_s: f64,
    /// Time for which both flew, s.
    pub overlap_s: f64,
    /// Facts of the recordings that differ.
    pub facts: Vec<Difference>,
    /// Keys of the scenarios that differ; `None` if a recording has no scenario, as that of a mirrored flight.
    pub settings: Option<Vec<Difference>>,
    /// Metrics of the whole flights.
    pub metrics: Vec<Row>,
    /// How far the signals are apart while both flew.
    pub signals: Vec<Apart>,
}

/// The distance of a signal in two flights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Apart {
    /// Name of the signal; its unit is the end of the name.
    pub signal: String,
    /// Root mean square of the difference.
    pub rms: f64,
    /// Difference of the largest size, other minus first.
    pub largest: f64,
    /// Time of the first flight at which it is, s.
    pub at_s: f64,
}

/// Compares the first of `flights` with each of the others.
///
/// # Errors
/// [`AlignError`] if two flights cannot be aligned.
pub fn compare(flights: &[Flown], alignment: &Alignment) -> Result<Comparison, AlignError> {
    let Some((first, others)) = flights.split_first() else { return Err(AlignError::NoFlight) };
    let pair = |other: &Flown| {
        let offset = align::offset_ticks(first, other, alignment)?;
        let both = align::overlap(&first.recording.ticks, &other.recording.ticks, offset);
        Ok(Pair {
            name: other.name.clone(),
            offset_s: align::seconds(offset),
            overlap_s: align::seconds(both.len().cast_signed()),
            facts: facts(&first.recording, &other.recording),
            settings: settings(&first.recording)
                .zip(settings(&other.recording))
                .map(|(one, other)| differences(&one, &other)),
            metrics: metrics_side_by_side(&metrics(&first.recording), &metrics(&other.recording)),
            signals: SIGNALS.iter().filter_map(|name| apart(name, &both)).collect(),
        })
    };
    let others = others.iter().map(pair).collect::<Result<_, _>>()?;
    Ok(Comparison { first: first.name.clone(), others })
}

fn facts(one: &Recording, other: &Recording) -> Vec<Difference> {
    let fact = |key: &&str| {
        let [from, to] =
            [one, other].map(|of| of.metadata.get(*key).cloned().unwrap_or_else(|| "-".into()));
        (from != to).then(|| Difference { key: (*key).to_owned(), from, to })
    };
    FACTS.iter().filter_map(fact).collect()
}

/// The scenario in a recording.
fn settings(recording: &Recording) -> Option<Settings> {
    let text = std::str::from_utf8(recording.attachments.get("scenario.toml")?).ok()?;
    read_recorded(text, std::path::Path::new("scenario.toml"), DEFAULTS).ok()
}

/// The metrics of a whole recorded flight.
fn metrics(recording: &Recording) -> Values {
    let mut metrics = Metrics::default();
    for tick in &recording.ticks {
        metrics.add(tick);
    }
    let task = settings(recording).map(|settings| settings.task);
    let place = task.filter(|task| task.kind == TaskKind::PickPlace);
    metrics.finish(place.map(|task| task.place_position_m.into()))
}

/// How far the signal `name` is apart; `None` if the flights do not have it at the same time.
fn apart(name: &str, both: &[(&Tick, &Tick)]) -> Option<Apart> {
    let read = twin_scenario::checks::reader(name)?;
    let known = both.iter().filter_map(|(first, other)| {
        let difference = read(other)? - read(first)?;
        difference.is_finite().then_some((first.measurement.t_s, difference))
    });
    let (mut count, mut squares, mut largest) = (0.0, 0.0, (0.0, 0.0_f64));
    for (t_s, difference) in known {
        count += 1.0;
        squares += difference * difference;
        if difference.abs() > largest.1.abs() {
            largest = (t_s, difference);
        }
    }
    (count > 0.0).then(|| Apart {
        signal: name.to_owned(),
        rms: f64::sqrt(squares / count),
        largest: largest.1,
        at_s: largest.0,
    })
}

#[cfg(test)]
mod tests;
