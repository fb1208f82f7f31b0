//! Scenarios as tests: selects the flights, flies them in parallel, and reports the results to people and to CI systems.
//!
//! In: files, folders and patterns. Out: a [`SuiteReport`] with a [`CaseResult`] per flight, in the order of the cases whatever
//! the number of threads or shards; `JUnit` XML; a page; for each failed flight its recording and a replay page, which the caller
//! makes. The module also compares two recordings.

mod case;
mod result;
pub mod share;
mod sweep;
mod plan;
mod message;
mod record;
mod report;
mod run;
mod merge;
pub mod junit;
mod picture;
pub mod page;
pub mod diff;

pub use case::{Case, Shard, SweepSample};
pub use merge::{MergeError, merge};
pub use plan::{Plan, Selection, SelectionError, plan};
pub use report::{Successes, SuiteReport};
pub use result::{CaseResult, Outcome};
pub use run::{Evidence, MakePage, Options, run};
pub use sweep::{SweepPlan, SweepReport};
