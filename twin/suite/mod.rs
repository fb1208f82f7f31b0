//! Scenarios as tests: which flights to make, making them side by side, and what is handed to people and to a CI.
//!
//! In: files, folders and patterns. Out: a [`SuiteReport`] with a [`CaseResult`] per flight in the order of the cases, whatever
//! the number of threads or shards; `JUnit` XML; a page; of each flight that failed its recording and a page, which the caller
//! makes. Also the comparison of two recordings.

mod case;
pub mod diff;
pub mod junit;
mod merge;
mod message;
pub mod page;
mod picture;
mod record;
mod report;
mod run;
pub mod share;
mod sweep;

pub use case::{Case, Plan, Sample, Selection, SelectionError, Shard, plan};
pub use merge::{MergeError, merge};
pub use report::{Successes, SuiteReport};
pub use run::{CaseResult, Evidence, MakePage, Options, Outcome, run};
pub use sweep::{SweepPlan, SweepReport};
