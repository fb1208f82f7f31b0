//! The reports of shards put together again.

use super::SuiteReport;
use super::run::compare_repeats;

/// Why reports do not make a whole.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// There is none.
    #[error("no report is given, expected the --json output of every shard")]
    Nothing,
    /// They are of different programs.
    #[error(
        "{file}: made by {found}, the first report by {expected}; fly all shards with the same program"
    )]
    Program {
        /// The report.
        file: String,
        /// Version and commit.
        found: String,
        /// Those of the first report.
        expected: String,
    },
    /// They are of different runs.
    #[error(
        "{file}: is of a run of {found} flights with its own sweeps, the first report of one of {expected}; give every shard the same files and flags"
    )]
    Run {
        /// The report.
        file: String,
        /// Flights of its run.
        found: usize,
        /// Flights of the first report's run.
        expected: usize,
    },
    /// A flight is in two of them.
    #[error(
        "{file}: has flight {index} ({name}), which another report has too; give each shard once"
    )]
    Twice {
        /// The report.
        file: String,
        /// Number of the flight.
        index: usize,
        /// Its name.
        name: String,
    },
    /// A flight is in none of them.
    #[error(
        "{missing} of {total} flights are in no report, the first is number {index}; give the reports of all shards"
    )]
    Missing {
        /// How many.
        missing: usize,
        /// Of how many.
        total: usize,
        /// The first of them.
        index: usize,
    },
}

/// The report of the whole run out of those of its shards, each with the name of its file.
///
/// # Errors
/// [`MergeError`] if they are not all the shards of one run.
pub fn merge(shards: Vec<(String, SuiteReport)>) -> Result<SuiteReport, MergeError> {
    let (_, first) = shards.first().ok_or(MergeError::Nothing)?;
    let (version, git, total) = (first.version.clone(), first.git.clone(), first.total);
    let plans: Vec<_> = first.sweeps.iter().map(|sweep| sweep.plan.clone()).collect();
    let mut found: Vec<Option<_>> = std::iter::repeat_with(|| None).take(total).collect();
    for (file, report) in shards {
        if (&report.version, &report.git) != (&version, &git) {
            let found = format!("twin {} {}", report.version, report.git);
            return Err(MergeError::Program {
                file,
                found,
                expected: format!("twin {version} {git}"),
            });
        }
        let same = report.sweeps.iter().map(|sweep| &sweep.plan).eq(&plans);
        if report.total != total || !same {
            return Err(MergeError::Run { file, found: report.total, expected: total });
        }
        for result in report.cases {
            let (index, name) = (result.case.index, result.case.name.clone());
            match found.get_mut(index) {
                Some(place @ None) => *place = Some(result),
                Some(Some(_)) => return Err(MergeError::Twice { file, index, name }),
                None => return Err(MergeError::Run { file, found: index + 1, expected: total }),
            }
        }
    }
    let missing = found.iter().filter(|result| result.is_none()).count();
    if let Some(index) = found.iter().position(Option::is_none) {
        return Err(MergeError::Missing { missing, total, index });
    }
    let mut cases: Vec<_> = found.into_iter().flatten().collect();
    compare_repeats(&mut cases);
    Ok(SuiteReport::of(version, git, None, total, &plans, cases))
}
