//! Many flights side by side: scenarios × presets × seeds over all cores, and the tracking table they make.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use serde::Serialize;

use super::{Report, Scenario, ScenarioError, Verdict, run};

/// One flight to make.
#[derive(Clone, Debug)]
pub struct Job {
    /// Label of its row.
    pub row: String,
    /// Scenario file.
    pub file: PathBuf,
    /// `key=value` overrides.
    pub overrides: Vec<String>,
}

/// What became of a job.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Label of its row.
    pub row: String,
    /// Its report, or why it could not be flown.
    pub result: Result<Report, String>,
}

/// Flies all jobs on `threads` threads; `done` is called as each ends. The outcome is in the order of the jobs, whatever the
/// number of threads.
pub fn fly_all(jobs: &[Job], threads: usize, done: &(dyn Fn(&Outcome) + Sync)) -> Vec<Outcome> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::sync_channel(jobs.len().max(1));
    std::thread::scope(|scope| {
        for _ in 0..threads.clamp(1, jobs.len().max(1)) {
            let sender = sender.clone();
            let next = &next;
            scope.spawn(move || {
                while let Some((index, job)) = take(jobs, next) {
                    let outcome = Outcome { row: job.row.clone(), result: fly_job(job) };
                    done(&outcome);
                    if sender.send((index, outcome)).is_err() {
                        return;
                    }
                }
            });
        }
    });
    drop(sender);
    let mut outcomes: Vec<(usize, Outcome)> = receiver.into_iter().collect();
    outcomes.sort_by_key(|(index, _)| *index);
    outcomes.into_iter().map(|(_, outcome)| outcome).collect()
}

fn take<'a>(jobs: &'a [Job], next: &AtomicUsize) -> Option<(usize, &'a Job)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    jobs.get(index).map(|job| (index, job))
}

fn fly_job(job: &Job) -> Result<Report, String> {
    let scenario =
        Scenario::load(&job.file, &job.overrides).map_err(|e: ScenarioError| e.to_string())?;
    run::fly(&scenario, &mut |_| {}).map_err(|error| error.to_string())
}

/// One line of the tracking table: all seeds of one scenario under one preset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// Preset or other label.
    pub row: String,
    /// Scenario.
    pub scenario: String,
    /// Flights made.
    pub flights: usize,
    /// Flights that completed.
    pub completed: usize,
    /// How the others ended: verdict and how often.
    pub other_verdicts: BTreeMap<String, usize>,
    /// Means, medians and extremes by name.
    pub values: BTreeMap<String, f64>,
    /// The paper's FDT+LRA figure for this column, if it has one.
    pub paper_rms_error_e8: Option<f64>,
}

/// The paper's FDT+LRA row of `tab:tracking_results` by scenario name.
const PAPER: [(&str, f64); 8] = [
    ("a_300g_slow", 0.215),
    ("a_300g_fast", 0.275),
    ("a_500g_slow", 0.301),
    ("a_500g_fast", 0.391),
    ("b_300g_slow", 0.173),
    ("b_300g_fast", 0.212),
    ("b_500g_slow", 0.228),
    ("b_500g_fast", 0.285),
];

/// Condenses outcomes to lines, in order of first appearance. Outcomes without a report are left out.
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
        paper_rms_error_e8: PAPER
            .iter()
            .find(|(name, _)| name == scenario)
            .map(|(_, value)| *value),
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
            metrics,
            broken_bounds: Vec::new(),
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
