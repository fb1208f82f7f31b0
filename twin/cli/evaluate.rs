//! `twin evaluate`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use twin::scenario::Verdict;
use twin::scenario::table::{Job, Line, Outcome, condense, fly_all};

use super::{End, Overrides};

#[derive(Args)]
pub(super) struct EvaluateArgs {
    #[command(subcommand)]
    table: Table,
}

#[derive(Subcommand)]
enum Table {
    /// Full pick, carry and place in all eight scenarios, several seeds and presets.
    Tracking(TrackingArgs),
}

#[derive(Args)]
struct TrackingArgs {
    /// Scenario files [default: the paper's eight].
    scenarios: Vec<PathBuf>,
    /// Seeds 1..=N of each scenario.
    #[arg(long, default_value_t = 10)]
    seeds: u64,
    /// Gain presets, one row each.
    #[arg(long, value_delimiter = ',', default_value = "tuned,paper")]
    presets: Vec<String>,
    /// Flights at a time [default: one per core].
    #[arg(long)]
    jobs: Option<usize>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overrides: Overrides,
}

const EIGHT: [&str; 8] = [
    "a_300g_slow",
    "a_300g_fast",
    "a_500g_slow",
    "a_500g_fast",
    "b_300g_slow",
    "b_300g_fast",
    "b_500g_slow",
    "b_500g_fast",
];

pub(super) fn run(args: &EvaluateArgs) -> End {
    match &args.table {
        Table::Tracking(args) => tracking(args),
    }
}

fn tracking(args: &TrackingArgs) -> End {
    let jobs = jobs(args);
    let threads =
        args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let bar = ProgressBar::new(jobs.len() as u64).with_style(
        ProgressStyle::with_template(
            "{elapsed_precise} [{wide_bar}] {pos}/{len} flights, {eta} left  {msg}",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let outcomes = fly_all(&jobs, threads, &|outcome| {
        bar.inc(1);
        if let Some(trouble) = trouble(outcome) {
            bar.suspend(|| eprintln!("{trouble}"));
        }
    });
    bar.finish_and_clear();
    let lines = condense(&outcomes);
    if args.json {
        println!("{}", serde_json::json!({ "table": "tracking", "lines": lines }));
    } else {
        print_table(&lines);
    }
    let all =
        outcomes.iter().all(|o| o.result.as_ref().is_ok_and(|r| r.verdict == Verdict::Completed));
    if all { End::Passed } else { End::Failed }
}

fn jobs(args: &TrackingArgs) -> Vec<Job> {
    let files = if args.scenarios.is_empty() {
        EIGHT.iter().map(|name| PathBuf::from(format!("scenarios/{name}.toml"))).collect()
    } else {
        args.scenarios.clone()
    };
    let mut jobs = Vec::new();
    for preset in &args.presets {
        for file in &files {
            for seed in 1..=args.seeds {
                let mut overrides = args.overrides.set.clone();
                overrides.extend([format!("gains.preset={preset}"), format!("seed={seed}")]);
                jobs.push(Job { row: preset.clone(), file: file.clone(), overrides });
            }
        }
    }
    jobs
}

/// A sentence for a flight that did not complete.
fn trouble(outcome: &Outcome) -> Option<String> {
    match &outcome.result {
        Ok(report) if report.verdict == Verdict::Completed => None,
        Ok(r) => Some(format!(
            "{} {} seed {}: {:?}: {}",
            outcome.row, r.scenario, r.seed, r.verdict, r.reason
        )),
        Err(error) => Some(format!("{}: {error}", outcome.row)),
    }
}

fn print_table(lines: &[Line]) {
    println!(
        "{:7} {:12} {:>5}  {:>7} {:>9} {:>6}  {:>17}  {:>13}  {:>13}  {:>11}  {:>11}  others",
        "preset",
        "scenario",
        "done",
        "e8",
        "e8 transp",
        "paper",
        "speed m/s min..max",
        "place mm med/max",
        "slip mm med/max",
        "time s med",
        "retries max"
    );
    for line in lines {
        let v = |name: &str| line.values.get(name).copied().unwrap_or(f64::NAN);
        let others: Vec<String> =
            line.other_verdicts.iter().map(|(k, n)| format!("{n} {k}")).collect();
        println!(
            "{:7} {:12} {:>2}/{:<2}  {:7.3} {:9.3} {:>6}  {:8.3} ..{:7.3}  {:7.1} / {:5.1}  {:7.2} / {:5.2}  {:11.1}  {:11.0}  {}",
            line.row,
            line.scenario,
            line.completed,
            line.flights,
            v("rms_error_e8_mean"),
            v("rms_error_e8_transport_mean"),
            line.paper_rms_error_e8.map_or_else(|| "-".to_owned(), |p| format!("{p:.3}")),
            v("transport_speed_m_s_min"),
            v("transport_speed_m_s_max"),
            v("placement_error_mm_median"),
            v("placement_error_mm_max"),
            v("grasp_slip_mm_median"),
            v("grasp_slip_mm_max"),
            v("flight_s_median"),
            v("retries_max"),
            others.join(", "),
        );
    }
    for preset in lines.iter().map(|l| &l.row).collect::<std::collections::BTreeSet<_>>() {
        let of =
            |f: fn(&Line) -> usize| lines.iter().filter(|l| &l.row == preset).map(f).sum::<usize>();
        println!("{preset}: completed {} of {}", of(|l| l.completed), of(|l| l.flights));
    }
}
