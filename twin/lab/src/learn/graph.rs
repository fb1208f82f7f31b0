//! Building blocks of the networks in burn, which records them for the gradient. Brackets give shapes, batch first.
//!
//! burn 0.22.1 deadlocks when two threads compute gradients in one process, so every computation with it takes [`exclusive`].

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use burn_tensor::activation::{gelu, softmax};
use burn_tensor::{Device, Gradients, Tensor, TensorData};

use super::LearnError;
use super::device::device;
use super::line::Line;
use super::parameters::Parameters;
use super::windows::Windows;

/// Epsilon that layer normalisation adds to the variance.
const LAYER_NORM_EPSILON: f64 = 1e-5;

static ONE_THREAD: Mutex<()> = Mutex::new(());

/// The lock of all computations with burn; dropping the guard releases it.
pub fn exclusive() -> MutexGuard<'static, ()> {
    ONE_THREAD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The parameters of a model as tensors, for one step of the optimiser.
pub struct Leaves {
    tensors: BTreeMap<String, (Tensor<1>, Vec<usize>)>,
    order: Vec<String>,
    device: Device,
}

impl Leaves {
    /// Copies `parameters` to the device. If `tracked`, burn records a gradient for each of them.
    pub fn new(parameters: &Parameters, tracked: bool) -> Self {
        let device = device(tracked);
        let leaf = |values: &[f32]| {
            let tensor: Tensor<1> = vector(values.to_vec(), &device);
            if tracked { tensor.require_grad() } else { tensor }
        };
        let all = parameters.0.iter();
        Self {
            tensors: all
                .clone()
                .map(|p| (p.name.clone(), (leaf(&p.values), p.shape.clone())))
                .collect(),
            order: all.map(|p| p.name.clone()).collect(),
            device,
        }
    }

    /// The device that holds the tensors.
    pub fn device(&self) -> Device {
        self.device.clone()
    }

    /// The same tensors, without gradients for those whose names start with `stem`.
    #[must_use]
    pub fn detached(&self, stem: &str) -> Self {
        let one = |(name, (leaf, shape)): (&String, &(Tensor<1>, Vec<usize>))| {
            let leaf = leaf.clone();
            let leaf = if name.starts_with(stem) { leaf.detach() } else { leaf };
            (name.clone(), (leaf, shape.clone()))
        };
        Self {
            tensors: self.tensors.iter().map(one).collect(),
            order: self.order.clone(),
            device: self.device.clone(),
        }
    }

    /// Gradients in the order of the parameters; the gradient is zero for a parameter that the loss does not use.
    pub fn gradients(&self, mut gradients: Gradients) -> Vec<Vec<f32>> {
        let of = |name: &String| {
            let (leaf, shape) = &self.tensors[name];
            let gradient = leaf.grad_remove(&mut gradients);
            gradient.map_or_else(|| vec![0.0; shape.iter().product()], values)
        };
        self.order.iter().map(of).collect()
    }

    /// Whether the model has a tensor called `name`.
    pub fn has(&self, name: &str) -> bool {
        self.tensors.contains_key(name)
    }

    /// The tensor called `name`, `[n]`.
    ///
    /// # Panics
    /// If the model has no such tensor.
    pub fn vector(&self, name: &str) -> Tensor<1> {
        let (leaf, _) = self.tensors.get(name).expect("a tensor that the model lists");
        leaf.clone()
    }

    /// The tensor called `name`, `[rows, columns]`.
    ///
    /// # Panics
    /// If the model has no such tensor, or its rank is not 2.
    pub fn matrix(&self, name: &str) -> Tensor<2> {
        let (leaf, shape) = self.tensors.get(name).expect("a tensor that the model lists");
        leaf.clone().reshape([shape[0], shape[1]])
    }

    /// `x W^T + b`: `[rows, inputs]` to `[rows, out]`. A layer without a bias has no `b`.
    pub fn linear(&self, stem: &str, x: Tensor<2>) -> Tensor<2> {
        let product = x.matmul(self.matrix(&format!("{stem}.weight")).transpose());
        let bias = format!("{stem}.bias");
        if self.has(&bias) { product + self.vector(&bias).unsqueeze::<2>() } else { product }
    }

    /// Layer normalisation of each row: `[rows, width]`.
    pub fn norm(&self, stem: &str, x: Tensor<2>) -> Tensor<2> {
        let centred = x.clone() - x.mean_dim(1);
        let variance = centred.clone().square().mean_dim(1);
        let unit = centred / (variance + LAYER_NORM_EPSILON).sqrt();
        unit * self.vector(&format!("{stem}.weight")).unsqueeze::<2>()
            + self.vector(&format!("{stem}.bias")).unsqueeze::<2>()
    }

    /// Layer normalisation followed by [`Leaves::attend`]: `[batch, n, d]`.
    pub fn attention(
        &self,
        [norm, qkv, out]: [&str; 3],
        heads: usize,
        tokens: Tensor<3>,
        mask: Option<Tensor<2>>,
    ) -> Tensor<3> {
        let [batch, n, d] = tokens.dims();
        let normed = self.norm(norm, tokens.reshape([batch * n, d])).reshape([batch, n, d]);
        self.attend([qkv, out], heads, normed, mask)
    }

    /// Self-attention over the tokens of each sequence, without the residual connection: `[batch, n, d]`. `mask`, `[n, n]`, is added
    /// to the scores.
    pub fn attend(
        &self,
        [qkv, out]: [&str; 2],
        heads: usize,
        tokens: Tensor<3>,
        mask: Option<Tensor<2>>,
    ) -> Tensor<3> {
        let [batch, n, d] = tokens.dims();
        let width = d / heads;
        let qkv: Tensor<5> = self
            .linear(qkv, tokens.reshape([batch * n, d]))
            .reshape([batch, n, 3, heads, width])
            .permute([2, 0, 3, 1, 4]);
        let part = |index: usize| -> Tensor<4> {
            qkv.clone().narrow(0, index, 1).reshape([batch, heads, n, width])
        };
        let scores = part(0).matmul(part(1).swap_dims(2, 3)) / (width as f32).sqrt();
        let scores = match mask {
            Some(mask) => scores + mask.reshape([1, 1, n, n]),
            None => scores,
        };
        let mixed = softmax(scores, 3).matmul(part(2)).permute([0, 2, 1, 3]);
        self.linear(out, mixed.reshape([batch * n, d])).reshape([batch, n, d])
    }

    /// `W_2 GELU(W_1 x + b_1) + b_2`: `[rows, inputs]` to `[rows, out]`.
    pub fn mlp(&self, [hidden, out]: [&str; 2], x: Tensor<2>) -> Tensor<2> {
        self.linear(out, gelu(self.linear(hidden, x)))
    }
}

/// Copies values to the device: `[n]`.
pub fn vector(values: Vec<f32>, device: &Device) -> Tensor<1> {
    let length = values.len();
    Tensor::from_data(TensorData::new(values, [length]), device)
}

/// The values of a tensor, row-major.
///
/// # Panics
/// If the device fails, or the tensor does not hold `f32`; neither happens on the processor.
pub fn values<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    tensor.into_data().try_to_vec::<f32>().expect("a tensor of f32")
}

/// The output of a network for a batch.
pub struct Output {
    /// z-scored forecasts, `[batch, horizon + 1, outputs]`.
    pub forecast: Tensor<3>,
    /// Regime latent before its scale, `[batch, d_k]`. It is the input of an adaptive last layer.
    pub regime: Tensor<2>,
}

/// A batch on the device.
pub struct Inputs {
    /// `[batch, channels, t_long]`.
    pub x: Tensor<3>,
    /// `[batch, horizon + 1, outputs]`.
    pub y: Tensor<3>,
    /// Flight of each window.
    pub flights: Vec<usize>,
    /// Progress of the training, 0 to 1.
    pub progress: f64,
}

/// A model that can be trained.
pub trait Network {
    /// Sizes of the model, for the head of the file.
    fn config(&self) -> serde_json::Value;

    /// Name and shape of every tensor of the file.
    fn tensors(&self) -> Vec<(String, Vec<usize>)>;

    /// Tensors that only the training needs, which are not written.
    fn helpers(&self) -> Vec<(String, Vec<usize>)> {
        Vec::new()
    }

    /// The forecast and the regime of a batch `[batch, channels, t_long]`.
    fn forward(&self, leaves: &Leaves, x: Tensor<3>) -> Output;

    /// The loss of a batch, `[1]`: by default the mean squared error over the whole horizon and all outputs.
    fn loss(&self, leaves: &Leaves, inputs: Inputs) -> Tensor<1> {
        mean_square(self.forward(leaves, inputs.x).forecast - inputs.y)
    }

    /// Sets the tensors that have a solution in closed form before the first step, and returns that solution; `None` if the model has
    /// none.
    ///
    /// # Errors
    /// [`LearnError::Unsolvable`] if the solution does not exist.
    fn solve(
        &self,
        _windows: &Windows,
        _parameters: &mut Parameters,
    ) -> Result<Option<Line>, LearnError> {
        Ok(None)
    }

    /// Whether gradient descent follows; if not, [`Network::solve`] sets every tensor.
    fn descends(&self) -> bool {
        true
    }

    /// Projects `parameters` onto the set that the model allows; called after every step.
    fn constrain(&self, _parameters: &mut Parameters) {}
}

/// The mean of the squares, `[1]`.
pub fn mean_square(error: Tensor<3>) -> Tensor<1> {
    error.square().mean()
}
