//! Made-up waves of residual, rates and forces, for the tests of models that learn in flight.

use super::History;
use crate::elementary::{cos, sin};
use crate::notation::Coords;

/// A residual of a few newtons at tick `tick`: one wave for each coordinate.
pub(super) fn residual(tick: usize) -> Coords {
    Coords::from_fn(|row, _| 1.0 + cos(tick as f64 * (0.03 + 0.004 * row as f64)))
}

/// Appends tick `tick` to `history`; rates and forces are other waves than the residual.
pub(super) fn push(history: &mut History, tick: usize) {
    let t = tick as f64;
    let wave = |at: f64| Coords::from_fn(|row, _| sin(at * (0.05 + 0.01 * row as f64)));
    history.push(
        Coords::zeros(),
        wave(t + 9.0) * 0.3,
        residual(tick) + wave(t) * 0.5,
        residual(tick),
    );
}
