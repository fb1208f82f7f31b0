//! Predictors of the paper's comparison that need no network, one file each, with its source at the head of the file.
//!
//! They read the newest entry of the history, z-scored and without masked channels, and forecast `j = 0..=k` at once.

pub mod sindy;
pub mod gp;

use crate::notation::{Coords, N};
use crate::residual::weights::{Head, WeightsError};
use crate::residual::{HORIZON, History};
use crate::tick::Forecast;

pub use gp::Gp;
pub use sindy::Sindy;

/// Number of forecast values: every coordinate at every step of the horizon.
pub const TARGETS: usize = N * (HORIZON + 1);

/// Turns a history into z-scored inputs, and z-scored outputs into forces.
#[derive(Clone, Debug)]
pub struct Standard {
    /// Each input: its index among `chi`, `chi_dot`, `tau_{t-1}`, its mean and its standard deviation.
    inputs: Vec<(usize, f64, f64)>,
    mean: Coords,
    std: Coords,
}

impl Standard {
    /// The statistics of `head`.
    ///
    /// # Errors
    /// [`WeightsError`] if `head` belongs to another vehicle.
    pub fn new(head: &Head) -> Result<Self, WeightsError> {
        head.check_channels()?;
        let n = &head.normalisation;
        let inputs = head
            .channel_names
            .iter()
            .enumerate()
            .filter(|(_, name)| !n.masked.contains(name))
            .map(|(i, _)| (i, n.input_mean[i], n.input_std[i]))
            .collect();
        Ok(Self {
            inputs,
            mean: Coords::from_column_slice(&n.output_mean),
            std: Coords::from_column_slice(&n.output_std),
        })
    }

    /// Number of inputs.
    pub fn len(&self) -> usize {
        self.inputs.len()
    }

    /// True if there is no input.
    pub fn is_empty(&self) -> bool {
        self.inputs.is_empty()
    }

    /// z-scores of `chi`, `chi_dot`, `tau_{t-1}` of one tick.
    pub fn z(&self, parts: [&Coords; 3]) -> Vec<f64> {
        self.inputs.iter().map(|(i, mean, std)| (parts[i / N][i % N] - mean) / std).collect()
    }

    /// z-scores of the newest entry; zeros while the history is empty.
    fn newest(&self, history: &History) -> Vec<f64> {
        history.newest().map_or_else(
            || vec![0.0; self.inputs.len()],
            |entry| self.z([&entry.chi, &entry.chi_dot, &entry.tau_previous]),
        )
    }

    /// Forecast from z-scored targets, all coordinates of one horizon after the other. Its regime is empty, so the adapter learns nothing.
    fn forecast(&self, targets: &[f64]) -> Forecast {
        let force = |z: &[f64]| Coords::from_column_slice(z).component_mul(&self.std) + self.mean;
        Forecast {
            base: targets.chunks_exact(N).map(force).map(Into::into).collect(),
            regime: Vec::new(),
            attention: Vec::new(),
        }
    }
}
