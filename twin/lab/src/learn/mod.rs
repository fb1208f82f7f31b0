//! Learning the residual: recordings → series → windows → a trained model in one `safetensors` file.
//!
//! Reading, splitting, normalising and writing need no crate for learning. The models and their gradients use burn, behind the Cargo
//! feature `train`. A flight never uses burn: `residual` runs the written file with its own forward pass.

mod error;
pub mod config;
mod raw;
pub mod foreign;
pub mod dataset;
pub mod windows;
pub mod parameters;
pub mod line;
pub mod adam;
pub mod file;
pub mod checkpoint;
pub mod curve;
pub mod regime;

#[cfg(feature = "train")]
pub mod device;
#[cfg(feature = "train")]
pub mod graph;
#[cfg(feature = "train")]
pub mod fdt;
#[cfg(feature = "train")]
pub mod baselines;
#[cfg(feature = "train")]
pub mod train;

#[cfg(test)]
mod dataset_tests;
#[cfg(test)]
mod made;
#[cfg(all(test, feature = "train"))]
mod train_tests;
#[cfg(test)]
mod windows_tests;

pub use config::TrainConfig;
pub use dataset::Dataset;
pub use error::LearnError;
pub use windows::Windows;
