//! Decides who may connect and how much may be asked.
//!
//! In: connections, frames and commands as they arrive. Out: a place or a [`Refusal`], and the time for which a connection must wait. State:
//! the open connections, the places of clients, and the budgets. Every refusal is counted in `/metrics`.

mod limits;
pub(super) mod budget;
pub(super) mod refusals;
pub(super) mod connections;
pub(super) mod places;

pub use limits::Limits;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::server::admission::budget::{ALL_PER_S, Bucket};
use crate::server::admission::connections::Connections;
use crate::server::admission::places::Places;
use crate::server::admission::refusals::Refusals;
use crate::server::pace;

/// The state of admission, which both ports share.
pub(super) struct Admission {
    /// The limits in force.
    pub limits: Limits,
    /// Counts of refusals.
    pub refusals: Arc<Refusals>,
    /// Open TCP connections.
    pub connections: Arc<Connections>,
    /// Places of clients.
    pub places: Arc<Places>,
    /// What all clients together may ask.
    overall: Mutex<Bucket>,
}

impl Admission {
    /// Nobody is connected yet.
    pub(super) fn new(limits: Limits) -> Self {
        let refusals = Arc::new(Refusals::new());
        Self {
            limits,
            connections: Arc::new(Connections::new(limits, Arc::clone(&refusals))),
            places: Arc::new(Places::new(limits)),
            overall: Mutex::new(Bucket::new(ALL_PER_S, pace::now())),
            refusals,
        }
    }

    /// The budget of all clients together.
    pub(super) fn overall(&self) -> MutexGuard<'_, Bucket> {
        self.overall.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
