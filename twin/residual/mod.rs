//! What predicts the residual `r`.

pub mod lra;
