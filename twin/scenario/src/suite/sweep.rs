//! The flights of a sweep, and the result of its samples together.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::case::{Case, SweepSample};
use super::result::{CaseResult, Outcome};
use super::share::wilson_95;
use crate::Scenario;

/// The demands of a sweep; every shard has the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPlan {
    /// Name in reports.
    pub name: String,
    /// Scenario file.
    pub file: PathBuf,
    /// The keys that vary, in the order of a sample's values.
    pub keys: Vec<String>,
    /// Number of samples.
    pub samples: usize,
    /// Share of the samples that must succeed.
    pub min_success: f64,
    /// True if the lower end of the 95 % interval must reach that share.
    pub confident: bool,
}

/// The result of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepReport {
    /// Its demands.
    pub plan: SweepPlan,
    /// Number of samples that were flown.
    pub flown: usize,
    /// Number of samples that succeeded.
    pub succeeded: usize,
    /// Number of samples that could not be flown.
    pub could_not_run: usize,
    /// Wilson's 95 % interval of the share that succeeds.
    pub interval_95: (f64, f64),
    /// Whether enough samples succeed; `None` until every sample was flown.
    pub passed: Option<bool>,
}

/// The plan and the flights of the sweep in `file`; `None` if the file is unreadable or has no sweep. Flying an unreadable file
/// reports its error.
pub(super) fn expand(
    name: &str,
    file: &Path,
    overrides: &[String],
) -> Option<(SweepPlan, Vec<Case>)> {
    let scenario = Scenario::load(file, overrides).ok()?;
    let sweep = scenario.settings.sweep.as_ref()?;
    let keys: Vec<String> = sweep.ranges.iter().map(|range| range.key.clone()).collect();
    let samples = sweep.samples(&scenario.settings);
    let plan = SweepPlan {
        name: name.to_owned(),
        file: file.to_owned(),
        keys: keys.clone(),
        samples: samples.len(),
        min_success: sweep.min_success,
        confident: sweep.confident,
    };
    let digits = samples.len().to_string().len();
    let case = |(number, values): (usize, Vec<f64>)| {
        let set = keys.iter().zip(&values).map(|(key, value)| format!("{key}={value}"));
        Case {
            index: 0,
            name: format!("{name} sample {:0digits$}", number + 1),
            file: file.to_owned(),
            overrides: overrides.iter().cloned().chain(set).collect(),
            sample: Some(SweepSample { sweep: name.to_owned(), values }),
        }
    };
    Some((plan, samples.into_iter().enumerate().map(case).collect()))
}

impl SweepReport {
    /// The result of the samples among `results`.
    pub(super) fn new(plan: &SweepPlan, results: &[CaseResult]) -> Self {
        let of_it = |result: &&CaseResult| {
            result.case.sample.as_ref().is_some_and(|sample| sample.sweep == plan.name)
        };
        let samples: Vec<&CaseResult> = results.iter().filter(of_it).collect();
        let count = |wanted: &dyn Fn(&CaseResult) -> bool| {
            samples.iter().filter(|result| wanted(result)).count()
        };
        let flown = count(&|result| matches!(result.outcome, Outcome::Flown(_)));
        let could_not_run = count(&|result| matches!(result.outcome, Outcome::Unusable(_)));
        let succeeded = count(&CaseResult::passed);
        let interval_95 = wilson_95(succeeded, flown);
        let reached =
            if plan.confident { interval_95.0 } else { succeeded as f64 / flown.max(1) as f64 };
        let passed = (flown == plan.samples).then_some(reached >= plan.min_success);
        Self { plan: plan.clone(), flown, succeeded, could_not_run, interval_95, passed }
    }

    /// Share, interval and demand in words.
    pub fn sentence(&self) -> String {
        let Self { plan, flown, succeeded, could_not_run, interval_95: (low, high), .. } = self;
        let demand = if plan.confident { "lower end of the interval" } else { "share" };
        let missing = match plan.samples - flown.min(&plan.samples) {
            0 => String::new(),
            missing => format!("; {missing} of {} not flown", plan.samples),
        };
        let unusable = match could_not_run {
            0 => String::new(),
            count => format!("; {count} could not run"),
        };
        format!(
            "{succeeded} of {flown} samples succeed ({:.1} %), 95 % interval {low:.3} to {high:.3}; {demand} allowed from {} on{missing}{unusable}",
            100.0 * *succeeded as f64 / (*flown).max(1) as f64,
            plan.min_success,
        )
    }
}
