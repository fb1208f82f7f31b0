//! What people watch and steer flights with: the console, the stock viewers, Foxglove, and pages of recorded flights.

pub mod server;
pub mod replay;
