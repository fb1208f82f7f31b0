//! A flight as its file gives it, before unknown channels are left out.

use std::path::PathBuf;

/// A flight with all channels; an unknown channel is `None`.
pub(super) struct Raw {
    pub(super) path: PathBuf,
    /// Input channels in the order stems × coordinates.
    pub(super) inputs: Vec<Option<Vec<f64>>>,
    pub(super) outputs: Vec<Option<Vec<f64>>>,
    pub(super) usable: Vec<bool>,
    pub(super) nominal_inertia: Vec<f64>,
}
