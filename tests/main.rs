//! The one test binary.

mod server;
