//! The errors of a file of weights. Each message says what was found, what is allowed, and what to do.

/// Why weights are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WeightsError {
    /// The file ends too early.
    #[error(
        "the file is cut off, or it is no safetensors file: its {found_bytes} bytes do not match its header; copy it again"
    )]
    CutOff {
        /// Size of the file, bytes.
        found_bytes: usize,
    },
    /// The file is no safetensors file.
    #[error("no safetensors file: {reason}")]
    Container {
        /// Message of the reader.
        reason: String,
    },
    /// The file has no head.
    #[error(
        "the metadata has no key \"twin\"; only weights written by `twin train` say what they were trained on"
    )]
    NoHead,
    /// The head cannot be read.
    #[error("the head (metadata key \"twin\") is not readable: {reason}")]
    Head {
        /// The reason.
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
    /// The weights belong to another model.
    #[error("weights of the model {found:?}, expected {expected:?}")]
    Model {
        /// Model in the file.
        found: String,
        /// Expected model.
        expected: &'static str,
    },
    /// A size or flag of the model is wrong.
    #[error("config.{key} is {found}, expected {expected}")]
    Config {
        /// Key in the configuration.
        key: &'static str,
        /// The value that was found.
        found: String,
        /// The allowed values.
        expected: String,
    },
    /// A list of the head has the wrong length.
    #[error("{key} has {found} entries, expected {expected}")]
    Length {
        /// Key of the list.
        key: &'static str,
        /// Number of entries found.
        found: usize,
        /// Number of entries expected.
        expected: usize,
    },
    /// A number of the head is not allowed.
    #[error("{key}[{index}] is {found}, expected {expected}")]
    Number {
        /// Key of the list.
        key: &'static str,
        /// Index in the list.
        index: usize,
        /// The value that was found.
        found: f64,
        /// The allowed values.
        expected: &'static str,
    },
    /// The weights belong to another vehicle or to other inputs.
    #[error(
        "{key}[{index}] is {found:?}, this vehicle has {expected:?}: the weights belong to other channels, train on this vehicle"
    )]
    Channel {
        /// Key of the list.
        key: &'static str,
        /// Index in the list.
        index: usize,
        /// Name found.
        found: String,
        /// Name expected.
        expected: String,
    },
    /// The weights were trained with another nominal inertia, which is part of every residual.
    #[error(
        "the weights were trained with M̄ {row} = {found}, the controller has {expected}: M̄ is part of the residual; train with this M̄, or fly the preset they were trained with"
    )]
    Inertia {
        /// Name of the coordinate.
        row: &'static str,
        /// Nominal inertia in the head, kg or kg m².
        found: f64,
        /// Nominal inertia in the controller, kg or kg m².
        expected: f64,
    },
    /// The weights were trained at another rate.
    #[error(
        "the weights were trained at {found} Hz, the outer loop runs at {expected} Hz; set controller.outer_divisor, or train at this rate"
    )]
    Rate {
        /// Rate in the head, Hz.
        found: f64,
        /// Rate of the outer loop, Hz.
        expected: f64,
    },
    /// A tensor is missing.
    #[error("tensor {name:?} is missing, expected with shape {expected:?}")]
    Missing {
        /// Name of the tensor.
        name: String,
        /// Its expected shape.
        expected: Vec<usize>,
    },
    /// The file contains a tensor that the configuration does not have.
    #[error(
        "tensor {name:?} belongs to no part of the model that config describes; the file is of another model or version"
    )]
    Surplus {
        /// Name of the tensor.
        name: String,
    },
    /// A tensor has another shape.
    #[error("tensor {name:?} has shape {found:?}, config needs {expected:?}")]
    Shape {
        /// Name of the tensor.
        name: String,
        /// Shape that was found.
        found: Vec<usize>,
        /// Shape that was expected.
        expected: Vec<usize>,
    },
    /// A tensor has another type.
    #[error("tensor {name:?} has type {found}, expected F32")]
    Dtype {
        /// Name of the tensor.
        name: String,
        /// Type that was found.
        found: String,
    },
    /// A weight is not finite.
    #[error(
        "tensor {name:?} holds {found} at index {index}, expected finite values; the training diverged, train again"
    )]
    NonFinite {
        /// Name of the tensor.
        name: String,
        /// Index in the flat tensor.
        index: usize,
        /// The value that was found.
        found: f32,
    },
    /// The weights cannot be written.
    #[error("the weights cannot be written: {reason}")]
    Unwritable {
        /// The reason.
        reason: String,
    },
}
