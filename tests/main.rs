//! The one test binary.

mod flight;
mod plant;
mod server;
