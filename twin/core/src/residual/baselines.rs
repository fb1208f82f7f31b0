//! Predictors of the paper's comparison that need no network: each one file with its source at its head.
//!
//! They see the newest entry of the history, z-scored, masked channels left out, and forecast `j = 0..=k` at once.

pub mod sindy;
pub mod gp;

use crate::notation::{Coords, N};
use crate::residual::weights::{Head, WeightsError};
use crate::residual::{HORIZON, History};
use crate::tick::Forecast;

pub use gp::Gp;
pub use sindy::Sindy;

/// Values forecast: eight rows at seven horizons.
pub const TARGETS: usize = N * (HORIZON + 1);

/// Turns a history into z-scored inputs, and z-scored outputs into forces.
#[derive(Clone, Debug)]
pub struct Standard {
    /// Index of each input among `chi`, `chi_dot`, `tau_{t-1}`, its mean and standard deviation.
    inputs: Vec<(usize, f64, f64)>,
    mean: Coords,
    std: Coords,
}

impl Standard {
    /// As `head` says.
    ///
    /// # Errors
    /// [`WeightsError`] for the head of another vehicle.
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

    /// There is none.
    pub fn is_empty(&self) -> bool {
        self.inputs.is_empty()
    }

    /// z-scores of one tick's `chi`, `chi_dot`, `tau_{t-1}`.
    pub fn z(&self, parts: [&Coords; 3]) -> Vec<f64> {
        self.inputs.iter().map(|(i, mean, std)| (parts[i / N][i % N] - mean) / std).collect()
    }

    /// The same of the newest entry; zeros before there is one.
    fn newest(&self, history: &History) -> Vec<f64> {
        history.newest().map_or_else(
            || vec![0.0; self.inputs.len()],
            |entry| self.z([&entry.chi, &entry.chi_dot, &entry.tau_previous]),
        )
    }

    /// Forecast of z-scored targets, row by row within each horizon; there is no regime to adapt on.
    fn forecast(&self, targets: &[f64]) -> Forecast {
        let force = |z: &[f64]| Coords::from_column_slice(z).component_mul(&self.std) + self.mean;
        Forecast {
            base: targets.chunks_exact(N).map(force).map(Into::into).collect(),
            regime: Vec::new(),
            attention: Vec::new(),
        }
    }
}
