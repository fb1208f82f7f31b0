//! Flights that others recorded: made files of every kind, damage of every kind, and the real ones where they are at hand.

mod damage;
mod fuzz;
mod fuzzed;
mod indexed;
mod live;
pub(crate) mod made;
mod misfits;
mod own_indexed;
mod program;
mod real;
pub(crate) mod round_trip;
mod transforms;
mod turned;
