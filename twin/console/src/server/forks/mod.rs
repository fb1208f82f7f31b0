//! Forks of the flight that is served: copies of a past or present moment with other settings, flown ahead on a thread of their own.
//!
//! In: the flight before each tick, what operators ask of it, and the forks that they ask for. Out: the list of forks in the description of
//! the flight, and the rows of each fork for `/api/forks/{id}/{from}`. State: copies of the last fifteen minutes, and the forks. The flight thread
//! copies the flight once a second and never waits for a fork.

mod moment;
mod flying;
mod list;

pub(super) use list::{ForkList, ForkRows};
pub(super) use moment::Moment;

use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};

use crate::server::command::Asked;
use crate::server::forks::flying::{Job, fly_all};
use crate::server::hub::Hub;
use crate::server::served_flight::ServedFlight;
use twin_core::flight::snapshots::{Change, SnapshotError, Snapshots, Way};
use twin_core::notation::TICK_S;
use twin_core::source::Disturbance;
use twin_core::tuning::Tuning;

/// Why a fork does not begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum ForkRefusal {
    /// There are enough forks.
    #[error("fork refused: {0} forks are kept already; drop one of them first")]
    TooMany(usize),
    /// The moment is not in memory.
    #[error("fork refused: {0}")]
    Moment(#[from] SnapshotError),
    /// The flight is over.
    #[error(
        "fork refused: the flight ended at {end_s:.2} s; choose an earlier moment, or restart it"
    )]
    Ended {
        /// Time of the last tick, s.
        end_s: f64,
    },
    /// The thread that flies forks is gone.
    #[error("fork refused: the thread that flies forks has stopped; start the server again")]
    Stopped,
}

/// The memory of the flight thread, and the way to the thread that flies forks.
pub(super) struct Forks {
    snapshots: Snapshots<Moment>,
    jobs: Sender<Job>,
    list: Arc<ForkList>,
}

impl Forks {
    /// No fork; starts the thread that flies them, which publishes through `hub`.
    ///
    /// # Errors
    /// If the system refuses the thread.
    pub(super) fn new(hub: &Arc<Hub>) -> std::io::Result<Self> {
        let (jobs, inbox) = channel();
        let list = Arc::clone(&hub.forks);
        let hub = Arc::clone(hub);
        std::thread::Builder::new()
            .name("forks".to_owned())
            .spawn(move || fly_all(&inbox, &hub))?;
        Ok(Self { snapshots: Snapshots::default(), jobs, list })
    }

    /// Forgets the past, for another flight. The forks stay until they are dropped or the flight is replaced.
    pub(super) fn start_over(&mut self) {
        self.snapshots = Snapshots::default();
        self.list.clear();
    }

    /// Sees the flight directly before a tick.
    pub(super) fn before_tick(&mut self, served: &ServedFlight) {
        if served.mirrored.is_none() {
            self.snapshots.before_tick(served.next_tick, || Moment::of(served));
        }
    }

    /// Remembers the values in force from `tick` on.
    pub(super) fn tuned(&mut self, tick: u64, tuning: &Tuning) {
        self.snapshots.changed(tick, Change::Tuning(Box::new(*tuning)));
    }

    /// Remembers a change of the world before `tick`.
    pub(super) fn disturbed(&mut self, tick: u64, disturbance: Disturbance, goes_on: bool) {
        let change =
            if goes_on { Change::Prolong(disturbance) } else { Change::Disturb(disturbance) };
        self.snapshots.changed(tick, change);
    }

    /// Hands a fork to the thread that flies forks.
    ///
    /// # Errors
    /// [`ForkRefusal`] in words for the operator who asked.
    pub(super) fn begin(&mut self, asked: Asked, served: &ServedFlight) -> Result<(), ForkRefusal> {
        let next = served.next_tick;
        let tick = asked.tick.unwrap_or(next);
        if tick >= next && served.verdict.is_some() {
            return Err(ForkRefusal::Ended { end_s: served.t_s });
        }
        let way = if tick == next {
            Way::here(Moment::of(served))
        } else {
            self.snapshots.way_to(tick)?
        };
        let id = self.list.add(&asked, tick as f64 * TICK_S).map_err(ForkRefusal::TooMany)?;
        let job = Job {
            id,
            way,
            set: asked.set,
            scenario: served.scenario.clone(),
            channels: Arc::clone(&served.channels),
        };
        self.jobs.send(job).map_err(|_| ForkRefusal::Stopped)
    }
}
