//! Flies scenarios × presets × seeds in parallel and makes the tracking table.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;

use super::cache::Cache;
use super::{Report, Scenario, ScenarioError, Verdict, run, side_by_side};
use twin_core::elementary::squared;
use twin_input::interruption;

/// One flight of the table.
#[derive(Clone, Debug)]
pub struct Job {
    /// Label of its line.
    pub row: String,
    /// Scenario file.
    pub file: PathBuf,
    /// `key=value` overrides.
    pub overrides: Vec<String>,
}

/// The outcome of a job.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Label of its line.
    pub row: String,
    /// Its report, or the reason why it could not be flown.
    pub result: Result<Report, String>,
}

/// Flies all jobs on `threads` threads; `done` is called as each ends. The outcomes have the order of the jobs, whatever the
/// number of threads. After a signal no flight begins or goes on; the outcomes of those flights are no outcomes of their scenarios.
pub fn fly_all(
    jobs: &[Job],
    threads: usize,
    cache: Option<&Cache>,
    done: &(dyn Fn(&Outcome) + Sync),
) -> Vec<Outcome> {
    side_by_side(jobs, threads, &|job| {
        let outcome = Outcome { row: job.row.clone(), result: fly_job(job, cache) };
        done(&outcome);
        outcome
    })
}

fn fly_job(job: &Job, cache: Option<&Cache>) -> Result<Report, String> {
    interruption::check().map_err(|signal| signal.to_string())?;
    let scenario =
        Scenario::load(&job.file, &job.overrides).map_err(|e: ScenarioError| e.to_string())?;
    if let Some(report) = cache.and_then(|cache| cache.find(&scenario)) {
        return Ok(report);
    }
    let report = run::fly(&scenario, &mut |_| {}).map_err(|error| error.to_string())?;
    if let Some(cache) = cache {
        cache.keep(&scenario, &report);
    }
    Ok(report)
}

/// One line of the tracking table: all seeds of one scenario with one preset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Name of the preset, or another label.
    pub row: String,
    /// Name of the scenario.
    pub scenario: String,
    /// Number of flights.
    pub flights: usize,
    /// Number of flights that completed.
    pub completed: usize,
    /// Number of flights by verdict, for the other verdicts.
    pub other_verdicts: BTreeMap<String, usize>,
    /// Means, medians and extremes of metrics, by name.
    pub values: BTreeMap<String, f64>,
    /// The paper's value for this scenario and method; the value of FDT+LRA if the paper does not have the method.
    pub paper_rms_error_e8: Option<f64>,
}

/// The paper's scenarios in the order of its table.
pub const COLUMNS: [&str; 8] = [
    "a_300g_slow",
    "a_300g_fast",
    "a_500g_slow",
    "a_500g_fast",
    "b_300g_slow",
    "b_300g_fast",
    "b_500g_slow",
    "b_500g_fast",
];

/// `tab:tracking_results` of the paper: the method of each line and its eight values.
pub const PAPER: [(&str, [f64; 8]); 8] = [
    ("l1", [1.222, 1.560, 1.711, 2.223, 0.981, 1.202, 1.293, 1.617]),
    ("gp", [0.752, 0.960, 1.053, 1.368, 0.604, 0.740, 0.796, 0.995]),
    ("lstm", [0.680, 0.868, 0.952, 1.237, 0.546, 0.669, 0.720, 0.900]),
    ("gpt2", [0.599, 0.765, 0.839, 1.090, 0.481, 0.589, 0.634, 0.793]),
    ("neural_fly", [0.429, 0.547, 0.600, 0.780, 0.344, 0.422, 0.454, 0.567]),
    ("mlp", [0.366, 0.467, 0.512, 0.665, 0.294, 0.360, 0.387, 0.484]),
    ("fdt", [0.258, 0.330, 0.362, 0.470, 0.207, 0.254, 0.274, 0.342]),
    (FULL, [0.215, 0.275, 0.301, 0.391, 0.173, 0.212, 0.228, 0.285]),
];

/// The paper's own method, for comparison with methods that the paper does not have.
const FULL: &str = "fdt_lra";

/// The paper's value for a label (`method/preset`) and a scenario.
fn paper(row: &str, scenario: &str) -> Option<f64> {
    let method = row.split('/').next().unwrap_or(row);
    let of = |name: &str| PAPER.iter().find(|(row, _)| *row == name);
    let column = COLUMNS.iter().position(|column| *column == scenario)?;
    of(method).or_else(|| of(FULL)).map(|(_, figures)| figures[column])
}

/// Metrics whose mean and deviation over the completed flights a line states: of transport, of a path alone once it is settled (m), and of
/// the whole flight. Waiting dilutes the last one, so it is for the comparison with the paper only.
pub const SCORES: [&str; 3] = ["rms_error_e8_transport", "position_rmse_settled_m", "rms_error_e8"];

/// Condenses outcomes to lines, in order of first appearance. Outcomes without a report are skipped.
pub fn condense(outcomes: &[Outcome]) -> Vec<Line> {
    let mut keys: Vec<(String, String)> = Vec::new();
    let mut groups: BTreeMap<(String, String), Vec<&Report>> = BTreeMap::new();
    for outcome in outcomes {
        let Ok(report) = &outcome.result else { continue };
        let key = (outcome.row.clone(), report.scenario.clone());
        if !groups.contains_key(&key) {
            keys.push(key.clone());
        }
        groups.entry(key).or_default().push(report);
    }
    keys.into_iter().map(|key| line(&key, &groups[&key])).collect()
}

fn line((row, scenario): &(String, String), reports: &[&Report]) -> Line {
    let all = |name: &str| -> Vec<f64> {
        reports.iter().filter_map(|r| r.metrics.get(name).copied()).collect()
    };
    let mut values = BTreeMap::new();
    for name in [
        "rms_error_e8",
        "rms_error_e8_transport",
        "transport_speed_m_s",
        "residual_rmse_z",
        "persistence_rmse_z",
    ] {
        insert(&mut values, format!("{name}_mean"), mean(&all(name)));
    }
    insert(
        &mut values,
        "transport_speed_m_s_min".into(),
        all("transport_speed_m_s").into_iter().reduce(f64::min),
    );
    insert(
        &mut values,
        "transport_speed_m_s_max".into(),
        all("transport_speed_m_s").into_iter().reduce(f64::max),
    );
    for name in ["placement_error_mm", "grasp_slip_mm", "flight_s", "retries", "time_to_grasp_s"] {
        insert(&mut values, format!("{name}_median"), median(all(name)));
        insert(&mut values, format!("{name}_max"), all(name).into_iter().reduce(f64::max));
    }
    for name in SCORES {
        let completed: Vec<f64> = reports
            .iter()
            .filter(|r| r.verdict == Verdict::Completed)
            .filter_map(|r| r.metrics.get(name).copied())
            .collect();
        insert(&mut values, format!("completed_{name}_mean"), mean(&completed));
        insert(&mut values, format!("completed_{name}_std"), deviation(&completed));
    }
    let mut other_verdicts = BTreeMap::new();
    for report in reports.iter().filter(|r| r.verdict != Verdict::Completed) {
        *other_verdicts.entry(format!("{:?}", report.verdict)).or_insert(0) += 1;
    }
    Line {
        row: row.clone(),
        scenario: scenario.clone(),
        flights: reports.len(),
        completed: reports.iter().filter(|r| r.verdict == Verdict::Completed).count(),
        other_verdicts,
        values,
        paper_rms_error_e8: paper(row, scenario),
    }
}

fn insert(values: &mut BTreeMap<String, f64>, name: String, value: Option<f64>) {
    if let Some(value) = value {
        values.insert(name, value);
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Standard deviation of a sample; zero if it has a single value.
fn deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values)?;
    let squares: f64 = values.iter().map(|value| squared(value - mean)).sum();
    Some((squares / (values.len().max(2) - 1) as f64).sqrt())
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| 0.5 * (values[(n - 1) / 2] + values[n / 2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(scenario: &str, verdict: Verdict, slip: f64) -> Outcome {
        let metrics = BTreeMap::from([("grasp_slip_mm".to_owned(), slip)]);
        let report = Report {
            scenario: scenario.into(),
            seed: 1,
            verdict,
            reason: String::new(),
            flight_s: 1.0,
            real_time_factor: None,
            state_hash: String::new(),
            kernel: String::new(),
            metrics,
            broken: Vec::new(),
            passed: true,
        };
        Outcome { row: "tuned".into(), result: Ok(report) }
    }

    #[test]
    fn a_line_counts_verdicts_and_takes_medians() {
        let outcomes = [
            report("b_300g_slow", Verdict::Completed, 1.0),
            report("b_300g_slow", Verdict::Dropped, 5.0),
            report("b_300g_slow", Verdict::Completed, 2.0),
            report("other", Verdict::Completed, 9.0),
        ];
        let lines = condense(&outcomes);
        assert_eq!(lines.len(), 2);
        assert_eq!((lines[0].flights, lines[0].completed), (3, 2));
        assert_eq!(lines[0].other_verdicts["Dropped"], 1);
        assert_eq!(lines[0].values["grasp_slip_mm_median"].to_bits(), 2.0_f64.to_bits());
        assert_eq!(lines[0].paper_rms_error_e8, Some(0.173));
        assert_eq!(lines[1].paper_rms_error_e8, None);
    }
}
