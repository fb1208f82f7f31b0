//! Results as `JUnit` XML: a `failure` is a broken demand of the scenario, an `error` is a flight that could not be flown.
//!
//! The output follows the strictest schema in use (junit-10.xsd of the Jenkins xUnit plugin, which pytest follows too). That
//! schema allows properties only on suites, so every case is a suite of its own.

use std::time::Duration;

use quick_junit::{
    NonSuccessKind, Property, Report as Document, SerializeError, TestCase, TestCaseStatus,
    TestSuite,
};

use super::{CaseResult, Outcome, SuiteReport, SweepReport};
use crate::Report;

/// The results, one suite per case. A flown case has its seed, state hash, verdict and metrics as properties; the message of a
/// failure names metric, value, bound and second. A sweep is one case, whose output lists its samples.
///
/// # Errors
/// [`SerializeError`] if the XML cannot be written.
pub fn xml(report: &SuiteReport) -> Result<String, SerializeError> {
    let mut document = Document::new("twin");
    document.set_time(seconds(report.cases.iter().map(|result| result.wall_s).sum()));
    let alone = report.cases.iter().filter(|result| result.case.sample.is_none());
    document.add_test_suites(alone.map(|result| suite(result, report.why_not_run())));
    document.add_test_suites(report.sweeps.iter().map(|sweep| sweep_suite(sweep, report)));
    for suite in &mut document.test_suites {
        suite.add_property(("version", report.version.as_str()));
        suite.add_property(("git", report.git.as_str()));
    }
    let text = document.to_string()?;
    // The library also counts skipped cases on the root, where the schema has no such attribute.
    let (head, root) = text.split_once("<testsuites").unwrap_or((&text, ""));
    let (root, rest) = root.split_once('>').unwrap_or((root, ""));
    let root: Vec<&str> = root.split(' ').filter(|part| !part.starts_with("skipped=")).collect();
    Ok(format!("{head}<testsuites{}>{rest}", root.join(" ")))
}

fn seconds(wall_s: f64) -> Duration {
    Duration::try_from_secs_f64(wall_s).unwrap_or_default()
}

fn suite(result: &CaseResult, why_not_run: &str) -> TestSuite {
    let mut case = TestCase::new(result.case.name.as_str(), status(result, why_not_run));
    case.set_classname(class_name(&result.case.file));
    case.set_time(seconds(result.wall_s));
    let mut suite = TestSuite::new(result.case.name.as_str());
    suite.set_time(seconds(result.wall_s));
    suite.add_property(("file", result.case.file.display().to_string().as_str()));
    if let Outcome::Flown(report) = &result.outcome {
        suite.add_properties(properties(report));
    }
    suite.add_test_case(case);
    suite
}

fn class_name(file: &std::path::Path) -> String {
    file.with_extension("").display().to_string().replace('/', ".")
}

fn properties(report: &Report) -> Vec<Property> {
    let mut all = vec![
        Property::new("seed", report.seed.to_string()),
        Property::new("state_hash", report.state_hash.as_str()),
        Property::new("verdict", report.verdict.to_string()),
    ];
    all.extend(report.metrics.iter().map(|(name, value)| Property::new(name, value.to_string())));
    all
}

fn status(result: &CaseResult, why_not_run: &str) -> TestCaseStatus {
    let (kind, word, message) = match &result.outcome {
        Outcome::NotRun => {
            let mut status = TestCaseStatus::skipped();
            status.set_message(why_not_run);
            return status;
        }
        Outcome::Flown(report) if report.passed => return TestCaseStatus::success(),
        Outcome::Flown(report) => {
            let word = report.broken.first().map_or("expect.fails", |broken| broken.name.as_str());
            (NonSuccessKind::Failure, word.to_owned(), result.message())
        }
        Outcome::Unusable(_) => (NonSuccessKind::Error, "unusable".to_owned(), result.message()),
    };
    non_success(kind, &word, &message)
}

fn non_success(kind: NonSuccessKind, word: &str, message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_type(word).set_message(message.lines().next().unwrap_or_default());
    status.set_description(message);
    status
}

fn sweep_suite(sweep: &SweepReport, report: &SuiteReport) -> TestSuite {
    let samples = || report.samples_of(&sweep.plan.name);
    let sentence = sweep.sentence();
    let status = if sweep.could_not_run > 0 {
        non_success(NonSuccessKind::Error, "unusable", &sentence)
    } else if let Some(passed) = sweep.passed {
        if passed {
            TestCaseStatus::success()
        } else {
            non_success(NonSuccessKind::Failure, "min_success", &sentence)
        }
    } else {
        let mut status = TestCaseStatus::skipped();
        status.set_message(sentence.as_str());
        status
    };
    let mut case = TestCase::new(sweep.plan.name.as_str(), status);
    let wall_s = samples().map(|result| result.wall_s).sum();
    case.set_classname(class_name(&sweep.plan.file));
    case.set_time(seconds(wall_s));
    let failed = samples().filter(|result| !result.passed());
    let lines = failed.map(|result| format!("{}\n{}", result.case.name, result.message()));
    case.set_system_out(format!("{sentence}\n{}", lines.collect::<Vec<_>>().join("\n")));
    let mut suite = TestSuite::new(sweep.plan.name.as_str());
    suite.set_time(seconds(wall_s));
    suite.add_property(("file", sweep.plan.file.display().to_string().as_str()));
    suite.add_property(("samples", sweep.plan.samples.to_string().as_str()));
    suite.add_property(("succeeded", sweep.succeeded.to_string().as_str()));
    suite.add_test_case(case);
    suite
}
