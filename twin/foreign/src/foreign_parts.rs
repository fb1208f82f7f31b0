//! A long flight of another program, read part by part through the index of its file.
//!
//! Sources, clocks and gains were chosen and fitted once for the whole flight and stay fixed. Each part is read with some time
//! before and after it. Interpolation, filters and the bias of the accelerometer therefore give the same values as a longer part
//! would.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

use super::clock::common_ns;
use super::effort::Settled;
use super::gather::{MessageDecoder, Sample, Track};
use super::index::Index;
use super::playback::PartReader;
use super::recorded::{Reading, RecordedFlight, on_times};
use super::signals::{Signals, signals_as};
use super::topics::Map;
use twin_core::notation::TICK_S;

/// Time that is read before a part, s. Filters settle within 0.25 s, telling a landing from a dip takes 1 s, and estimating the
/// bias of the accelerometer takes 2 s.
const BEFORE_S: f64 = 4.0;

/// Time that is read after a part, s: enough to tell a flight from a spike, and for the longest lag of the thrust.
const AFTER_S: f64 = 1.5;

/// Largest difference between log time and measured time of a message, s.
const LOGGED_S: f64 = 1.5;

/// Number of decoded samples that stay in memory, so that consecutive parts decode every chunk once.
const KEPT_SAMPLES: usize = 200_000;

/// A long flight of another program.
#[derive(Debug)]
pub(super) struct ForeignParts {
    index: Index,
    map: Arc<Map>,
    chosen: Signals,
    settled: Settled,
    start_s: f64,
    ticks: usize,
    /// The tracks in use, without samples, in the order of the decoder.
    tracks: Vec<Track>,
    decoder: Mutex<Decoder>,
}

#[derive(Debug)]
struct Decoder {
    collector: MessageDecoder<Arc<Map>>,
    /// Samples per track of the most recently used chunks, by chunk number; the last used chunk is last.
    chunks: VecDeque<(usize, Vec<Vec<Sample>>)>,
    troubles: Vec<String>,
    /// Numbers of the damaged chunks, so that each is reported once.
    damaged: BTreeSet<usize>,
}

impl ForeignParts {
    /// The flight in `index` with `ticks` ticks from a start time on, s.
    pub(super) fn new(
        index: Index,
        map: &Map,
        chosen: Signals,
        settled: Settled,
        (start_s, ticks): (f64, usize),
    ) -> Self {
        let mut map = map.clone();
        if let Some((names, _)) = &chosen.joints {
            map.vehicle.joints.clone_from(names);
        }
        let map = Arc::new(map);
        let used = chosen.used.iter().map(|used| used.channel).collect();
        let mut collector = MessageDecoder::new(Arc::clone(&map), Some(used));
        index.table.definitions.records(&mut |record| collector.take(record));
        let tracks = collector.empty_tracks();
        let (chunks, troubles, damaged) = Default::default();
        let decoder = Mutex::new(Decoder { collector, chunks, troubles, damaged });
        Self { index, map, chosen, settled, start_s, ticks, tracks, decoder }
    }

    /// The tracks with their samples between two times, s.
    fn tracks(&self, from_s: f64, to_s: f64) -> Vec<Track> {
        let ns = |s: f64| self.chosen.start_ns.saturating_add((s * 1e9) as i64);
        let (from_ns, to_ns) = (ns(from_s), ns(to_s));
        let logged = |s: f64| u64::try_from(ns(s)).unwrap_or(0);
        let chunks: Vec<usize> =
            self.index.between(logged(from_s - LOGGED_S), logged(to_s + LOGGED_S)).collect();
        let mut tracks = self.tracks.clone();
        let bases = super::signals::bases_as(&tracks, &self.chosen);
        // A thread that panicked left only whole chunks behind.
        let mut decoder = self.decoder.lock().unwrap_or_else(PoisonError::into_inner);
        for number in chunks {
            let samples = decoder.chunk(&self.index, number);
            for ((track, base), samples) in tracks.iter_mut().zip(&bases).zip(samples) {
                let inside = |s: &&Sample| (from_ns..=to_ns).contains(&common_ns(s, base));
                track.samples.extend(samples.iter().filter(inside).cloned());
            }
        }
        tracks
    }
}

impl Decoder {
    /// Samples of a chunk per track; no samples if the chunk is damaged.
    fn chunk(&mut self, index: &Index, number: usize) -> &[Vec<Sample>] {
        let kept = self.chunks.iter().position(|(known, _)| *known == number);
        let chunk = match kept.and_then(|at| self.chunks.remove(at)) {
            Some(chunk) => chunk,
            None => (number, self.decode(index, number)),
        };
        self.chunks.push_back(chunk);
        let size = |chunk: &(usize, Vec<Vec<Sample>>)| chunk.1.iter().map(Vec::len).sum::<usize>();
        let mut samples: usize = self.chunks.iter().map(size).sum();
        while samples > KEPT_SAMPLES && self.chunks.len() > 1 {
            samples -= self.chunks.pop_front().map_or(0, |chunk| size(&chunk));
        }
        self.chunks.back().map_or(&[], |chunk| chunk.1.as_slice())
    }

    fn decode(&mut self, index: &Index, number: usize) -> Vec<Vec<Sample>> {
        let collector = &mut self.collector;
        let end = index.unpack(number, &mut |record| collector.take(record));
        if let Err(why) = end
            && self.damaged.insert(number)
        {
            self.troubles.push(why);
        }
        let complaints = collector.complaints();
        if !complaints.is_empty() && self.damaged.insert(number) {
            self.troubles.extend(complaints);
        }
        collector.drain()
    }
}

impl PartReader for ForeignParts {
    fn ticks(&self) -> usize {
        self.ticks
    }

    fn part(&self, from: usize, to: usize) -> RecordedFlight {
        let ticks = |s: f64| (s / TICK_S) as usize;
        let first = from.saturating_sub(ticks(BEFORE_S));
        let last = (to + ticks(AFTER_S)).min(self.ticks);
        let time_s = |tick: usize| self.start_s + tick as f64 * TICK_S;
        // One more sample on each side serves the interpolation.
        let tracks = self.tracks(time_s(first) - 0.5, time_s(last) + 0.5);
        let signals = signals_as(&tracks, &self.chosen);
        let times_s = (first..last).map(time_s).collect();
        let part = on_times(&signals, &self.map.vehicle, times_s, Reading::Part(&self.settled));
        part.only(from - first..to - first)
    }

    fn troubles(&self) -> Vec<String> {
        let mut decoder = self.decoder.lock().unwrap_or_else(PoisonError::into_inner);
        std::mem::take(&mut decoder.troubles)
    }
}
