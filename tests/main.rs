//! The one test binary.

mod bad_input;
mod circles;
mod fdt;
mod flight;
mod harness;
mod layers;
mod mirror;
mod patience;
mod plant;
mod reading;
mod scenarios;
mod server;
mod untrusted;
