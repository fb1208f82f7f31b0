//! One budget for everything that is read from users: scenarios, vehicles, meshes, weights, maps, recordings and live streams.
//!
//! [`budget`] holds every limit. [`file`](mod@file) opens regular files only, and reads them up to a limit. [`Reader`] reads a long
//! file piece by piece and asks for a request to [`Stop`] before each piece; [`interruption`] is the signal that makes it.
//! [`Inflation`] bounds what compressed bytes may become. [`Lines`] finds the line of an offset without reading the text again. [`work`]
//! counts the steps of loops over such input, so that tests can compare the work of two sizes.

mod limit;
pub mod budget;
pub mod interruption;
mod stop;
pub mod file;
mod reader;
mod inflation;
mod lines;
pub mod work;

pub use file::InputError;
pub use inflation::{Inflation, TooInflated};
pub use limit::{Excess, Limit};
pub use lines::Lines;
pub use reader::{Asking, Reader};
pub use stop::{Stop, is_stop};
