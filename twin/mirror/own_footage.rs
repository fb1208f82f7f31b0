//! A long flight that this program recorded, read part by part through its index: measurements as they are, nothing resampled.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use mcap::records::Record;

use super::container::Findings;
use super::film::Footage;
use super::index::Index;
use super::lossless;
use super::recorded::{Instant, MOST_TICKS, RecordedFlight};
use super::recording::{MEASUREMENT_TOPIC, METADATA_END, METADATA_START, MIRRORED, TICK_TOPIC};
use super::replayed::{as_recorded, instant, joint_names, nominal_inertia};
use super::stretches::{STRETCH_S, STRETCHES};
use crate::notation::{Coords, TICK_S};
use crate::tick::{Measurement, Tick};

/// A long flight of this program.
#[derive(Debug)]
pub(super) struct OwnFootage {
    index: Index,
    channel: u16,
    /// The channel holds whole ticks, not measurements alone.
    whole_ticks: bool,
    /// Ticks before each chunk, and at the end those of the flight.
    before: Vec<usize>,
    nominal_inertia: Option<Coords>,
    joint_names: Vec<String>,
    /// Of a foreign flight in shadow: what is not a number is unknown.
    mirrored: bool,
    troubles: Mutex<(Vec<String>, BTreeSet<usize>)>,
}

impl OwnFootage {
    /// The flight in `index`; `None` if it is no recording of this program, or its index is not whole.
    pub(super) fn new(index: Index) -> Option<Self> {
        let (tick, ticks) = index.channel(TICK_TOPIC).filter(|(_, ticks)| *ticks > 0)?;
        let measurement = index.channel(MEASUREMENT_TOPIC);
        let (channel, whole_ticks) = match measurement {
            Some((channel, messages)) if messages == ticks => (channel, false),
            _ => (tick, true),
        };
        let mut before: Vec<usize> = vec![0];
        for number in 0..index.table.chunks.len() {
            let messages = usize::try_from(index.messages(number, channel).ok()?).ok()?;
            before.push(before.last()?.checked_add(messages)?);
        }
        // What the index says in two places, and no more than a flight can have.
        let total = *before.last()?;
        if total as u64 != index.channel_messages(channel) || total as f64 > MOST_TICKS {
            return None;
        }
        let ours = |name: &str| name == METADATA_START || name == METADATA_END;
        let told = |key: &str| {
            let mut metadata = index.table.metadata.iter().filter(|record| ours(&record.name));
            metadata.find_map(|record| record.metadata.get(key)).map(String::as_str)
        };
        let nominal_inertia = told("gains").and_then(nominal_inertia);
        let joint_names = joint_names(told("joints"));
        let mirrored = told(MIRRORED).is_some();
        let troubles = Mutex::default();
        Some(Self {
            index,
            channel,
            whole_ticks,
            before,
            nominal_inertia,
            joint_names,
            mirrored,
            troubles,
        })
    }

    /// The container and its problems.
    pub(super) fn findings(&self) -> &Findings {
        &self.index.table.findings
    }

    /// Stretches of the flight, evenly spread.
    pub(super) fn stretches(&self) -> RecordedFlight {
        let length = (STRETCH_S / TICK_S) as usize;
        let last = self.ticks().saturating_sub(length);
        let mut all = self.as_recorded(Vec::new(), Vec::new());
        for k in 0..STRETCHES as usize {
            let from = last * k / (STRETCHES as usize - 1);
            let part = self.part(from, (from + length).min(self.ticks()));
            all.times_s.extend(part.times_s);
            all.instants.extend(part.instants);
            all.airborne.extend(part.airborne);
        }
        all
    }

    fn as_recorded(&self, times_s: Vec<f64>, instants: Vec<Instant>) -> RecordedFlight {
        as_recorded(times_s, instants, self.nominal_inertia, self.joint_names.clone())
    }

    fn measurement(&self, data: &[u8]) -> Result<Measurement, serde_json::Error> {
        if self.whole_ticks {
            return lossless::from_json::<Tick>(data).map(|tick| tick.measurement);
        }
        lossless::from_json(data)
    }

    fn trouble(&self, number: usize, why: String) {
        let mut troubles = self.troubles.lock().unwrap_or_else(PoisonError::into_inner);
        if troubles.1.insert(number) {
            troubles.0.push(why);
        }
    }
}

impl Footage for OwnFootage {
    fn ticks(&self) -> usize {
        self.before.last().copied().unwrap_or(0)
    }

    fn part(&self, from: usize, to: usize) -> RecordedFlight {
        let mut found: Vec<Option<Measurement>> = vec![None; to - from];
        let first = self.before.partition_point(|before| *before <= from).saturating_sub(1);
        let chunks = first..self.before.len() - 1;
        for number in chunks.take_while(|number| self.before[*number] < to) {
            let mut tick = self.before[number];
            let mut unreadable = None;
            let end = self.index.unpack(number, &mut |record| {
                if let Record::Message { header, data } = record
                    && header.channel_id == self.channel
                {
                    if let Some(place) = tick.checked_sub(from).and_then(|at| found.get_mut(at)) {
                        match self.measurement(&data) {
                            Ok(measurement) => *place = Some(measurement),
                            Err(error) => unreadable = Some(format!("tick {tick}: {error}")),
                        }
                    }
                    tick += 1;
                }
            });
            if let Some(why) = end.err().or(unreadable) {
                self.trouble(number, why);
            }
        }
        let mut last_s = from as f64 * TICK_S - TICK_S;
        let time_s = |measurement: &Option<Measurement>| {
            last_s = measurement.as_ref().map_or(last_s + TICK_S, |m| m.t_s);
            last_s
        };
        let times_s = found.iter().map(time_s).collect();
        let instants = found
            .iter()
            .map(|m| m.as_ref().map_or_else(Instant::default, |m| instant(m, self.mirrored)));
        self.as_recorded(times_s, instants.collect())
    }

    fn troubles(&self) -> Vec<String> {
        let mut troubles = self.troubles.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut troubles.0)
    }
}
