//! The last `T_l` ticks, which every predictor sees.
//!
//! In: one measurement and one residual per tick. Out: windows, oldest tick first.

use std::collections::VecDeque;

use crate::notation::Coords;

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
}

/// A window of bounded length; the newest entry is last.
#[derive(Clone, Debug)]
pub struct History {
    entries: VecDeque<Entry>,
    capacity: usize,
    last: Option<(Coords, Coords)>,
}

impl History {
    /// An empty history for `capacity` ticks.
    pub fn new(capacity: usize) -> Self {
        Self { entries: VecDeque::with_capacity(capacity), capacity: capacity.max(1), last: None }
    }

    /// Appends tick `t`; its `tau` and `residual` become visible at `t + 1`.
    pub fn push(&mut self, chi: Coords, chi_dot: Coords, tau: Coords, residual: Coords) {
        let (tau_previous, residual_previous) = self.last.unwrap_or((tau, residual));
        if self.entries.len() == self.capacity {
            self.entries.pop_front();
        }
        self.entries.push_back(Entry { chi, chi_dot, tau_previous, residual_previous });
        self.last = Some((tau, residual));
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
}
