//! The report of a run. A shard hands it to the merge, and people read it.
//!
//! In: a plan and its results. Out: counts, sweeps, shares. Everything except wall-clock times is the same for the same flights,
//! whatever the number of jobs or shards.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::case::Shard;
use super::plan::Plan;
use super::result::{CaseResult, Outcome};
use super::share::wilson_95;
use super::sweep::{SweepPlan, SweepReport};
use twin_record::program;

/// The report of a run, or of the part that one shard flew.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SuiteReport {
    /// Version of the program.
    pub version: String,
    /// Commit of the program.
    pub git: String,
    /// `interrupted` if a signal stopped the run before all cases were flown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verdict: Option<String>,
    /// The shard, if this is a part of a run.
    pub shard: Option<Shard>,
    /// Number of flights of all shards.
    pub total: usize,
    /// Number of cases and sweeps that passed; a sweep counts as one.
    pub passed: usize,
    /// Number of cases and sweeps that failed.
    pub failed: usize,
    /// Number of cases that could not be flown.
    pub could_not_run: usize,
    /// Number of cases that were not flown before the run stopped, and of incomplete sweeps.
    pub not_run: usize,
    /// Sweeps in the order of their files.
    pub sweeps: Vec<SweepReport>,
    /// Successes of every scenario that was flown more than once, by its name.
    pub shares: BTreeMap<String, Successes>,
    /// Every flight, in the order of the plan.
    pub cases: Vec<CaseResult>,
}

/// Number of successful flights of one scenario.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Successes {
    /// Number of flights that passed.
    pub passed: usize,
    /// Number of flights.
    pub flown: usize,
    /// Wilson's 95 % interval of the probability to pass.
    pub interval_95: (f64, f64),
}

impl SuiteReport {
    /// The report on the `results` of `plan`.
    pub fn new(plan: &Plan, results: Vec<CaseResult>) -> Self {
        let git = program::commit().to_owned();
        let version = program::VERSION.to_owned();
        Self::of(version, git, plan.shard, plan.total, &plan.sweeps, results)
    }

    pub(super) fn of(
        version: String,
        git: String,
        shard: Option<Shard>,
        total: usize,
        sweeps: &[SweepPlan],
        cases: Vec<CaseResult>,
    ) -> Self {
        let sweeps: Vec<SweepReport> =
            sweeps.iter().map(|plan| SweepReport::new(plan, &cases)).collect();
        let mut report = Self {
            version,
            git,
            verdict: None,
            shard,
            total,
            passed: 0,
            failed: 0,
            could_not_run: 0,
            not_run: 0,
            shares: shares(&cases),
            sweeps,
            cases,
        };
        report.count();
        report
    }

    fn count(&mut self) {
        let alone = self.cases.iter().filter(|result| result.case.sample.is_none());
        let of_cases = alone.map(|result| match &result.outcome {
            Outcome::Flown(report) => Some(Ok(report.passed)),
            Outcome::Unusable(_) => Some(Err(())),
            Outcome::NotRun => None,
        });
        let of_sweeps = self.sweeps.iter().map(|sweep| match sweep.could_not_run {
            0 => sweep.passed.map(Ok),
            _ => Some(Err(())),
        });
        let ends: Vec<Option<Result<bool, ()>>> = of_cases.chain(of_sweeps).collect();
        let count = |end| ends.iter().filter(|found| **found == end).count();
        self.passed = count(Some(Ok(true)));
        self.failed = count(Some(Ok(false)));
        self.could_not_run = count(Some(Err(())));
        self.not_run = count(None);
    }

    /// Why cases were not run, in a sentence.
    pub(super) fn why_not_run(&self) -> &'static str {
        if self.verdict.is_some() {
            "the run was interrupted by a signal"
        } else {
            "the run was stopped at the first failure"
        }
    }

    /// The samples of a sweep.
    pub fn samples_of<'a>(&'a self, sweep: &'a str) -> impl Iterator<Item = &'a CaseResult> {
        let of_it = move |result: &&CaseResult| {
            result.case.sample.as_ref().is_some_and(|sample| sample.sweep == sweep)
        };
        self.cases.iter().filter(of_it)
    }

    /// Simulated time of all flights, s.
    pub fn flown_s(&self) -> f64 {
        // The sum of no numbers is -0; adding 0 makes it 0.
        0.0 + self.cases.iter().filter_map(CaseResult::report).map(|r| r.flight_s).sum::<f64>()
    }
}

/// Successes of every scenario that was flown more than once, without sweeps.
fn shares(cases: &[CaseResult]) -> BTreeMap<String, Successes> {
    let mut counts: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for result in cases.iter().filter(|result| result.case.sample.is_none()) {
        let Some(report) = result.report() else { continue };
        let (passed, flown) = counts.entry(report.scenario.clone()).or_default();
        *passed += usize::from(report.passed);
        *flown += 1;
    }
    let repeated = counts.into_iter().filter(|(_, (_, flown))| *flown > 1);
    repeated
        .map(|(name, (passed, flown))| {
            (name, Successes { passed, flown, interval_95: wilson_95(passed, flown) })
        })
        .collect()
}
