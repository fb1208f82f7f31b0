//! Merges the reports of shards into one.

use super::SuiteReport;
use super::run::compare_repeats;

/// Why reports cannot be merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// There is no report.
    #[error("no report is given, expected the --json output of every shard")]
    Nothing,
    /// Different programs made the reports.
    #[error(
        "{file}: made by {found}, the first report by {expected}; fly all shards with the same program"
    )]
    Program {
        /// Name of the report.
        file: String,
        /// Version and commit of its program.
        found: String,
        /// Version and commit of the first report's program.
        expected: String,
    },
    /// The reports belong to different runs.
    #[error(
        "{file}: belongs to a run of {found} flights, the first report to a run of {expected}, or the sweeps differ; give every shard the same files and flags"
    )]
    Run {
        /// Name of the report.
        file: String,
        /// Number of flights in its run.
        found: usize,
        /// Number of flights in the first report's run.
        expected: usize,
    },
    /// Two reports contain the same flight.
    #[error(
        "{file}: has flight {index} ({name}), which another report has too; give each shard once"
    )]
    Twice {
        /// Name of the report.
        file: String,
        /// Index of the flight.
        index: usize,
        /// Name of the flight.
        name: String,
    },
    /// No report contains a flight of the run.
    #[error(
        "{missing} of {total} flights are in no report, the first is number {index}; give the reports of all shards"
    )]
    Missing {
        /// Number of missing flights.
        missing: usize,
        /// Number of flights in the run.
        total: usize,
        /// Index of the first missing flight.
        index: usize,
    },
}

/// The report of the whole run, merged from the reports of its shards; each comes with the name of its file.
///
/// # Errors
/// [`MergeError`] if the reports are not those of all shards of one run.
pub fn merge(shards: Vec<(String, SuiteReport)>) -> Result<SuiteReport, MergeError> {
    let (_, first) = shards.first().ok_or(MergeError::Nothing)?;
    let (version, git, total) = (first.version.clone(), first.git.clone(), first.total);
    let plans: Vec<_> = first.sweeps.iter().map(|sweep| sweep.plan.clone()).collect();
    let verdict = shards.iter().find_map(|(_, report)| report.verdict.clone());
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
    Ok(SuiteReport { verdict, ..SuiteReport::of(version, git, None, total, &plans, cases) })
}
