//! Root mean square, added up tick by tick.

/// Root of a mean of squares.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rms {
    /// Sum of the squares.
    pub(super) sum: f64,
    /// Number of squares.
    pub(super) count: f64,
}

impl Rms {
    /// Adds a square.
    pub(super) fn add(&mut self, squared: f64) {
        self.sum += squared;
        self.count += 1.0;
    }

    /// The root; `None` without a square.
    pub(super) fn value(&self) -> Option<f64> {
        (self.count > 0.0).then(|| (self.sum / self.count).sqrt())
    }
}
