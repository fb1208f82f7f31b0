//! A recorded flight as the loop reads it, tick by tick. It lies in memory as a whole, or block by block around the playhead.
//!
//! A block depends only on the file and on its number, so playing and seeking give the same measurements at a tick. A thread reads the next
//! blocks while one block is played; a jump waits for its first block.

use std::fmt::Debug;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use super::recent_cache::RecentCache;
use super::recorded::{RecordedFlight, RecordedTick};
use twin_core::notation::{KnownCoords, wrap_angle};
use twin_core::source::{Disturbance, InnerLoop, Source};
use twin_core::tick::{GripperReading, Measurement, Setpoint, Truth};

/// Number of ticks of a block: 5 s.
const BLOCK_TICKS: usize = 500;

/// Number of ticks in the cache: a run-up, the ticks after it and the ticks that were played last.
const KEPT_TICKS: usize = 6000;

/// Number of ticks that the thread reads ahead.
const AHEAD_TICKS: usize = 500;

/// Index of the yaw among the coordinates.
const PSI: usize = 5;

/// A flight that is read part by part.
pub trait PartReader: Debug + Send + Sync {
    /// Number of ticks of the whole flight.
    fn ticks(&self) -> usize;

    /// The ticks `from..to` of the flight. A tick that cannot be read is unknown.
    fn part(&self, from: usize, to: usize) -> RecordedFlight;

    /// One sentence for each part that could not be read since the last call.
    fn troubles(&self) -> Vec<String>;

    /// Number of ticks that are read at once.
    fn block_ticks(&self) -> usize {
        BLOCK_TICKS
    }

    /// True while the flight still goes on: the number of ticks grows between calls.
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

/// Cache of the blocks that were read.
#[derive(Debug)]
struct BlockCache {
    parts: Arc<dyn PartReader>,
    blocks: RecentCache<Arc<[Measurement]>>,
}

impl Playback {
    /// A flight that lies in memory as a whole.
    pub fn whole(recorded: &RecordedFlight) -> Self {
        let frames = frames(recorded);
        Self { ticks: frames.len(), store: Store::Whole(frames.into()) }
    }

    /// A flight that is read block by block while it is played.
    pub fn of(parts: &Arc<dyn PartReader>) -> Self {
        let parts = Arc::clone(parts);
        let ticks = parts.ticks();
        let cache = Arc::new(BlockCache::new(parts));
        let (wanted, orders) = channel();
        let reader = Arc::clone(&cache);
        let thread = std::thread::Builder::new().name("playback".to_owned());
        // Without the thread, each block is read when it is played.
        if let Err(error) = thread.spawn(move || read_ahead(&reader, &orders)) {
            tracing::warn!("nothing is read ahead: {error}");
        }
        Self { ticks, store: Store::Blocks { cache, wanted } }
    }

    /// Number of ticks; for a flight that still goes on, the number so far.
    pub fn ticks(&self) -> usize {
        match &self.store {
            Store::Blocks { cache, .. } if self.is_live() => cache.parts.ticks(),
            _ => self.ticks,
        }
    }

    /// True while the flight still goes on.
    pub fn is_live(&self) -> bool {
        matches!(&self.store, Store::Blocks { cache, .. } if cache.parts.is_live())
    }

    /// One sentence for each part that could not be read since the last call.
    pub fn troubles(&self) -> Vec<String> {
        match &self.store {
            Store::Whole(_) => Vec::new(),
            Store::Blocks { cache, .. } => cache.parts.troubles(),
        }
    }

    /// The block that contains `tick`; `None` beyond the end.
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

    /// Asks the thread to read the blocks after the block of `tick`.
    fn read_after(&self, tick: usize) {
        if let Store::Blocks { wanted, cache } = &self.store
            && !cache.parts.is_live()
        {
            // The send fails if there is no thread; then nothing is read ahead.
            let _ = wanted.send(tick / cache.parts.block_ticks() + 1);
        }
    }
}

/// Reads the blocks that follow each ordered number, until a newer order arrives.
fn read_ahead(cache: &BlockCache, orders: &Receiver<usize>) {
    let blocks = AHEAD_TICKS.div_ceil(cache.parts.block_ticks());
    while let Ok(mut first) = orders.recv() {
        let mut next = 0;
        while next < blocks {
            // The newest order is the position of the playhead.
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

    /// The block from the cache if it contains its tick `within`, otherwise from the file. While a flight goes on, its newest block in the
    /// cache may be shorter than the block in the file.
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

/// The ticks of `recorded` as the loop reads them: a `None` there becomes an unknown coordinate here.
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

/// A position in a playback. It keeps its block, so reading a neighbouring tick does not read the file again.
#[derive(Clone, Debug)]
pub struct Cursor {
    playback: Arc<Playback>,
    block: Option<Block>,
}

impl Cursor {
    /// A cursor into `playback`.
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

    /// The first tick of the cursor's block.
    fn block_start(&self) -> Option<usize> {
        Some(self.block.as_ref()?.first)
    }
}

/// Source that plays a recording: it ignores set-points and disturbances.
#[derive(Clone)]
pub struct RecordedSource {
    cursor: Cursor,
    next: usize,
    /// The last frame played.
    frame: Measurement,
    /// Yaw of the last measurement in which the yaw was known, rad.
    last_psi: Option<f64>,
    /// Whole turns in rad that are added to the yaw of the block `turned`, so that the yaw stays continuous between blocks.
    turns_rad: f64,
    turned: Option<usize>,
}

impl RecordedSource {
    /// A source that starts at tick `first` of `playback`; `None` if there is no such tick.
    pub fn new(playback: &Arc<Playback>, first: usize) -> Option<Self> {
        let mut cursor = Cursor::new(playback);
        let frame = cursor.frame(first)?.clone();
        Some(Self { cursor, next: first, frame, last_psi: None, turns_rad: 0.0, turned: None })
    }

    /// The next measurement; after the end, the last measurement again.
    fn play(&mut self) -> Measurement {
        if let Some(frame) = self.cursor.frame(self.next) {
            self.frame.clone_from(frame);
            self.next += 1;
        }
        self.continued()
    }

    /// The measurement of the frame with a yaw that is continuous with the yaw before.
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
