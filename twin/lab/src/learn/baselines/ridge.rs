//! Ridge regression on the last ticks, solved in closed form. `residual::learned::ridge` has its source and the form that flies.

use burn_tensor::Tensor;

use super::{head, readout};
use crate::learn::LearnError;
use crate::learn::graph::{Leaves, Network, Output};
use crate::learn::line::Line;
use crate::learn::parameters::Parameters;
use crate::learn::windows::Windows;
use twin_core::residual::learned::{Sizes, ridge};

/// The linear map.
pub(super) struct Ridge {
    pub(super) sizes: Sizes,
}

impl Network for Ridge {
    fn config(&self) -> serde_json::Value {
        head(&self.sizes)
    }

    fn tensors(&self) -> Vec<(String, Vec<usize>)> {
        ridge::tensors(&self.sizes)
    }

    fn forward(&self, w: &Leaves, x: Tensor<3>) -> Output {
        let [batch, channels, t] = x.dims();
        let regime = Tensor::zeros([batch, 0], &w.device());
        Output { forecast: readout(w, &self.sizes, x.reshape([batch, channels * t])), regime }
    }

    fn solve(
        &self,
        windows: &Windows,
        parameters: &mut Parameters,
    ) -> Result<Option<Line>, LearnError> {
        let line = Line::of(windows, self.sizes.t_long)?;
        line.write(parameters, "readout");
        Ok(Some(line))
    }

    fn descends(&self) -> bool {
        false
    }
}
