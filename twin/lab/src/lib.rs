//! Training and comparison of predictors: learning from recordings, and the tables of the paper.

mod ridge;
pub mod learn;
pub mod evaluate;
pub mod compare;
