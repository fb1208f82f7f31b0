//! The forks of a served flight: what clients are told about them, and their rows.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::server::command::Asked;
use crate::server::protocol::{ForkInfo, ForkState};
use twin_scenario::fork::MOST_FORKS;

/// The rows of a fork from one tick on, and the number of the first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::server) struct ForkRows {
    /// Number of the tick of the first row.
    pub first_tick: u64,
    /// One row per tick, in the channels of the flight.
    pub rows: Vec<Arc<[f32]>>,
}

/// A fork.
#[derive(Debug)]
struct Kept {
    info: ForkInfo,
    rows: Vec<Arc<[f32]>>,
}

/// All forks. Every access is short, so the flight thread may wait for it.
#[derive(Debug, Default)]
pub(in crate::server) struct ForkList {
    kept: Mutex<(VecDeque<Kept>, u32)>,
}

impl ForkList {
    fn kept(&self) -> MutexGuard<'_, (VecDeque<Kept>, u32)> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a fork that begins at `at_s`, and returns its identifier.
    ///
    /// # Errors
    /// The number of forks, if there are enough.
    pub(super) fn add(&self, asked: &Asked, at_s: f64) -> Result<u32, usize> {
        let mut kept = self.kept();
        let (forks, last) = &mut *kept;
        if forks.len() >= MOST_FORKS {
            return Err(forks.len());
        }
        *last += 1;
        // Colours stay with a fork, so a new one takes the first that is free.
        let free = |slot: &u32| forks.iter().all(|fork| fork.info.slot != *slot);
        let slot = (0..MOST_FORKS as u32).find(free).unwrap_or_default();
        let name = if asked.name.is_empty() { format!("fork {last}") } else { asked.name.clone() };
        let info = ForkInfo {
            id: *last,
            slot,
            name,
            at_s,
            set: asked.set.clone(),
            changed: Vec::new(),
            state: ForkState::Waiting,
            ticks: 0,
            flown_s: at_s,
            outcome: None,
            metrics: Vec::new(),
        };
        forks.push_back(Kept { info, rows: Vec::new() });
        Ok(*last)
    }

    /// Removes a fork; false if there is none of this identifier.
    pub(in crate::server) fn drop_fork(&self, id: u32) -> bool {
        let mut kept = self.kept();
        let before = kept.0.len();
        kept.0.retain(|fork| fork.info.id != id);
        kept.0.len() < before
    }

    /// Gives a fork another name; false if there is none of this identifier.
    pub(in crate::server) fn rename(&self, id: u32, name: &str) -> bool {
        let mut kept = self.kept();
        let fork = kept.0.iter_mut().find(|fork| fork.info.id == id);
        fork.map(|fork| name.clone_into(&mut fork.info.name)).is_some()
    }

    /// Removes all forks.
    pub(super) fn clear(&self) {
        self.kept().0.clear();
    }

    /// Changes what is told about a fork and adds rows to it; false if it was dropped.
    pub(super) fn update(
        &self,
        id: u32,
        rows: &mut Vec<Arc<[f32]>>,
        change: impl FnOnce(&mut ForkInfo),
    ) -> bool {
        let mut kept = self.kept();
        let Some(fork) = kept.0.iter_mut().find(|fork| fork.info.id == id) else { return false };
        fork.rows.append(rows);
        fork.info.ticks = fork.rows.len() as u64;
        change(&mut fork.info);
        true
    }

    /// What clients are told.
    pub(in crate::server) fn infos(&self) -> Vec<ForkInfo> {
        self.kept().0.iter().map(|fork| fork.info.clone()).collect()
    }

    /// The rows of a fork from its row `from` on; `None` if there is no such fork.
    pub(in crate::server) fn rows(&self, id: u32, from: usize) -> Option<ForkRows> {
        let kept = self.kept();
        let fork = kept.0.iter().find(|fork| fork.info.id == id)?;
        let from = from.min(fork.rows.len());
        let first_tick =
            (fork.info.at_s / twin_core::notation::TICK_S).round() as u64 + from as u64;
        Some(ForkRows { first_tick, rows: fork.rows[from..].to_vec() })
    }
}
