//! The last `T_l` ticks, which every predictor sees.
//!
//! In: one measurement and one residual per tick. Out: windows, oldest tick first.

use std::collections::VecDeque;

use crate::notation::{Coords, KnownMask, N};

/// One tick of history.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Coordinates.
    pub chi: Coords,
    /// Rates.
    pub chi_dot: Coords,
    /// Applied force of the *previous* tick, `tau_{t-1}`, because `tau_t` is still unknown when `r_t` is forecast.
    pub tau_previous: Coords,
    /// Residual of the previous tick, `r_{t-1}`.
    pub residual_previous: Coords,
    /// The coordinates whose residual of the previous tick was known; a stand-in is in the others.
    pub known_previous: KnownMask,
}

/// A window of bounded length; the newest entry is last.
#[derive(Clone, Debug)]
pub struct History {
    entries: VecDeque<Entry>,
    capacity: usize,
    last: Option<(Coords, Coords, KnownMask)>,
}

impl History {
    /// An empty history for `capacity` ticks.
    pub fn new(capacity: usize) -> Self {
        Self { entries: VecDeque::with_capacity(capacity), capacity: capacity.max(1), last: None }
    }

    /// Makes room for at least `capacity` ticks; the ticks in it stay.
    pub fn lengthen(&mut self, capacity: usize) {
        self.capacity = self.capacity.max(capacity);
    }

    /// Appends tick `t`, whose residual is known in every coordinate; its `tau` and `residual` become visible at `t + 1`.
    pub fn push(&mut self, chi: Coords, chi_dot: Coords, tau: Coords, residual: Coords) {
        self.push_masked(chi, chi_dot, tau, residual, [true; N]);
    }

    /// Appends tick `t`, whose residual is a stand-in in the coordinates that are not `known`.
    pub fn push_masked(
        &mut self,
        chi: Coords,
        chi_dot: Coords,
        tau: Coords,
        residual: Coords,
        known: KnownMask,
    ) {
        let (tau_previous, residual_previous, known_previous) =
            self.last.unwrap_or((tau, residual, known));
        if self.entries.len() == self.capacity {
            self.entries.pop_front();
        }
        self.entries.push_back(Entry {
            chi,
            chi_dot,
            tau_previous,
            residual_previous,
            known_previous,
        });
        self.last = Some((tau, residual, known));
    }

    /// The newest entry.
    pub fn newest(&self) -> Option<&Entry> {
        self.entries.back()
    }

    /// Entries, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter()
    }

    /// Number of stored ticks.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// True if no tick was appended yet.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn force_and_residual_become_visible_one_tick_later() {
        let mut history = History::new(3);
        for i in 0..5 {
            let v = Coords::repeat(f64::from(i));
            history.push(v, v, v * 10.0, v * 100.0);
        }
        assert_eq!(history.len(), 3);
        let newest = history.newest().unwrap();
        assert_eq!(
            (newest.chi[0], newest.tau_previous[0], newest.residual_previous[0]),
            (4.0, 30.0, 300.0)
        );
    }
    #[test]
    fn the_mask_of_a_residual_becomes_visible_with_it() {
        let mut history = History::new(3);
        let (zeros, mut known) = (Coords::zeros(), [true; N]);
        known[4] = false;
        history.push_masked(zeros, zeros, zeros, zeros, known);
        history.push(zeros, zeros, zeros, zeros);
        assert_eq!(history.newest().unwrap().known_previous, known);
        history.push(zeros, zeros, zeros, zeros);
        assert_eq!(history.newest().unwrap().known_previous, [true; N]);
    }
}
