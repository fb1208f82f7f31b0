//! Counts the steps of loops over untrusted input, per thread. Tests compare the steps of two sizes: work that grows with the square
//! of the size shows there on any machine, however fast it is.

use std::cell::Cell;

thread_local! {
    static STEPS: Cell<u64> = const { Cell::new(0) };
}

/// Counts `count` steps.
pub fn steps(count: usize) {
    STEPS.with(|steps| steps.set(steps.get().wrapping_add(count as u64)));
}

/// The steps that `work` counts in this thread, and its result.
pub fn counted<R>(work: impl FnOnce() -> R) -> (u64, R) {
    let before = STEPS.with(Cell::get);
    let result = work();
    (STEPS.with(Cell::get).wrapping_sub(before), result)
}

/// How many times as many steps `work` takes at size `4 n` as at size `n`: about 4 if the work is linear, and 16 if it is quadratic.
pub fn growth(n: usize, work: &mut dyn FnMut(usize)) -> f64 {
    let (small, ()) = counted(|| work(n));
    let (large, ()) = counted(|| work(4 * n));
    large as f64 / small.max(1) as f64
}

/// Growth that work linear in its size, apart from a logarithm, stays below; see [`growth`].
pub const LINEAR: f64 = 5.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_and_quadratic_work_are_told_apart() {
        let mut linear = |n| (0..n).for_each(|_| steps(1));
        let mut quadratic = |n| (0..n).for_each(|_| steps(n));
        assert!(growth(100, &mut linear) < LINEAR);
        assert!(growth(100, &mut quadratic) > LINEAR);
    }
}
