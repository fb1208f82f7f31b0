//! Whole flights: the same seed twice, faults, missions, disturbances.

mod copied;
mod disturbances;
mod faults;
mod flown;
mod missions;
mod repeatable;
mod verdicts;
