//! Flights that other programs recorded: made files of every kind, damaged files, and real files if they are available.

mod cases;
mod damage;
mod fuzz;
mod fuzzed;
mod indexed;
mod live;
pub(crate) mod made;
mod misfits;
mod oracles;
mod own_indexed;
mod program;
mod real;
pub(crate) mod round_trip;
mod transforms;
mod turned;
