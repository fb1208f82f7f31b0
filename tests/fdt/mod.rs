//! The Factorized Dynamics Transformer: compared with an independent forward pass, read from a file, and in flight; and the
//! ridge regression that it must beat.

mod fast;
mod flying;
pub(crate) mod made;
mod oracle;
mod refusals;
mod ridge;
