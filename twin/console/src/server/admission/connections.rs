//! The open TCP connections of a server. If there are too many, the oldest one that waits for a request gives its place to the new one:
//! whoever opens connections and sends nothing locks nobody out.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use crate::server::admission::Limits;
use crate::server::admission::refusals::{Refusal, Refusals};

/// Connections that lost their place and are not closed yet may exceed the limit by this number.
const CLOSING: usize = 16;

/// One TCP connection.
pub(in crate::server) struct Connection {
    /// Address of its other end.
    pub address: IpAddr,
    /// Whether a request is being answered, or a socket is open.
    busy: AtomicBool,
    displaced: Notify,
}

impl Connection {
    /// A request has arrived.
    pub(in crate::server) fn begin(&self) {
        self.busy.store(true, Ordering::Relaxed);
    }

    /// The request is answered; the connection waits for the next one.
    pub(in crate::server) fn end(&self) {
        self.busy.store(false, Ordering::Relaxed);
    }

    /// Waits until the connection loses its place.
    pub(in crate::server) async fn displaced(&self) {
        self.displaced.notified().await;
    }
}

/// The open connections, in the order in which they were opened.
pub(in crate::server) struct Connections {
    limits: Limits,
    refusals: Arc<Refusals>,
    open: Mutex<Open>,
}

#[derive(Default)]
struct Open {
    next: u64,
    by_number: BTreeMap<u64, Arc<Connection>>,
}

/// The place of one connection; dropping it frees the place.
pub(in crate::server) struct Ticket {
    number: u64,
    connections: Arc<Connections>,
    /// The connection.
    pub connection: Arc<Connection>,
}

impl Connections {
    /// No connection is open.
    pub(in crate::server) fn new(limits: Limits, refusals: Arc<Refusals>) -> Self {
        Self { limits, refusals, open: Mutex::default() }
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of open connections.
    pub(in crate::server) fn count(&self) -> usize {
        self.open().by_number.len()
    }

    /// Gives a new connection from `address` a place.
    ///
    /// # Errors
    /// [`Refusal::Connections`] or [`Refusal::Address`] if there are too many, and all of them are busy.
    pub(in crate::server) fn admit(self: &Arc<Self>, address: IpAddr) -> Result<Ticket, Refusal> {
        let mut open = self.open();
        let of_address = open.by_number.values().filter(|known| known.address == address).count();
        if of_address >= self.limits.connections_of_address {
            let room = of_address < self.limits.connections_of_address + CLOSING;
            if !room || !open.displace(|known| known.address == address) {
                return Err(Refusal::Address);
            }
            self.refusals.note(
                Refusal::Displaced,
                &"a connection that sent nothing made room for a new one",
            );
        } else if open.by_number.len() >= self.limits.connections {
            let room = open.by_number.len() < self.limits.connections + CLOSING;
            if !room || !open.displace(|_| true) {
                return Err(Refusal::Connections);
            }
            self.refusals.note(
                Refusal::Displaced,
                &"a connection that sent nothing made room for a new one",
            );
        }
        let number = open.next;
        open.next += 1;
        let connection = Arc::new(Connection {
            address,
            busy: AtomicBool::new(false),
            displaced: Notify::new(),
        });
        open.by_number.insert(number, Arc::clone(&connection));
        Ok(Ticket { number, connections: Arc::clone(self), connection })
    }
}

impl Open {
    /// Takes the place of the oldest waiting connection for which `fits` is true; returns `false` if there is none.
    fn displace(&self, fits: impl Fn(&Connection) -> bool) -> bool {
        let waits = |known: &&Arc<Connection>| !known.busy.load(Ordering::Relaxed) && fits(known);
        let oldest = self.by_number.values().find(waits);
        if let Some(oldest) = oldest {
            // It is chosen only once.
            oldest.begin();
            oldest.displaced.notify_one();
        }
        oldest.is_some()
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        self.connections.open().by_number.remove(&self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);
    const ELSEWHERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(127, 0, 0, 2));

    fn few() -> Arc<Connections> {
        let limits = Limits { connections: 4, connections_of_address: 3, ..Limits::STANDARD };
        Arc::new(Connections::new(limits, Arc::new(Refusals::new())))
    }

    #[test]
    fn a_connection_that_waits_makes_room_and_one_that_works_does_not() {
        let connections = few();
        let tickets: Vec<Ticket> = (0..3).map(|_| connections.admit(HERE).unwrap()).collect();
        tickets[0].connection.begin();
        let fourth = connections.admit(HERE).expect("the second one waits");
        let chosen = |ticket: &Ticket| ticket.connection.busy.load(Ordering::Relaxed);
        assert!(chosen(&tickets[1]) && !chosen(&tickets[2]), "the oldest that waits");
        for ticket in &tickets {
            ticket.connection.begin();
        }
        fourth.connection.begin();
        assert_eq!(connections.admit(HERE).err(), Some(Refusal::Address));
    }

    #[test]
    fn one_address_leaves_room_for_another_and_a_closed_connection_frees_its_place() {
        let connections = few();
        let tickets: Vec<Ticket> = (0..3).map(|_| connections.admit(HERE).unwrap()).collect();
        for ticket in &tickets {
            ticket.connection.begin();
        }
        assert_eq!(connections.admit(HERE).err(), Some(Refusal::Address));
        let other = connections.admit(ELSEWHERE).expect("its address has room");
        other.connection.begin();
        assert_eq!(connections.admit(ELSEWHERE).err(), Some(Refusal::Connections));
        drop(tickets);
        assert!(connections.admit(HERE).is_ok());
        assert_eq!(connections.count(), 1);
    }
}
