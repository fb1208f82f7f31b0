//! The one test binary.
#![allow(clippy::unwrap_used, reason = "tests fail by panicking, in their helpers too")]

mod bad_input;
mod cli;
mod flight;
mod layers;
mod plant;
mod scenarios;
mod server;
