//! What predicts beside a recorded flight: an autoregression that learns in flight, or trained weights.

use std::sync::Arc;

use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::weights::{Weights, WeightsError};
use twin_core::residual::{ArxRows, Predictor, trained};

/// The predictor of a shadow.
#[derive(Clone, Debug, Default)]
pub struct Forecaster {
    /// Weights and the name of their file; `None` for the autoregression.
    trained: Option<(Arc<Weights>, String)>,
}

impl Forecaster {
    /// The network of `weights`, which came from the file `name`.
    ///
    /// # Errors
    /// [`WeightsError`] if they belong to an unknown model, or a tensor is wrong.
    pub fn trained(weights: Weights, name: String) -> Result<Self, WeightsError> {
        network(&weights)?;
        Ok(Self { trained: Some((Arc::new(weights), name)) })
    }

    /// Name of the predictor for people, and what it knows about the vehicle.
    pub fn sentence(&self) -> String {
        match &self.trained {
            None => "arx_rows: an autoregression of each coordinate, learned in flight; not trained on this or any vehicle".to_owned(),
            Some((weights, name)) => format!(
                "{} from {name}, adapted in flight; it serves this vehicle only if it was trained on its flights",
                weights.head.model
            ),
        }
    }

    /// A predictor before its first tick.
    pub(super) fn predictor(&self) -> Box<dyn Predictor> {
        // `trained` built the same network before, so it cannot fail here.
        let network = self.trained.as_ref().and_then(|(weights, _)| network(weights).ok());
        network.unwrap_or_else(|| Box::new(ArxRows::default()))
    }
}

/// The network in the arithmetic that has the same bits on every processor.
fn network(weights: &Weights) -> Result<Box<dyn Predictor>, WeightsError> {
    Ok(trained::predictor(weights, Kernel::SCALAR, Precision::F32)?.predictor)
}
