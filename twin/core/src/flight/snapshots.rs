//! The recent past of a flight as something that can be flown again: copies of the flight at regular ticks, and what was asked of it
//! between them.
//!
//! In: the flight before each tick, and every change from outside. Out: the flight as it was before any tick since the oldest copy. State:
//! the copies and the changes, both bounded.

use std::collections::VecDeque;

use super::Flight;
use crate::source::Disturbance;
use crate::tuning::Tuning;

/// Ticks between two copies: one per second, so that a rebuilt moment is at most 99 ticks of flying away.
pub const EVERY_TICKS: u64 = 100;

/// Copies that are kept: fifteen minutes of flight. A copy takes 0.2 to 0.3 MB, and 0.3 MB more while the
/// whole horizon is corrected.
pub const MOST_COPIES: usize = 900;

/// Changes that are kept. A dragged slider makes 50 a second, so this is three minutes of dragging without a pause.
const MOST_CHANGES: usize = 9_000;

/// A change from outside that a flight took between two ticks.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// [`Flight::set_tuning`].
    Tuning(Box<Tuning>),
    /// [`Flight::disturb`].
    Disturb(Disturbance),
    /// [`Flight::prolong`].
    Prolong(Disturbance),
}

/// A flight with all that has to be copied with it.
pub trait Moment: Clone {
    /// The flight.
    fn flight(&self) -> &Flight;

    /// Flies a tick.
    fn tick(&mut self);

    /// Takes a change before the next tick.
    fn take(&mut self, change: &Change);
}

impl Moment for Flight {
    fn flight(&self) -> &Flight {
        self
    }

    fn tick(&mut self) {
        self.tick_with(&mut |_| {});
    }

    fn take(&mut self, change: &Change) {
        match change {
            Change::Tuning(tuning) => self.set_tuning(**tuning),
            Change::Disturb(disturbance) => self.disturb(disturbance),
            Change::Prolong(disturbance) => self.prolong(disturbance),
        }
    }
}

/// Why a moment cannot be flown again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SnapshotError {
    /// The moment is older than the oldest copy.
    #[error(
        "tick {asked} is no longer in memory, the oldest is tick {oldest}; use the recording for older ones"
    )]
    TooOld {
        /// Tick that was asked for.
        asked: u64,
        /// Oldest tick that can be given.
        oldest: u64,
    },
    /// The flight has not been there yet.
    #[error("tick {asked} is not flown yet, the newest is tick {newest}; choose an earlier moment")]
    NotFlown {
        /// Tick that was asked for.
        asked: u64,
        /// Newest tick that was flown.
        newest: u64,
    },
    /// There is no copy at all.
    #[error("no moment of this flight is in memory")]
    Empty,
}

/// The recent past of one flight.
#[derive(Clone)]
pub struct Snapshots<T = Flight> {
    copies: VecDeque<T>,
    changes: VecDeque<(u64, Change)>,
    most_copies: usize,
    newest: u64,
}

impl<T: Moment> Default for Snapshots<T> {
    fn default() -> Self {
        Self::with_room(MOST_COPIES)
    }
}

impl<T: Moment> Snapshots<T> {
    /// An empty past that keeps at most `most_copies` copies, at least one.
    pub fn with_room(most_copies: usize) -> Self {
        let most_copies = most_copies.max(1);
        Self { copies: VecDeque::new(), changes: VecDeque::new(), most_copies, newest: 0 }
    }

    /// Sees the flight directly before the tick `next`, after all changes for that tick; `copy` makes a copy of it.
    pub fn before_tick(&mut self, next: u64, copy: impl FnOnce() -> T) {
        self.newest = next;
        if !self.copies.is_empty() && !self.newest.is_multiple_of(EVERY_TICKS) {
            return;
        }
        if self.copies.len() == self.most_copies {
            self.copies.pop_front();
        }
        self.copies.push_back(copy());
        let oldest = self.copies.front().map_or(0, |copy| copy.flight().index());
        self.changes.retain(|(tick, _)| *tick > oldest);
    }

    /// Remembers a change that the flight took before `tick`.
    pub fn changed(&mut self, tick: u64, change: Change) {
        // A tuning replaces the one before it, unless something else happened in between.
        if let Some((last, Change::Tuning(held))) = self.changes.back_mut()
            && let Change::Tuning(new) = &change
            && *last == tick
        {
            held.clone_from(new);
            return;
        }
        if self.changes.len() == MOST_CHANGES {
            // Copies before the forgotten change can no longer be flown on beyond it.
            let forgotten = self.changes.pop_front().map_or(0, |(tick, _)| tick);
            self.copies.retain(|copy| copy.flight().index() >= forgotten);
        }
        self.changes.push_back((tick, change));
    }

    /// The ticks from the oldest to the newest that can be given; `None` if there is none.
    pub fn ticks(&self) -> Option<std::ops::RangeInclusive<u64>> {
        self.copies.front().map(|oldest| oldest.flight().index()..=self.newest)
    }

    /// Number of copies in memory.
    pub fn len(&self) -> usize {
        self.copies.len()
    }

    /// True if there is no copy.
    pub fn is_empty(&self) -> bool {
        self.copies.is_empty()
    }

    /// What it takes to fly to the moment directly before `tick`, after the changes for that tick.
    ///
    /// # Errors
    /// [`SnapshotError`] if the tick is too old or not flown yet.
    pub fn way_to(&self, tick: u64) -> Result<Way<T>, SnapshotError> {
        let oldest = self.copies.front().ok_or(SnapshotError::Empty)?.flight().index();
        if tick > self.newest {
            return Err(SnapshotError::NotFlown { asked: tick, newest: self.newest });
        }
        let place = self.copies.partition_point(|copy| copy.flight().index() <= tick);
        let Some(copy) = place.checked_sub(1).and_then(|place| self.copies.get(place)) else {
            return Err(SnapshotError::TooOld { asked: tick, oldest });
        };
        let between = copy.flight().index() + 1..=tick;
        let changes = self.changes.iter().filter(|(at, _)| between.contains(at)).cloned();
        Ok(Way { changes: changes.collect(), copy: copy.clone(), tick })
    }

    /// The moment directly before `tick`, after the changes for that tick.
    ///
    /// # Errors
    /// Those of [`Snapshots::way_to`].
    pub fn at(&self, tick: u64) -> Result<T, SnapshotError> {
        self.way_to(tick).map(Way::fly)
    }
}

/// A copy of a flight, and the changes that it took between the copy and a later tick.
#[derive(Clone)]
pub struct Way<T = Flight> {
    copy: T,
    changes: Vec<(u64, Change)>,
    tick: u64,
}

impl<T: Moment> Way<T> {
    /// The way to a moment that is at hand: nothing has to be flown.
    pub fn here(moment: T) -> Self {
        Self { tick: moment.flight().index(), changes: Vec::new(), copy: moment }
    }

    /// Flies to the tick. This takes as long as at most [`EVERY_TICKS`] ticks do.
    pub fn fly(self) -> T {
        let Self { mut copy, changes, tick } = self;
        let mut changes = changes.into_iter().peekable();
        while copy.flight().index() < tick {
            copy.tick();
            while let Some((_, change)) = changes.next_if(|(at, _)| *at <= copy.flight().index()) {
                copy.take(&change);
            }
        }
        copy
    }
}
