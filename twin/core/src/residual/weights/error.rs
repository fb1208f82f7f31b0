//! What is wrong with a file of weights. One sentence each: what was found, what is allowed, what to do.

/// Why weights are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WeightsError {
    /// The file ends too early.
    #[error(
        "the file is cut off or no safetensors file: its {found_bytes} bytes are not what its header promises; copy it again"
    )]
    CutOff {
        /// Size of the file.
        found_bytes: usize,
    },
    /// The file is no safetensors file.
    #[error("no safetensors file: {reason}")]
    Container {
        /// The reader's words.
        reason: String,
    },
    /// The file says nothing about itself.
    #[error(
        "the metadata has no key \"twin\"; only weights written by `twin train` say what they were trained on"
    )]
    NoHead,
    /// The head is not what it must be.
    #[error("the head (metadata key \"twin\") is not readable: {reason}")]
    Head {
        /// What is wrong.
        reason: String,
    },
    /// The head has another format.
    #[error(
        "head format {found}, this program reads {expected}; train again, or use the program that wrote it"
    )]
    Format {
        /// Number in the file.
        found: u32,
        /// Number this program knows.
        expected: u32,
    },
    /// Weights of another model.
    #[error("weights of the model {found:?}, expected {expected:?}")]
    Model {
        /// Model in the file.
        found: String,
        /// Model asked for.
        expected: &'static str,
    },
    /// A size or flag of the model.
    #[error("config.{key} is {found}, expected {expected}")]
    Config {
        /// Key.
        key: &'static str,
        /// What was found.
        found: String,
        /// What is allowed.
        expected: String,
    },
    /// A list of the head has another length.
    #[error("{key} has {found} entries, expected {expected}")]
    Length {
        /// Key.
        key: &'static str,
        /// Entries found.
        found: usize,
        /// Entries expected.
        expected: usize,
    },
    /// A number of the head.
    #[error("{key}[{index}] is {found}, expected {expected}")]
    Number {
        /// Key.
        key: &'static str,
        /// Place in the list.
        index: usize,
        /// What was found.
        found: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// Weights of another vehicle or of other inputs.
    #[error(
        "{key}[{index}] is {found:?}, this vehicle has {expected:?}: the weights belong to other channels, train on this vehicle"
    )]
    Channel {
        /// Key.
        key: &'static str,
        /// Place in the list.
        index: usize,
        /// Name found.
        found: String,
        /// Name expected.
        expected: String,
    },
    /// Another nominal inertia is part of every residual these weights were trained on.
    #[error(
        "the weights were trained with M̄ {row} = {found}, the controller has {expected}: M̄ is part of the residual; train with this M̄, or fly the preset they were trained with"
    )]
    Inertia {
        /// Row.
        row: &'static str,
        /// In the head.
        found: f64,
        /// In the controller.
        expected: f64,
    },
    /// The history has another period.
    #[error(
        "the weights were trained at {found} Hz, the outer loop runs at {expected} Hz; set controller.outer_divisor, or train at this rate"
    )]
    Rate {
        /// In the head, Hz.
        found: f64,
        /// Of the loop, Hz.
        expected: f64,
    },
    /// A tensor is not there.
    #[error("tensor {name:?} is missing, expected with shape {expected:?}")]
    Missing {
        /// Tensor.
        name: String,
        /// Its shape.
        expected: Vec<usize>,
    },
    /// A tensor the configuration does not know.
    #[error(
        "tensor {name:?} belongs to no part of the model that config describes; the file is of another model or version"
    )]
    Surplus {
        /// Tensor.
        name: String,
    },
    /// A tensor of another shape.
    #[error("tensor {name:?} has shape {found:?}, config needs {expected:?}")]
    Shape {
        /// Tensor.
        name: String,
        /// Found.
        found: Vec<usize>,
        /// Expected.
        expected: Vec<usize>,
    },
    /// A tensor of another type.
    #[error("tensor {name:?} has type {found}, expected F32")]
    Dtype {
        /// Tensor.
        name: String,
        /// Found.
        found: String,
    },
    /// A weight that is not a number.
    #[error(
        "tensor {name:?} holds {found} at index {index}, expected finite values; the training diverged, train again"
    )]
    NonFinite {
        /// Tensor.
        name: String,
        /// Place in the flat tensor.
        index: usize,
        /// Value.
        found: f32,
    },
    /// Cannot be written.
    #[error("the weights cannot be written: {reason}")]
    Unwritable {
        /// What is wrong.
        reason: String,
    },
}
