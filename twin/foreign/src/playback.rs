//! A recorded flight as the loop reads it, tick by tick: held whole, or block by block around the playhead.
//!
//! A block depends on the file and its number alone, so a moment is the same however one comes to it. A thread reads the next
//! blocks while one is played; a jump waits for the first of its blocks.

use std::fmt::Debug;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use super::recent_cache::RecentCache;
use super::recorded::{RecordedFlight, RecordedTick};
use twin_core::notation::{KnownCoords, wrap_angle};
use twin_core::source::{Disturbance, InnerLoop, Source};
use twin_core::tick::{GripperReading, Measurement, Setpoint, Truth};

/// Ticks of a block: 5 s.
const BLOCK_TICKS: usize = 500;

/// Ticks that are kept: a run-up, what follows it and what was played last.
const KEPT_TICKS: usize = 6000;

/// Ticks that are read ahead.
const AHEAD_TICKS: usize = 500;

/// The row of the yaw.
const PSI: usize = 5;

/// A flight that is read part by part.
pub trait PartReader: Debug + Send + Sync {
    /// Ticks of all of it.
    fn ticks(&self) -> usize;

    /// The ticks `from..to` of it. What cannot be read is unknown.
    fn part(&self, from: usize, to: usize) -> RecordedFlight;

    /// What could not be read since the last call, a sentence each.
    fn troubles(&self) -> Vec<String>;

    /// Ticks that are read at once.
    fn block_ticks(&self) -> usize {
        BLOCK_TICKS
    }

    /// It still goes on: there are more ticks each time one asks.
    fn is_live(&self) -> bool {
        false
    }
}

/// A recorded flight.
#[derive(Debug)]
pub struct Playback {
    ticks: usize,
    store: Store,
}

#[derive(Debug)]
enum Store {
    Whole(Arc<[Measurement]>),
    Blocks { cache: Arc<BlockCache>, wanted: Sender<usize> },
}

/// Blocks that were read.
#[derive(Debug)]
struct BlockCache {
    parts: Arc<dyn PartReader>,
    blocks: RecentCache<Arc<[Measurement]>>,
}

impl Playback {
    /// A flight that is held whole.
    pub fn whole(recorded: &RecordedFlight) -> Self {
        let frames = frames(recorded);
        Self { ticks: frames.len(), store: Store::Whole(frames.into()) }
    }

    /// A flight that is read as it is played.
    pub fn of(parts: &Arc<dyn PartReader>) -> Self {
        let parts = Arc::clone(parts);
        let ticks = parts.ticks();
        let cache = Arc::new(BlockCache::new(parts));
        let (wanted, orders) = channel();
        let reader = Arc::clone(&cache);
        let thread = std::thread::Builder::new().name("playback".to_owned());
        // Without the thread each block is read when it is played.
        if let Err(error) = thread.spawn(move || read_ahead(&reader, &orders)) {
            tracing::warn!("nothing is read ahead: {error}");
        }
        Self { ticks, store: Store::Blocks { cache, wanted } }
    }

    /// Ticks; of a flight that still goes on those that there are by now.
    pub fn ticks(&self) -> usize {
        match &self.store {
            Store::Blocks { cache, .. } if self.is_live() => cache.parts.ticks(),
            _ => self.ticks,
        }
    }

    /// It still goes on.
    pub fn is_live(&self) -> bool {
        matches!(&self.store, Store::Blocks { cache, .. } if cache.parts.is_live())
    }

    /// What could not be read since the last call, a sentence each.
    pub fn troubles(&self) -> Vec<String> {
        match &self.store {
            Store::Whole(_) => Vec::new(),
            Store::Blocks { cache, .. } => cache.parts.troubles(),
        }
    }

    /// The block of `tick`; `None` beyond the end.
    fn block(&self, tick: usize) -> Option<Block> {
        if tick >= self.ticks() {
            return None;
        }
        match &self.store {
            Store::Whole(frames) => Some(Block { first: 0, frames: Arc::clone(frames) }),
            Store::Blocks { cache, .. } => {
                let ticks = cache.parts.block_ticks();
                let number = tick / ticks;
                Some(Block { first: number * ticks, frames: cache.block(number, tick % ticks) })
            }
        }
    }

    /// Has the blocks after that of `tick` read in the background.
    fn read_after(&self, tick: usize) {
        if let Store::Blocks { wanted, cache } = &self.store
            && !cache.parts.is_live()
        {
            // Without the thread nothing is read ahead.
            let _ = wanted.send(tick / cache.parts.block_ticks() + 1);
        }
    }
}

/// Reads the blocks from each number that is ordered on, until another one is.
fn read_ahead(cache: &BlockCache, orders: &Receiver<usize>) {
    let blocks = AHEAD_TICKS.div_ceil(cache.parts.block_ticks());
    while let Ok(mut first) = orders.recv() {
        let mut next = 0;
        while next < blocks {
            // What was ordered last is where the flight is.
            if let Some(newer) = orders.try_iter().last() {
                (first, next) = (newer, 0);
            }
            let number = first + next;
            if number * cache.parts.block_ticks() < cache.parts.ticks() {
                cache.block(number, 0);
            }
            next += 1;
        }
    }
}

impl BlockCache {
    fn new(parts: Arc<dyn PartReader>) -> Self {
        let blocks = RecentCache::new(KEPT_TICKS / parts.block_ticks());
        Self { parts, blocks }
    }

    /// The block from the cache if it reaches to its tick `within`, else from the file. Of a flight that goes on the newest block
    /// may be there with fewer ticks.
    fn block(&self, number: usize, within: usize) -> Arc<[Measurement]> {
        let ticks = self.parts.block_ticks();
        let read = || {
            let from = number * ticks;
            let to = (from + ticks).min(self.parts.ticks()).max(from);
            frames(&self.parts.part(from, to)).into()
        };
        self.blocks.get(number, |frames| frames.len() > within, read)
    }
}

/// The ticks of `recorded` as the loop reads them: what is `None` there is unknown here.
fn frames(recorded: &RecordedFlight) -> Vec<Measurement> {
    let one = |(tick, instant): (usize, &RecordedTick)| Measurement {
        t_s: recorded.times_s[tick],
        chi: KnownCoords::from_rows(&instant.chi),
        chi_dot: KnownCoords::from_rows(&instant.chi_dot),
        chi_ddot: KnownCoords::from_rows(&instant.chi_ddot),
        tau_applied: KnownCoords::from_rows(&instant.tau),
        gripper: GripperReading::default(),
        payload: None,
        saturated: false,
        airborne: recorded.airborne.get(tick).copied().unwrap_or(false),
    };
    recorded.instants.iter().enumerate().map(one).collect()
}

#[derive(Clone, Debug)]
struct Block {
    first: usize,
    frames: Arc<[Measurement]>,
}

impl Block {
    fn frame(&self, tick: usize) -> Option<&Measurement> {
        self.frames.get(tick.checked_sub(self.first)?)
    }
}

/// A place in a playback; looking at neighbouring ticks reads nothing anew.
#[derive(Clone, Debug)]
pub struct Cursor {
    playback: Arc<Playback>,
    block: Option<Block>,
}

impl Cursor {
    /// Into `playback`.
    pub fn new(playback: &Arc<Playback>) -> Self {
        Self { playback: Arc::clone(playback), block: None }
    }

    /// The measurement of `tick`; `None` beyond the end.
    pub fn frame(&mut self, tick: usize) -> Option<&Measurement> {
        if self.block.as_ref().and_then(|block| block.frame(tick)).is_none() {
            self.playback.read_after(tick);
            self.block = self.playback.block(tick);
        }
        self.block.as_ref()?.frame(tick)
    }

    /// The first tick of the block it is in.
    fn block_start(&self) -> Option<usize> {
        Some(self.block.as_ref()?.first)
    }
}

/// Plays a playback; what it is told to do reaches nobody.
pub struct RecordedSource {
    cursor: Cursor,
    next: usize,
    /// The last frame played.
    frame: Measurement,
    /// The last known yaw that was given, rad.
    last_psi: Option<f64>,
    /// Turns that the yaw of a block lacks, rad, and the block.
    turns_rad: f64,
    turned: Option<usize>,
}

impl RecordedSource {
    /// From tick `first` of `playback` on; `None` if there is none.
    pub fn new(playback: &Arc<Playback>, first: usize) -> Option<Self> {
        let mut cursor = Cursor::new(playback);
        let frame = cursor.frame(first)?.clone();
        Some(Self { cursor, next: first, frame, last_psi: None, turns_rad: 0.0, turned: None })
    }

    /// The next measurement; after the last one the last one again.
    fn play(&mut self) -> Measurement {
        if let Some(frame) = self.cursor.frame(self.next) {
            self.frame.clone_from(frame);
            self.next += 1;
        }
        self.continued()
    }

    /// The measurement of the frame; the turns of the yaw go on as before.
    fn continued(&mut self) -> Measurement {
        let mut measurement = self.frame.clone();
        let Some(psi) = measurement.chi.get(PSI) else { return measurement };
        let block = self.cursor.block_start();
        if let Some(last) = self.last_psi
            && self.turned != block
        {
            let ahead = last + wrap_angle(psi - last) - psi;
            let turns = (ahead / std::f64::consts::TAU).round();
            self.turns_rad = if turns.is_finite() { turns * std::f64::consts::TAU } else { 0.0 };
            self.turned = block;
        }
        if self.turns_rad != 0.0 {
            measurement.chi[PSI] = psi + self.turns_rad;
        }
        self.last_psi = Some(measurement.chi[PSI]);
        measurement
    }
}

impl Source for RecordedSource {
    fn advance(&mut self, _setpoint: &Setpoint, _inner: &mut dyn InnerLoop) -> Measurement {
        self.play()
    }

    fn truth(&self) -> Option<Truth> {
        None
    }

    fn disturb(&mut self, _disturbance: &Disturbance) {}
}

#[cfg(test)]
#[path = "playback_tests.rs"]
mod tests;
