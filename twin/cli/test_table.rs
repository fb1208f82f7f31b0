//! Prints the results of `twin test` in a terminal.

use std::fmt::Write as _;
use std::io::{self, Write};

use twin_scenario::suite::{CaseResult, Successes, SuiteReport};

/// The progress line of a flight, with the reasons of a failure below it.
pub(super) fn line(result: &CaseResult) -> String {
    let mut text = format!("{:18} {}", result.word(), result.case.name);
    if let Some(report) = result.report() {
        let factor = report.real_time_factor.unwrap_or(0.0);
        let _ = write!(
            text,
            ": {}, {:.1} s at {factor:.1} x real time",
            report.reason, report.flight_s
        );
    }
    for line in result.message().lines() {
        let _ = write!(text, "\n    {line}");
    }
    text
}

pub(super) fn print_table(
    out: &mut dyn Write,
    report: &SuiteReport,
    wall_s: f64,
) -> io::Result<()> {
    writeln!(
        out,
        "{:18} {:28} {:>5} {:10} {:>8}  state hash",
        "result", "case", "seed", "verdict", "s"
    )?;
    for result in report.cases.iter().filter(|result| result.case.sample.is_none()) {
        match result.report() {
            Some(report) => writeln!(
                out,
                "{:18} {:28} {:>5} {:10} {:8.2}  {}",
                result.word(),
                result.case.name,
                report.seed,
                report.verdict.to_string(),
                report.flight_s,
                report.state_hash
            )?,
            None => writeln!(out, "{:18} {}", result.word(), result.case.name)?,
        }
        for line in result.message().lines() {
            writeln!(out, "    {line}")?;
        }
    }
    for sweep in &report.sweeps {
        let word = match sweep.passed {
            Some(true) => "passed",
            Some(false) => "FAILED",
            None => "incomplete",
        };
        writeln!(out, "{word:18} {}: {}", sweep.plan.name, sweep.sentence())?;
    }
    for (name, Successes { passed, flown, interval_95: (low, high) }) in &report.shares {
        writeln!(out, "{name}: {passed} of {flown} passed, 95 % interval {low:.3} to {high:.3}")?;
    }
    if let Some(verdict) = &report.verdict {
        writeln!(out, "{verdict}: a signal stopped the run")?;
    }
    let flown_s = report.flown_s();
    writeln!(
        out,
        "{} passed, {} failed, {} could not run, {} not run; {flown_s:.0} s flown in {wall_s:.1} s, {:.1} x real time",
        report.passed,
        report.failed,
        report.could_not_run,
        report.not_run,
        flown_s / wall_s.max(1e-9)
    )?;
    Ok(())
}
