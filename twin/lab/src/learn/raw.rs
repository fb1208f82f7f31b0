//! One flight as it was read, before what its file does not know is left out.

use std::path::PathBuf;

/// A flight with all channels, unknown ones absent.
pub(super) struct Raw {
    pub(super) path: PathBuf,
    /// Per channel in the order of the dataset's stems × rows.
    pub(super) inputs: Vec<Option<Vec<f64>>>,
    pub(super) outputs: Vec<Option<Vec<f64>>>,
    pub(super) usable: Vec<bool>,
    pub(super) nominal_inertia: Vec<f64>,
}
