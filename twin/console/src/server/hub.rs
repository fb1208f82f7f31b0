//! Passes the data of the flight on to the clients. The flight thread only waits here while a few pointers are copied.
//!
//! A client that joins receives the snapshot and its place in the list under one lock, so it misses no later message.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use crate::server::admission::budget::Budget;
use crate::server::agenda::Tally;
use crate::server::forks::ForkList;
use crate::server::outbox::{CloseReason, Message, Outbox, RecentRows, SharedMessage};
use crate::server::pace::now;
use crate::server::protocol::{FlightPhase, Notice, NoticeLevel, ServerMessage};
use crate::server::published::Published;
use crate::server::socket::code;
use crate::server::telemetry::Picture;
use twin_core::tick::Tick;

/// One connected client.
#[derive(Debug)]
pub(super) struct Client {
    /// Its number.
    pub id: u64,
    /// Wakes the client's task when its outbox has data.
    pub wake: Notify,
    outbox: Mutex<Outbox>,
    budget: Mutex<Budget>,
}

impl Client {
    /// Messages and ticks that wait to be sent to the client.
    pub(super) fn outbox(&self) -> MutexGuard<'_, Outbox> {
        self.outbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the client may still ask.
    pub(super) fn budget(&self) -> MutexGuard<'_, Budget> {
        self.budget.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends a notice to this client only; it is dropped if the outbox is full.
    pub(super) fn notice(&self, level: NoticeLevel, text: impl Into<String>) {
        self.say(ServerMessage::Notice(Notice { level, text: text.into() }));
    }

    /// Sends a message to this client only; it is dropped if the outbox is full.
    pub(super) fn say(&self, message: ServerMessage) {
        if !self.outbox().push_message(Message::Shared(Arc::new(message.into()))) {
            tracing::debug!("client {} does not read; a message to it was dropped", self.id);
        }
        self.wake.notify_one();
    }

    /// Closes the connection with a reason.
    pub(super) fn close(&self, code: u16, reason: impl Into<String>) {
        self.outbox().close(CloseReason { code, reason: reason.into() });
        self.wake.notify_one();
    }
}

struct Shared {
    published: Published,
    past: RecentRows,
    clients: BTreeMap<u64, Arc<Client>>,
    next_id: u64,
    flying: bool,
    /// Ticks are stored but not yet sent to any client.
    holding: bool,
}

/// Connects the flight with the clients.
pub(super) struct Hub {
    shared: Mutex<Shared>,
    crowd: AtomicU32,
    /// Counts of commands.
    pub tally: Arc<Tally>,
    /// The forks of the flight.
    pub forks: Arc<ForkList>,
    /// True while the flight thread computes a tick.
    ticking: AtomicBool,
}

impl Hub {
    /// A hub without clients.
    pub(super) fn new(published: Published) -> Self {
        Self {
            forks: Arc::clone(&published.forks),
            ticking: AtomicBool::new(false),
            shared: Mutex::new(Shared {
                published,
                past: RecentRows::default(),
                clients: BTreeMap::new(),
                next_id: 1,
                flying: true,
                holding: false,
            }),
            crowd: AtomicU32::new(0),
            tally: Arc::default(),
        }
    }

    /// Number of clients, read without a lock.
    pub(super) fn crowd(&self) -> u32 {
        self.crowd.load(Ordering::Relaxed)
    }

    fn shared(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a client.
    pub(super) fn join(&self) -> Arc<Client> {
        let mut shared = self.shared();
        let client = Arc::new(Client {
            id: shared.next_id,
            wake: Notify::new(),
            outbox: Mutex::default(),
            budget: Mutex::new(Budget::new(now())),
        });
        shared.next_id += 1;
        shared.clients.insert(client.id, Arc::clone(&client));
        shared.published.state.clients = shared.clients.len();
        self.crowd.store(shared.clients.len() as u32, Ordering::Relaxed);
        let mut outbox = client.outbox();
        outbox.begin(shared.published.schema_id, false);
        outbox.start_over(Arc::new(shared.published.clone()));
        if !shared.holding {
            outbox.catch_up(&shared.past);
        }
        drop(outbox);
        client.wake.notify_one();
        client
    }

    /// Removes a client.
    pub(super) fn leave(&self, id: u64) {
        let mut shared = self.shared();
        shared.clients.remove(&id);
        shared.published.state.clients = shared.clients.len();
        self.crowd.store(shared.clients.len() as u32, Ordering::Relaxed);
    }

    /// The description of the flight in its present state.
    pub(super) fn published(&self) -> Published {
        self.shared().published.clone()
    }

    /// True while the flight thread runs.
    pub(super) fn is_flying(&self) -> bool {
        self.shared().flying
    }

    /// Notes that the flight thread ended.
    pub(super) fn landed(&self) {
        self.shared().flying = false;
    }

    /// Phase of the flight.
    pub(super) fn phase(&self) -> FlightPhase {
        self.shared().published.state.phase
    }

    /// Simulated time of the newest tick, s.
    pub(super) fn simulated_s(&self) -> f64 {
        self.shared().published.state.t_s
    }

    /// Sends a tick to all clients and stores it for clients that join later.
    pub(super) fn tick(&self, tick: &Tick, draw: impl FnOnce() -> (Arc<[f32]>, Arc<Picture>)) {
        let (row, picture) = draw();
        let clients: Vec<Arc<Client>> = {
            let mut shared = self.shared();
            shared.published.state.tick = tick.index + 1;
            shared.published.state.t_s = tick.measurement.t_s;
            shared.past.push_tick(tick.index, Arc::clone(&row), Arc::clone(&picture));
            if shared.holding {
                return;
            }
            shared.clients.values().cloned().collect()
        };
        for client in clients {
            client.outbox().push_tick(tick.index, Arc::clone(&row), Arc::clone(&picture));
            client.wake.notify_one();
        }
    }

    /// Says whether the flight thread computes a tick now.
    pub(super) fn set_ticking(&self, ticking: bool) {
        self.ticking.store(ticking, Ordering::Relaxed);
    }

    /// Returns when the flight thread computes no tick, so that other work takes only what is left of the machine.
    pub(super) fn wait_for_tick(&self) {
        while self.ticking.load(Ordering::Relaxed) && self.is_flying() {
            std::thread::yield_now();
        }
    }

    /// From now until [`Self::release`] ticks are only stored: they are flown faster than clients could receive them.
    pub(super) fn hold(&self) {
        self.shared().holding = true;
    }

    /// Sends the stored ticks to all clients as the past of the following ticks.
    pub(super) fn release(&self) {
        let mut shared = self.shared();
        shared.holding = false;
        for client in shared.clients.values() {
            client.outbox().catch_up(&shared.past);
            client.wake.notify_one();
        }
    }

    /// Changes the description and sends the change to all clients. A client whose outbox overflows receives the whole description instead.
    pub(super) fn publish(&self, change: impl FnOnce(&mut Published) -> Vec<ServerMessage>) {
        let mut shared = self.shared();
        let messages: Vec<Arc<SharedMessage>> = change(&mut shared.published)
            .into_iter()
            .map(|message| Arc::new(SharedMessage::from(message)))
            .collect();
        for client in shared.clients.values() {
            let mut outbox = client.outbox();
            if !messages.iter().all(|told| outbox.push_message(Message::Shared(Arc::clone(told)))) {
                outbox.start_over(Arc::new(shared.published.clone()));
            }
            drop(outbox);
            client.wake.notify_one();
        }
    }

    /// Publishes a restarted flight.
    pub(super) fn restart(&self, published: Published) {
        let mut shared = self.shared();
        shared.published = published;
        shared.past = RecentRows::default();
        shared.published.state.clients = shared.clients.len();
        let published = Arc::new(shared.published.clone());
        let reset = Arc::new(SharedMessage::from(ServerMessage::Reset {}));
        for client in shared.clients.values() {
            let mut outbox = client.outbox();
            outbox.begin(published.schema_id, true);
            let fits = outbox.push_message(Message::Shared(Arc::clone(&reset)))
                && outbox.push_message(Message::Hello(Arc::clone(&published)));
            if !fits {
                outbox.start_over(Arc::clone(&published));
            }
            drop(outbox);
            client.wake.notify_one();
        }
    }

    /// Sends a notice to one client, or to all.
    pub(super) fn notice(&self, client: Option<u64>, level: NoticeLevel, text: &str) {
        let shared = self.shared();
        for listener in
            shared.clients.values().filter(|listener| client.is_none_or(|id| id == listener.id))
        {
            listener.notice(level, text);
        }
    }

    /// Closes every connection.
    pub(super) fn close_all(&self, reason: &str) {
        for client in self.shared().clients.values() {
            client.close(code::GOING_AWAY, reason);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::server::outbox::MOST_ROWS;
    use crate::server::served_flight::ServedFlight;
    use twin_scenario::Scenario;

    const HOVER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/hover.toml");

    #[test]
    fn ticks_that_come_faster_than_anybody_reads_reach_everybody_as_one_past() {
        let scenario = Scenario::load(Path::new(HOVER), &[]).unwrap();
        let mut served = ServedFlight::new(scenario).unwrap();
        let hub = Hub::new(served.published(Arc::default(), None, false));
        let before = hub.join();
        let mut fly = |ticks: usize| {
            for _ in 0..ticks {
                let tick = served.flight.tick();
                hub.tick(&tick, || served.draw(&tick));
            }
        };
        hub.hold();
        fly(MOST_ROWS);
        let meanwhile = hub.join();
        fly(MOST_ROWS);
        assert!(meanwhile.outbox().take().telemetry.is_none());
        hub.release();
        fly(1);
        for client in [before, meanwhile] {
            let telemetry = client.outbox().take().telemetry.unwrap();
            assert_eq!(
                (telemetry.first_tick, telemetry.rows.len(), telemetry.gap),
                (0, 2 * MOST_ROWS + 1, 0)
            );
        }
    }
}
