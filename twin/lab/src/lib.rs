//! Where predictors are trained and compared: learning from recordings, and the tables of the paper.

pub mod learn;
pub mod evaluate;
