//! Training and comparison of predictors: learning from recordings, and the tables of the paper.

pub mod learn;
pub mod evaluate;
