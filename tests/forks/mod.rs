//! Forks of flights.

mod library;
