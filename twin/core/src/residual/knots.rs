//! The steps of a horizon that an online model learns, and the line between them.

use std::ops::{Add, Mul};

use super::HORIZON;

/// Steps `j` that are learned. An iterated one-step model has the same errors within 3 %, and nothing keeps it bounded.
pub const KNOTS: [usize; 6] = [0, 3, 6, 10, 16, HORIZON];

/// The value at step `j` on the line between the values at the `knots` around it, one for each of [`KNOTS`].
pub(super) fn between<T>(knots: &[T], j: usize) -> T
where
    T: Copy + Mul<f64, Output = T> + Add<Output = T>,
{
    let after = KNOTS.iter().position(|knot| *knot >= j).unwrap_or(KNOTS.len() - 1);
    let before = after.saturating_sub(1);
    let width = (KNOTS[after] - KNOTS[before]).max(1) as f64;
    let share = KNOTS[after].saturating_sub(j) as f64 / width;
    knots[after] * (1.0 - share) + knots[before] * share
}
