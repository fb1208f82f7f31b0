//! Trained weights: the head of a file of weights, and its tensors.
//!
//! In: the bytes of a safetensors file with f32 tensors, whose metadata key `twin` contains the [`Head`] as JSON. Out:
//! [`Weights`] with finite numbers and a consistent head, or a [`WeightsError`]. No state, no I/O.

mod error;
mod head;
mod kind;
mod config;
pub(super) mod sizes;

use std::collections::{BTreeMap, HashMap};

use safetensors::{Dtype, SafeTensorError, SafeTensors, tensor::TensorView};

pub use config::FdtConfig;
pub use error::WeightsError;
pub use head::{Acceptance, FORMAT, Head, Normalisation, Training, channel_names, output_names};
pub use kind::ModelKind;

/// Key of the head in the metadata of the file.
pub const HEAD_KEY: &str = "twin";

/// The weights that are built into the program: an accepted file of [`FdtConfig::SMALL`], made by `twin collect && twin train &&
/// twin evaluate acceptance out/weights/fdt.safetensors`.
pub const SHIPPED: &[u8] = include_bytes!("weights/fdt_small.safetensors");

/// A tensor, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Tensor {
    /// Sizes, outermost first.
    pub shape: Vec<usize>,
    /// Values.
    pub values: Vec<f32>,
}

/// The content of a file of weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// The description of the weights.
    pub head: Head,
    /// Tensors by name.
    pub tensors: BTreeMap<String, Tensor>,
}

impl Weights {
    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// [`WeightsError`] if the file is cut off, is no safetensors file, has no head of [`FORMAT`], or contains a value that is
    /// not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, WeightsError> {
        let unusable = |error| unreadable(bytes.len(), &error);
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(unusable)?;
        let text = metadata.metadata().as_ref().and_then(|pairs| pairs.get(HEAD_KEY));
        let head: Head = serde_json::from_str(text.ok_or(WeightsError::NoHead)?)
            .map_err(|error| WeightsError::Head { reason: error.to_string() })?;
        head.check()?;
        let file = SafeTensors::deserialize(bytes).map_err(unusable)?;
        let mut tensors = BTreeMap::new();
        for (name, view) in file.iter() {
            tensors.insert(name.to_owned(), tensor(name, &view)?);
        }
        Ok(Self { head, tensors })
    }

    /// The bytes of the file; [`Weights::from_bytes`] reads them back to equal weights.
    ///
    /// # Errors
    /// [`WeightsError`] if a shape does not match its values.
    pub fn to_bytes(&self) -> Result<Vec<u8>, WeightsError> {
        let unwritable = |reason: String| WeightsError::Unwritable { reason };
        let head =
            serde_json::to_string(&self.head).map_err(|error| unwritable(error.to_string()))?;
        let bytes: BTreeMap<&str, Vec<u8>> = self
            .tensors
            .iter()
            .map(|(name, tensor)| {
                (
                    name.as_str(),
                    tensor.values.iter().flat_map(|value| value.to_le_bytes()).collect(),
                )
            })
            .collect();
        let views = self
            .tensors
            .iter()
            .map(|(name, tensor)| {
                let view = TensorView::new(Dtype::F32, tensor.shape.clone(), &bytes[name.as_str()])
                    .map_err(|error| unwritable(format!("{name}: {error}")))?;
                Ok((name, view))
            })
            .collect::<Result<Vec<_>, WeightsError>>()?;
        safetensors::serialize(views, Some(HashMap::from([(HEAD_KEY.to_owned(), head)])))
            .map_err(|error| unwritable(error.to_string()))
    }

    /// Checks that the file contains exactly the tensors `expected`.
    ///
    /// # Errors
    /// [`WeightsError`] that names the first tensor that is missing, superfluous or of another shape.
    pub fn check_tensors(&self, expected: &[(String, Vec<usize>)]) -> Result<(), WeightsError> {
        for (name, shape) in expected {
            let tensor = self.tensors.get(name).ok_or_else(|| WeightsError::Missing {
                name: name.clone(),
                expected: shape.clone(),
            })?;
            if tensor.shape != *shape {
                return Err(WeightsError::Shape {
                    name: name.clone(),
                    found: tensor.shape.clone(),
                    expected: shape.clone(),
                });
            }
        }
        let known = |name: &&String| expected.iter().any(|(wanted, _)| wanted == *name);
        match self.tensors.keys().find(|name| !known(name)) {
            Some(name) => Err(WeightsError::Surplus { name: name.clone() }),
            None => Ok(()),
        }
    }

    /// The values of tensor `name`; empty if it does not exist.
    pub(super) fn values(&self, name: &str) -> Vec<f32> {
        self.tensors.get(name).map_or_else(Vec::new, |tensor| tensor.values.clone())
    }
}

fn tensor(name: &str, view: &TensorView<'_>) -> Result<Tensor, WeightsError> {
    if view.dtype() != Dtype::F32 {
        return Err(WeightsError::Dtype { name: name.to_owned(), found: view.dtype().to_string() });
    }
    let values: Vec<f32> =
        view.data().as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four)).collect();
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => {
            Err(WeightsError::NonFinite { name: name.to_owned(), index, found: values[index] })
        }
        None => Ok(Tensor { shape: view.shape().to_vec(), values }),
    }
}

/// The error for an unreadable file: it is cut off if it is shorter than its header says.
fn unreadable(found_bytes: usize, error: &SafeTensorError) -> WeightsError {
    match error {
        SafeTensorError::HeaderTooSmall
        | SafeTensorError::InvalidHeaderLength
        | SafeTensorError::MetadataIncompleteBuffer => WeightsError::CutOff { found_bytes },
        other => WeightsError::Container { reason: other.to_string() },
    }
}
