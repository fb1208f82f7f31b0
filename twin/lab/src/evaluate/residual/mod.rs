//! What the residual consists of, and whether a long window foresees it better.

pub mod bands;
