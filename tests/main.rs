//! The one test binary.

mod bad_input;
mod fdt;
mod flight;
mod harness;
mod layers;
mod mirror;
mod patience;
mod plant;
mod scenarios;
mod server;
