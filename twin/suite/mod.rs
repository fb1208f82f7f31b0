//! Scenarios as tests: which flights to make, making them side by side, and what is handed to people and to a CI.
//!
//! In: files, folders and patterns. Out: a [`SuiteReport`] with a [`CaseResult`] per flight in the order of the cases, whatever
//! the number of threads or shards; `JUnit` XML; a page; recording and replay of what failed. Also the comparison of two
//! recordings.

mod case;
pub mod diff;
pub mod junit;
mod merge;
mod message;
pub mod page;
mod picture;
mod plan;
mod record;
mod report;
mod result;
mod run;
pub mod share;
mod sweep;

pub use case::{Case, Sample, Shard};
pub use merge::{MergeError, merge};
pub use plan::{Plan, Selection, SelectionError, plan};
pub use report::{Successes, SuiteReport};
pub use result::{CaseResult, Outcome};
pub use run::{Options, run};
pub use sweep::{SweepPlan, SweepReport};
