//! A flight that is still going on, read like a long recording, a short time behind the newest message.

use std::sync::Arc;

use super::super::clock::{Timebase, common_ns};
use super::super::effort::Settled;
use super::super::gather::Track;
use super::super::opened::OpenedFlight;
use super::super::playback::PartReader;
use super::super::recorded::{Reading, RecordedFlight, on_times};
use super::super::signals::{Signals, bases_as, signals_as};
use super::super::topics::Map;
use super::shared::Shared;
use twin_core::notation::TICK_S;

/// Time that is read before a part and after it, s.
const BEFORE_S: f64 = 4.0;
const AFTER_S: f64 = 0.1;

/// The number of available ticks grows in steps of this size.
const STEP_TICKS: usize = 5;

/// Ticks of a block.
const BLOCK_TICKS: usize = 50;

/// A flight that is still going on, with the sources, clocks and gains that were chosen for it once.
#[derive(Debug)]
struct LiveParts {
    shared: Arc<Shared>,
    chosen: Signals,
    settled: Settled,
    map: Map,
}

/// Opens the flight in `shared`: chooses and fits by its last minute, and reads on as messages arrive.
pub(super) fn opened(shared: &Arc<Shared>) -> Option<OpenedFlight> {
    let opened = shared.judged()?;
    let parts = LiveParts {
        shared: Arc::clone(shared),
        chosen: opened.signals.clone(),
        settled: Settled {
            effort: opened.recorded.effort.clone(),
            mass_kg: opened.recorded.mass_kg,
            yardsticks: opened.recorded.yardsticks,
        },
        map: opened.map.clone(),
    };
    Some(OpenedFlight { long: Some(Arc::new(parts)), ..opened })
}

impl PartReader for LiveParts {
    /// Number of ticks that are old enough for all their messages to have arrived.
    fn ticks(&self) -> usize {
        let state = self.shared.state();
        let now_s = state.pulse.now_s(self.shared.now_s()).unwrap_or(0.0) - state.pulse.lag_s();
        let ticks = ((now_s - self.chosen.start_ns as f64 * 1e-9) / TICK_S).max(0.0) as usize;
        ticks / STEP_TICKS * STEP_TICKS
    }

    fn part(&self, from: usize, to: usize) -> RecordedFlight {
        let ticks = |s: f64| (s / TICK_S) as usize;
        let (first, last) = (from.saturating_sub(ticks(BEFORE_S)), to + ticks(AFTER_S));
        let time_s = |tick: usize| tick as f64 * TICK_S;
        let ns = |s: f64| self.chosen.start_ns.saturating_add((s * 1e9) as i64);
        let range = ns(time_s(first) - 0.5)..ns(time_s(last) + 0.5);
        let tracks: Vec<Track> = {
            let state = self.shared.state();
            let bases = bases_as(state.tracks(), &self.chosen);
            let part = |(track, base): (&Track, Timebase)| {
                // Samples are in order except for jitter, so the search for the part starts at the end.
                let newest = track.samples.iter().rev();
                let mut samples: Vec<_> = newest
                    .take_while(|s| common_ns(s, &base) > range.start - 1_000_000_000)
                    .filter(|s| range.contains(&common_ns(s, &base)))
                    .cloned()
                    .collect();
                samples.reverse();
                Track { samples, ..track.bare() }
            };
            state.tracks().zip(bases).map(part).collect()
        };
        let signals = signals_as(&tracks, &self.chosen);
        let times_s = (first..last).map(time_s).collect();
        let part = on_times(&signals, &self.map.vehicle, times_s, Reading::Part(&self.settled));
        part.only(from - first..to - first)
    }

    fn troubles(&self) -> Vec<String> {
        Vec::new()
    }

    fn block_ticks(&self) -> usize {
        BLOCK_TICKS
    }

    fn is_live(&self) -> bool {
        true
    }
}
