//! The Factorized Dynamics Transformer: against an independent forward pass, as a file, and in flight.

mod fast;
mod flying;
pub(crate) mod made;
mod oracle;
mod refusals;
