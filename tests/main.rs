//! The one test binary.

mod plant;
mod server;
