//! One TOML file, one flight, one verdict.

mod document;
pub mod file;
mod limits;
mod merge;

pub use file::ScenarioError;
