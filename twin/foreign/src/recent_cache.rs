//! A cache of the values that were used last, by number. Each value is made once, also if several threads ask for it at the same
//! time.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

/// The values that were used last, by number.
#[derive(Debug)]
pub(super) struct RecentCache<T> {
    /// The last used value is last; an empty slot is a value that is being made.
    slots: Mutex<VecDeque<(usize, Arc<OnceLock<T>>)>>,
    most: usize,
}

impl<T: Clone> RecentCache<T> {
    /// A cache of at most `most` values; it keeps at least one.
    pub(super) fn new(most: usize) -> Self {
        Self { slots: Mutex::default(), most: most.max(1) }
    }

    /// The value of `number`: a cached value that is `good`, or else the result of `make`. Other threads that ask for it wait
    /// until it is made.
    pub(super) fn get(&self, number: usize, good: impl Fn(&T) -> bool, make: impl Fn() -> T) -> T {
        loop {
            let slot = self.slot(number, &good);
            let mut is_new = false;
            let value = slot.get_or_init(|| {
                is_new = true;
                make()
            });
            // A value that another thread made meanwhile may not be good enough. A new value is returned in any case, as there is
            // no better one.
            if is_new || good(value) {
                return value.clone();
            }
        }
    }

    fn slots(&self) -> MutexGuard<'_, VecDeque<(usize, Arc<OnceLock<T>>)>> {
        // No value is made under the lock, so a thread that panicked left the queue whole.
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn slot(&self, number: usize, good: impl Fn(&T) -> bool) -> Arc<OnceLock<T>> {
        let mut slots = self.slots();
        let at = slots.iter().rposition(|(known, _)| *known == number);
        let known = at.and_then(|at| slots.remove(at)).map(|(_, slot)| slot);
        let slot = known.filter(|slot| slot.get().is_none_or(good)).unwrap_or_default();
        slots.push_back((number, Arc::clone(&slot)));
        if slots.len() > self.most {
            slots.pop_front();
        }
        slot
    }

    /// Number of cached values.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.slots().len()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn a_value_is_made_once_however_many_ask_for_it_at_once() {
        const THREADS: usize = 8;
        let (kept, made) = (RecentCache::new(4), AtomicUsize::new(0));
        let together = Barrier::new(THREADS);
        std::thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    together.wait();
                    let value = kept.get(7, |_| true, || made.fetch_add(1, Ordering::Relaxed));
                    assert_eq!(value, 0);
                });
            }
        });
        assert_eq!(made.into_inner(), 1);
    }

    #[test]
    fn what_is_not_good_enough_is_made_anew_and_the_oldest_is_forgotten() {
        let kept = RecentCache::new(2);
        assert_eq!(kept.get(1, |_| true, || 5), 5);
        assert_eq!(kept.get(1, |value| *value >= 5, || 6), 5);
        assert_eq!(kept.get(1, |value| *value >= 6, || 6), 6);
        // The new value is not good enough either, but there is no better one.
        assert_eq!(kept.get(1, |value| *value >= 9, || 7), 7);
        assert_eq!(kept.len(), 1);
        kept.get(2, |_| true, || 0);
        kept.get(1, |_| true, || 0);
        kept.get(3, |_| true, || 0);
        assert_eq!(kept.len(), 2);
        assert_eq!(kept.get(1, |_| true, || 9), 7, "used after 2 was");
        assert_eq!(kept.get(2, |_| true, || 9), 9);
    }
}
