//! Factorized Dynamics Transformer (sec. Offline Residual Dynamics Learning, trained by `eq:training_loss`): forecasts the
//! residual of `eq:residual_dynamics` from the histories of coordinates, rates and force.
//!
//! In: [`History`]. Out: base forecast in N and N m for `j = 0..=k`, the regime `g'` that the adapter of `lip` corrects on, and
//! the attention over the channels. State: the weights, never changed in flight.
//!
//! How the paper is read where its text leaves a choice:
//! - **Inputs** (sec. Variable-Wise Temporal Embedding): `x_t` holds the force of the previous tick, `tau_{t-1}`; the present one is not
//!   known when `r_t` is forecast. Windows are exactly `T_s` and `T_l` ticks and end now. Histories and residuals are z-scored by the
//!   training data, because the sum of `eq:training_loss` would otherwise add N to N m. `x`, `y` and `psi` are masked: the place and
//!   heading of the vehicle do not determine the force on it.
//! - **Layers** (sec. Short-Horizon Context Encoding): the one equation of the encoder, `E~ = MSA([E; g]) + [E; g]`, occurs `layers` times,
//!   without a feed-forward network of its own. Layer normalisation, which the text does not name, precedes the attention, `W_Q` and the
//!   decoder's FFN. One learned global token passes through all layers.
//! - **Memory** (sec. Long-Horizon Memory Retrieval): the shared MLP is `T_l -> d -> d` with GELU (exact error function). Its output
//!   includes the channel's identity, because the attention could not tell the channels apart otherwise. One head of width `d_k`; nothing
//!   is added to `g'`, which is the adapter's regressor.
//! - **Encoder output** (sec. Residual Prediction): `[E~; lift g']`, the tokens after the attention, and `g'` through a learned
//!   map to their width. The adapter sees `g'` itself, times `regime_scale`.
//! - **Decoder**: the FFN with its own residual sum, then an MLP on the mean of the channels' outputs beside the last token's. So its size
//!   does not depend on the number of tokens.
//! - **Skip**: the paper's equations have no linear path from the histories to the forecasts. A network may have one beside them, from
//!   the last `t_skip` ticks of all channels to every `j`, added to the output of the decoder. Its training starts at the ridge regression
//!   on these ticks, with a decoder that says zero, so attention learns only what a line cannot. A file without `t_skip` has none.
//! - **Correction** (`r_adapt`): the adapter corrects `j = 0`; the same correction is added to every `j`.

mod model;
mod fold;
mod fast;

use super::nn::Precision;
use super::nn::kernels::Kernel;
use super::scaling::Scaling;
use super::weights::{Weights, WeightsError};
use super::{History, Predictor, PredictorInfo};
use crate::tick::Forecast;

pub use fast::Fast;
pub use model::{Model, Output};

/// The network with the statistics of its training data.
#[derive(Clone)]
pub struct Fdt {
    network: Fast,
    scaling: Scaling,
    x: Vec<f32>,
    attends: Vec<String>,
}

impl Fdt {
    /// The predictor of `weights`, computed by `kernel`.
    ///
    /// # Errors
    /// [`WeightsError`] if they belong to another model or vehicle, or if a tensor is missing or has a wrong shape.
    pub fn new(
        weights: &Weights,
        kernel: Kernel,
        precision: Precision,
    ) -> Result<Self, WeightsError> {
        let model = Model::new(weights)?;
        Ok(Self {
            x: vec![0.0; model.config.channels * model.config.t_long],
            scaling: Scaling::new(&weights.head)?,
            attends: if model.config.long_memory {
                weights.head.channel_names.clone()
            } else {
                Vec::new()
            },
            network: Fast::new(&model, kernel, precision),
        })
    }
}

impl Predictor for Fdt {
    fn regime_len(&self) -> usize {
        self.network.config().d_k
    }

    fn history_len(&self) -> usize {
        self.network.config().t_long
    }

    fn info(&self) -> PredictorInfo {
        PredictorInfo {
            scale: self.scaling.std,
            horizon: self.network.config().horizon,
            attends: self.attends.clone(),
            kernel: self.network.arithmetic(),
        }
    }

    fn predict(&mut self, history: &History) -> Forecast {
        self.scaling.window(history, self.history_len(), &mut self.x);
        let Output { residual, regime, attention } = self.network.forward(&self.x);
        self.scaling.forecast(&residual, &regime, &attention)
    }
}
