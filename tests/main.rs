//! The one test binary.
#![allow(clippy::unwrap_used, reason = "tests fail by panicking, in their helpers too")]

mod cli;
mod flight;
mod layers;
mod plant;
mod server;
