//! The interfaces with which people watch and steer flights: the console, the stock viewers, Foxglove, and pages of recorded
//! flights.

pub mod server;
pub mod replay;
