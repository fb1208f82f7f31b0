//! Flies cases in parallel.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use super::case::Case;
use super::plan::Plan;
use super::record;
use super::report::SuiteReport;
use super::result::{CaseResult, Outcome};
use crate::{Report, Scenario, Verdict, Violation, fly};
use twin_input::interruption;
use twin_record::Outputs;

/// Options of a run.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Number of flights at a time.
    pub jobs: usize,
    /// True if no new flight starts after a failure.
    pub fail_fast: bool,
    /// True if flights replace the golden runs of their scenarios instead of being compared with them.
    pub update: bool,
    /// The evidence to make of failed flights.
    pub evidence: Option<Evidence>,
    /// The outputs of this run.
    pub outputs: Outputs,
}

/// The evidence of a failed flight: its recording and a replay page.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// Folder for both files.
    pub folder: PathBuf,
    /// Makes the page; `None` for recordings only.
    pub make_page: Option<MakePage>,
}

/// The replay page of a recording. Arguments: file of the recording, report of the flight. Returns the page and the second of the flight
/// at which it opens, or the reason why there is no page.
pub type MakePage = fn(&Path, &Report) -> Result<(String, f64), String>;

/// Flies the cases of `plan` until a signal asks the program to end; the cases that it cuts off are not run. `done` receives each result as its flight ends. The report has the order of the cases.
pub fn run(plan: &Plan, options: &Options, done: &(dyn Fn(&CaseResult) + Sync)) -> SuiteReport {
    let cases = &plan.cases;
    let next = AtomicUsize::new(0);
    let stop = AtomicBool::new(false);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..options.jobs.clamp(1, cases.len().max(1)) {
            let sender = sender.clone();
            let (next, stop) = (&next, &stop);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(index) else { return };
                    let stopped =
                        stop.load(Ordering::Relaxed) || interruption::requested().is_some();
                    let result = if stopped {
                        not_run(case)
                    } else {
                        let result = fly_case(case, options);
                        if !matches!(result.outcome, Outcome::NotRun) {
                            done(&result);
                        }
                        result
                    };
                    if options.fail_fast && !result.passed() && case.sample.is_none() {
                        stop.store(true, Ordering::Relaxed);
                    }
                    if sender.send((index, result)).is_err() {
                        return;
                    }
                }
            });
        }
    });
    drop(sender);
    let mut results: Vec<(usize, CaseResult)> = receiver.into_iter().collect();
    results.sort_by_key(|(index, _)| *index);
    let mut results: Vec<CaseResult> = results.into_iter().map(|(_, result)| result).collect();
    compare_repeats(&mut results);
    let cut_off = results.iter().any(|result| matches!(result.outcome, Outcome::NotRun));
    let mut report = SuiteReport::new(plan, results);
    if cut_off && interruption::requested().is_some() {
        report.verdict = Some(Verdict::Interrupted.to_string());
    }
    report
}

fn not_run(case: &Case) -> CaseResult {
    CaseResult {
        case: case.clone(),
        outcome: Outcome::NotRun,
        wall_s: 0.0,
        artifact: None,
        replay: None,
        artifact_trouble: None,
    }
}

fn fly_case(case: &Case, options: &Options) -> CaseResult {
    let started = now();
    let flown = catch_unwind(AssertUnwindSafe(|| {
        let scenario = Scenario::load(&case.file, &case.overrides).map_err(|e| e.to_string())?;
        let named = |error: &dyn std::fmt::Display| format!("{}: {error}", case.file.display());
        let report = match &scenario.settings.golden {
            Some(golden) if options.update => record::golden(&scenario, golden, &options.outputs),
            _ => fly(&scenario, &mut |_| {}).map_err(record::RecordError::from),
        };
        Ok::<_, String>((scenario, report.map_err(|error| named(&error))?))
    }));
    let mut result = CaseResult { wall_s: started.elapsed().as_secs_f64(), ..not_run(case) };
    let (scenario, mut report) = match flown {
        Ok(Ok(flown)) => flown,
        // The flight was cut off by a signal: it has no result.
        Ok(Err(_)) if interruption::requested().is_some() => return result,
        Ok(Err(why)) => {
            result.outcome = Outcome::Unusable(why);
            return result;
        }
        Err(panic) => {
            let words = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied());
            let words = words.unwrap_or("without a message");
            result.outcome = Outcome::Unusable(format!(
                "{}: the program panicked: {words}",
                case.file.display()
            ));
            return result;
        }
    };
    report.real_time_factor = Some(report.flight_s / result.wall_s.max(1e-9));
    // A sample of a sweep may fail. Its message names the overrides that repeat it.
    if let (false, Some(evidence), None) = (report.passed, &options.evidence, &case.sample) {
        keep_evidence(&mut result, evidence, &options.outputs, (&scenario, &report));
    }
    result.outcome = Outcome::Flown(Box::new(report));
    result
}

/// Records the failed flight of `scenario`, makes its page, and stores both paths in `result`.
fn keep_evidence(
    result: &mut CaseResult,
    Evidence { folder, make_page }: &Evidence,
    outputs: &Outputs,
    (scenario, report): (&Scenario, &Report),
) {
    let path = folder.join(file_name(&result.case.name));
    let path = match record::flown_again(scenario, report, &path, outputs) {
        Ok(path) => path,
        Err(error) => {
            result.artifact_trouble = Some(error.to_string());
            return;
        }
    };
    if let Some(make_page) = make_page {
        let page = path.with_extension("html");
        let written = make_page(&path, report).and_then(|(text, opens_at_s)| {
            let page = record::page(&page, &text, outputs).map_err(|error| error.to_string())?;
            Ok((page, opens_at_s))
        });
        match written {
            Ok(replay) => result.replay = Some(replay),
            Err(why) => result.artifact_trouble = Some(why),
        }
    }
    result.artifact = Some(path);
}

/// `name` as the file name of a recording.
fn file_name(name: &str) -> PathBuf {
    let plain = |c: char| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' };
    Path::new(&name.chars().map(plain).collect::<String>()).with_added_extension("mcap")
}

/// Compares the state hashes of flights of one file with the same overrides; a flight that differs from the first fails.
pub(super) fn compare_repeats(results: &mut [CaseResult]) {
    let mut first: BTreeMap<(PathBuf, Vec<String>), String> = BTreeMap::new();
    for result in results {
        let Outcome::Flown(report) = &mut result.outcome else { continue };
        let key = (result.case.file.clone(), result.case.overrides.clone());
        let expected = first.entry(key).or_insert_with(|| report.state_hash.clone());
        let known = report.broken.iter().any(|broken| broken.name == "state_hash");
        if *expected != report.state_hash && !known {
            report.passed = false;
            report.broken.push(Violation {
                name: "state_hash".to_owned(),
                what: "state_hash".to_owned(),
                value: None,
                found: report.state_hash.clone(),
                allowed: format!("{expected}, as in the first run of this flight"),
                at_s: report.flight_s,
            });
        }
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "the duration of a test; the flight does not depend on it"
)]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Report;

    fn flown(name: &str, hash: &str) -> CaseResult {
        let report = Report {
            scenario: name.into(),
            seed: 1,
            verdict: crate::Verdict::Completed,
            reason: String::new(),
            flight_s: 7.0,
            real_time_factor: None,
            state_hash: hash.into(),
            kernel: String::new(),
            metrics: BTreeMap::new(),
            broken: Vec::new(),
            passed: true,
        };
        let case = Case {
            index: 0,
            name: name.into(),
            file: name.into(),
            overrides: Vec::new(),
            sample: None,
        };
        CaseResult { outcome: Outcome::Flown(Box::new(report)), ..not_run(&case) }
    }

    #[test]
    fn a_repeat_with_another_hash_fails_and_names_both() {
        let mut results = [flown("a", "1"), flown("b", "2"), flown("a", "1"), flown("b", "3")];
        compare_repeats(&mut results);
        assert_eq!(results.each_ref().map(CaseResult::passed), [true, true, true, false]);
        let Outcome::Flown(report) = &results[3].outcome else { panic!("it was flown") };
        let text = report.broken[0].to_string();
        assert!(text.contains("found 3") && text.contains("allowed 2"), "{text}");
    }

    #[test]
    fn a_name_becomes_a_plain_file_name() {
        assert_eq!(file_name("a/b seed 3 run 1.5"), Path::new("a_b_seed_3_run_1.5.mcap"));
    }
}
