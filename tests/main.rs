//! The one test binary.

mod bad_input;
mod flight;
mod layers;
mod plant;
mod scenarios;
mod server;
