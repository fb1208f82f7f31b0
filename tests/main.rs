//! The one test binary.

mod bad_input;
mod circles;
mod draws;
mod endings;
mod fdt;
mod flight;
mod folder;
mod forks;
mod harness;
mod layers;
mod mirror;
mod outputs;
mod patience;
mod plant;
mod reading;
mod residual;
mod scenarios;
mod server;
mod untrusted;
