//! The places of clients: consoles, viewers and Foxglove.
//!
//! A page that is open always gets a place again. If its connection broke, its place is kept for a while. If the server has not noticed the
//! break yet, there are a few places beyond the limit, for pages that are open already.

use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::server::admission::Limits;
use crate::server::admission::refusals::Refusal;
use crate::server::pace::now;

/// Most places that are kept: a quarter of all. Pages that come and go cannot keep everybody else out.
const KEPT_SHARE: usize = 4;

/// Places beyond the limit for pages that are open: all pages of one operator, when the network changes under them.
const RESERVE: usize = 16;

/// What is known about a client before it says anything. Two connections of one page have equal visitors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::server) struct Visitor {
    /// Address of its connection.
    pub address: IpAddr,
    /// Path that it asked for.
    pub path: String,
    /// Page that opened the connection; `None` for a program.
    pub origin: Option<String>,
    /// Name of the browser.
    pub agent: Option<String>,
}

/// The places of a server.
pub(in crate::server) struct Places {
    limits: Limits,
    taken: Mutex<Taken>,
}

#[derive(Default)]
struct Taken {
    /// The clients that have a place.
    seated: Vec<Visitor>,
    /// Places that are kept, with the time until which they are, oldest first.
    kept: Vec<(Visitor, Instant)>,
}

/// A place; dropping it frees the place.
pub(in crate::server) struct Place {
    places: Arc<Places>,
    visitor: Visitor,
}

impl Places {
    /// All places are free.
    pub(in crate::server) fn new(limits: Limits) -> Self {
        Self { limits, taken: Mutex::default() }
    }

    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives `visitor` a place.
    ///
    /// # Errors
    /// [`Refusal::Clients`] or [`Refusal::Address`] if there are too many clients.
    pub(in crate::server) fn take(self: &Arc<Self>, visitor: Visitor) -> Result<Place, Refusal> {
        self.take_at(visitor, now())
    }

    fn take_at(self: &Arc<Self>, visitor: Visitor, now: Instant) -> Result<Place, Refusal> {
        let mut taken = self.taken();
        taken.kept.retain(|(_, until)| *until > now);
        if let Some(own) = taken.kept.iter().position(|(kept, _)| *kept == visitor) {
            taken.kept.remove(own);
        } else {
            let is_open = visitor.origin.is_some() && taken.seated.contains(&visitor);
            let more = if is_open { RESERVE } else { 0 };
            if taken.count(|_| true) >= self.limits.clients + more {
                return Err(Refusal::Clients);
            }
            let here = |known: &Visitor| known.address == visitor.address;
            if taken.count(here) >= self.limits.clients_of_address + more {
                return Err(Refusal::Address);
            }
        }
        taken.seated.push(visitor.clone());
        drop(taken);
        Ok(Place { places: Arc::clone(self), visitor })
    }

    fn free(&self, visitor: &Visitor, now: Instant) {
        let mut taken = self.taken();
        if let Some(seat) = taken.seated.iter().position(|seated| seated == visitor) {
            taken.seated.swap_remove(seat);
        }
        taken.kept.retain(|(_, until)| *until > now);
        if visitor.origin.is_some() && taken.kept.len() < self.limits.clients / KEPT_SHARE {
            taken.kept.push((visitor.clone(), now + self.limits.kept));
        }
    }
}

impl Taken {
    /// Number of places, taken or kept, of the visitors for which `fits` is true.
    fn count(&self, fits: impl Fn(&Visitor) -> bool) -> usize {
        let kept = self.kept.iter().map(|(visitor, _)| visitor);
        self.seated.iter().chain(kept).filter(|visitor| fits(visitor)).count()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.free(&self.visitor, now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visitor(last: u8, page: bool) -> Visitor {
        Visitor {
            address: IpAddr::V4(std::net::Ipv4Addr::new(127, 0, 0, last)),
            path: "/ws".to_owned(),
            origin: page.then(|| "http://localhost:8080".to_owned()),
            agent: page.then(|| "Browser".to_owned()),
        }
    }

    fn four() -> Arc<Places> {
        let limits = Limits { clients: 4, clients_of_address: 3, ..Limits::STANDARD };
        Arc::new(Places::new(limits))
    }

    #[test]
    fn the_place_of_a_page_is_kept_for_this_page_and_for_a_limited_time() {
        let places = four();
        let _programs: Vec<Place> =
            [1, 1, 2].map(|last| places.take(visitor(last, false)).unwrap()).into();
        let page = places.take(visitor(3, true)).unwrap();
        drop(page);
        assert_eq!(places.take(visitor(2, false)).err(), Some(Refusal::Clients));
        let page = places.take(visitor(3, true)).expect("its place is kept");
        drop(page);
        let later = now() + Limits::STANDARD.kept;
        assert!(places.take_at(visitor(2, false), later).is_ok());
    }

    #[test]
    fn the_place_of_a_program_is_free_at_once_and_one_address_has_its_own_limit() {
        let places = four();
        let mut programs: Vec<Place> =
            (0..3).map(|_| places.take(visitor(1, false)).unwrap()).collect();
        assert_eq!(places.take(visitor(1, false)).err(), Some(Refusal::Address));
        programs.pop();
        assert!(places.take(visitor(1, false)).is_ok());
        assert!(places.take(visitor(2, false)).is_ok());
    }

    #[test]
    fn a_page_that_is_open_gets_a_second_place_although_all_are_taken() {
        let places = four();
        let _programs: Vec<Place> =
            [1, 1, 2].map(|last| places.take(visitor(last, false)).unwrap()).into();
        let _old = places.take(visitor(3, true)).unwrap();
        let _new = places.take(visitor(3, true)).expect("the server has not noticed the break");
        for stranger in [visitor(3, false), visitor(4, true)] {
            assert_eq!(places.take(stranger).err(), Some(Refusal::Clients));
        }
        let most: Vec<_> =
            (0..2 * RESERVE).map_while(|_| places.take(visitor(3, true)).ok()).collect();
        assert_eq!(most.len(), RESERVE - 1);
    }

    #[test]
    fn pages_that_come_and_go_keep_only_a_part_of_the_places() {
        let places = four();
        for last in 1..50 {
            drop(places.take(visitor(last, true)).expect("a quarter is kept, the rest is free"));
        }
        assert_eq!(places.taken().kept.len(), 1);
    }
}
