//! A long flight that this program recorded. It is read part by part through its index; its measurements are not resampled.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use mcap::records::Record;

use super::container::Findings;
use super::index::Index;
use super::playback::PartReader;
use super::recent_cache::RecentCache;
use super::recorded::{MOST_TICKS, RecordedFlight, RecordedTick};
use super::replayed::{Moved, as_recorded, joint_names, nominal_inertia};
use super::stretches::{STRETCH_S, STRETCHES};
use twin_core::notation::{Coords, TICK_S};
use twin_record::MIRRORED;
use twin_record::recording::{MEASUREMENT_TOPIC, METADATA_END, METADATA_START, TICK_TOPIC};

/// Number of ticks that are read at once: the recorder puts as many into a chunk. A measurement does not depend on its neighbours, so a
/// jump reads fewer ticks than in a flight that is resampled.
const BLOCK_TICKS: usize = 100;

/// Number of unpacked chunks in the cache: a block may end inside a chunk.
const KEPT_CHUNKS: usize = 8;

/// The ticks of a chunk; `None` marks a tick that cannot be read.
type Ticks = Arc<[Option<Moved>]>;

/// A long flight that this program recorded.
#[derive(Debug)]
pub(super) struct OwnParts {
    index: Index,
    channel: u16,
    /// True if the messages of the channel are whole ticks, false if they are measurements alone.
    whole_ticks: bool,
    /// Number of ticks before each chunk; the last entry is the number of ticks of the flight.
    before: Vec<usize>,
    nominal_inertia: Option<Coords>,
    joint_names: Vec<String>,
    /// True for a foreign flight that was flown in shadow: there a value that is not a number is unknown.
    mirrored: bool,
    chunks: RecentCache<Ticks>,
    troubles: Mutex<(Vec<String>, BTreeSet<usize>)>,
}

impl OwnParts {
    /// The flight in `index`; `None` if this program did not record it or its index is incomplete.
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
        // The index states the number of ticks in two places; both must agree, and no flight may have more than `MOST_TICKS`.
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
        let (chunks, troubles) = (RecentCache::new(KEPT_CHUNKS), Mutex::default());
        Some(Self {
            index,
            channel,
            whole_ticks,
            before,
            nominal_inertia,
            joint_names,
            mirrored,
            chunks,
            troubles,
        })
    }

    /// The container's properties and problems.
    pub(super) fn findings(&self) -> &Findings {
        &self.index.table.findings
    }

    /// Stretches of the flight, evenly spread over it.
    pub(super) fn stretches(&self) -> RecordedFlight {
        let length = (STRETCH_S / TICK_S) as usize;
        let last = self.ticks().saturating_sub(length);
        let starts = (0..STRETCHES as usize).map(|k| last * k / (STRETCHES as usize - 1));
        // The threads read in parallel: reading one stretch after the other would take half of the time to the first picture.
        let parts: Vec<RecordedFlight> = std::thread::scope(|scope| {
            let part =
                |from| scope.spawn(move || self.part(from, (from + length).min(self.ticks())));
            let threads: Vec<_> = starts.map(part).collect();
            let joined = threads.into_iter().map(|thread| match thread.join() {
                Ok(part) => part,
                Err(panic) => std::panic::resume_unwind(panic),
            });
            joined.collect()
        });
        let mut all = self.as_recorded(Vec::new(), Vec::new(), Vec::new());
        for part in parts {
            all.times_s.extend(part.times_s);
            all.instants.extend(part.instants);
            all.airborne.extend(part.airborne);
        }
        all
    }

    fn as_recorded(
        &self,
        times_s: Vec<f64>,
        instants: Vec<RecordedTick>,
        airborne: Vec<bool>,
    ) -> RecordedFlight {
        as_recorded(times_s, instants, airborne, self.nominal_inertia, self.joint_names.clone())
    }

    /// The ticks of chunk `number`; their number is the one that the index states.
    fn chunk(&self, number: usize) -> Ticks {
        self.chunks.get(number, |_| true, || self.read(number).into())
    }

    fn read(&self, number: usize) -> Vec<Option<Moved>> {
        let (first, expected) =
            (self.before[number], self.before[number + 1] - self.before[number]);
        let mut ticks = Vec::with_capacity(expected);
        let mut wrong = None;
        let end = self.index.unpack(number, &mut |record| {
            if let Record::Message { header, data } = record
                && header.channel_id == self.channel
            {
                let found = Moved::from_json(&data, self.whole_ticks, self.mirrored);
                if let Err(error) = &found {
                    wrong = Some(format!("tick {}: {error}", first + ticks.len()));
                }
                ticks.push(found.ok());
            }
        });
        let miscounted = || {
            let (at, found) = (self.index.table.chunks[number].at, ticks.len());
            format!("the chunk at byte {at} holds {found} ticks, its index says {expected}")
        };
        let wrong = end.err().or(wrong).or_else(|| (ticks.len() != expected).then(miscounted));
        if let Some(why) = wrong {
            self.trouble(number, why);
        }
        ticks.resize(expected, None);
        ticks
    }

    fn trouble(&self, number: usize, why: String) {
        let mut troubles = self.troubles.lock().unwrap_or_else(PoisonError::into_inner);
        if troubles.1.insert(number) {
            troubles.0.push(why);
        }
    }
}

impl PartReader for OwnParts {
    fn ticks(&self) -> usize {
        self.before.last().copied().unwrap_or(0)
    }

    fn part(&self, from: usize, to: usize) -> RecordedFlight {
        let mut found: Vec<Option<Moved>> = Vec::with_capacity(to - from);
        let first = self.before.partition_point(|before| *before <= from).saturating_sub(1);
        let chunks = first..self.before.len() - 1;
        for number in chunks.take_while(|number| self.before[*number] < to) {
            let within = |tick: usize| {
                tick.clamp(self.before[number], self.before[number + 1]) - self.before[number]
            };
            found.extend_from_slice(&self.chunk(number)[within(from)..within(to)]);
        }
        let mut last_s = from as f64 * TICK_S - TICK_S;
        let time_s = |moved: &Option<Moved>| {
            last_s = moved.as_ref().map_or(last_s + TICK_S, |moved| moved.t_s);
            last_s
        };
        let times_s = found.iter().map(time_s).collect();
        let airborne = |moved: &Option<Moved>| moved.as_ref().is_none_or(|moved| moved.airborne);
        let airborne = found.iter().map(airborne).collect();
        let instants = found.into_iter().map(|moved| moved.unwrap_or_default().instant);
        self.as_recorded(times_s, instants.collect(), airborne)
    }

    fn troubles(&self) -> Vec<String> {
        let mut troubles = self.troubles.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut troubles.0)
    }

    fn block_ticks(&self) -> usize {
        BLOCK_TICKS
    }
}
