//! Runs work in parallel threads and returns the results in the order of the work.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

/// Applies `work` to every item on `threads` threads. The results have the order of the items, whatever the number of threads.
pub fn side_by_side<T: Sync, R: Send>(
    items: &[T],
    threads: usize,
    work: &(dyn Fn(&T) -> R + Sync),
) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, items.len().max(1)) {
            let sender = sender.clone();
            let next = &next;
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { return };
                    if sender.send((index, work(item))).is_err() {
                        return;
                    }
                }
            });
        }
    });
    drop(sender);
    let mut results: Vec<(usize, R)> = receiver.into_iter().collect();
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_work() {
        let items: Vec<u64> = (0..50).collect();
        let wanted: Vec<u64> = items.iter().map(|n| n * n).collect();
        for threads in [0, 1, 3, 100] {
            let slow_first = |n: &u64| {
                std::thread::sleep(std::time::Duration::from_micros(50 - n));
                n * n
            };
            assert_eq!(side_by_side(&items, threads, &slow_first), wanted);
        }
        assert!(side_by_side(&[] as &[u64], 2, &|n| *n).is_empty());
    }
}
