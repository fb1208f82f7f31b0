//! Learning the residual: recordings → series → windows → a trained model in one `safetensors` file.
//!
//! Reading, splitting, normalising and writing need nothing but this crate; the models and their gradients are in burn, behind
//! the Cargo feature `train`. What flies is never burn: `residual` runs the written file with its own forward pass.

pub mod adam;
pub mod checkpoint;
pub mod config;
pub mod curve;
pub mod dataset;
mod error;
pub mod file;
pub mod foreign;
pub mod parameters;
mod raw;
pub mod regime;
pub mod windows;

#[cfg(feature = "train")]
pub mod baselines;
#[cfg(feature = "train")]
pub mod device;
#[cfg(feature = "train")]
pub mod fdt;
#[cfg(feature = "train")]
pub mod graph;
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
