//! `twin evaluate tracking`: the tracking table.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use twin_input::interruption;
use twin_lab::evaluate::Sheet;
use twin_lab::evaluate::paths::path;
use twin_lab::evaluate::sheet::figure;
use twin_record::output::note;
use twin_scenario::cache::Cache;
use twin_scenario::table::{COLUMNS, Job, Line, Outcome, PAPER, SCORES, condense, fly_all};
use twin_scenario::{Scenario, Verdict, side_by_side};

use super::output::{Output, inputs_of};
use crate::cli::{End, Overrides, print, read_weights};

#[derive(Args)]
pub(super) struct TrackingArgs {
    /// Scenario files [default: the paper's eight].
    scenarios: Vec<PathBuf>,
    /// Seeds 1..=N of each scenario.
    #[arg(long, default_value_t = 10)]
    seeds: u64,
    /// Methods without a file of weights, one line each; `fdt` and `fdt_lra` fly the built-in weights; '' for none.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "pid,l1,tdc,tdc_extrapolated,arx_rls,random_features"
    )]
    rows: Vec<String>,
    /// Gain presets.
    #[arg(long, value_delimiter = ',', default_value = "tuned,paper")]
    presets: Vec<String>,
    /// File of weights; an FDT gives two lines, without and with the adapter, any other model gives one. Weights fly whether or not
    /// they were accepted (repeatable).
    #[arg(long, value_name = "FILE")]
    weights: Vec<PathBuf>,
    /// Fly the path alone, with the payload in the gripper from the start, as `evaluate l1` does. This also shows the tracking of a
    /// method that fails before the grasp.
    #[arg(long)]
    path_alone: bool,
    /// Flights at a time [default: one per core].
    #[arg(long)]
    jobs: Option<usize>,
    /// Folder that keeps finished flights, so that an interrupted run can resume.
    #[arg(long, value_name = "DIR", default_value = "out/cache")]
    cache: PathBuf,
    /// Fly every flight again.
    #[arg(long, conflicts_with = "cache")]
    no_cache: bool,
    #[command(flatten)]
    pub(super) output: Output,
    #[command(flatten)]
    overrides: Overrides,
}

/// Name of a line and the overrides that make it.
const ROWS: [(&str, &[&str]); 9] = [
    ("pid", &["controller.kind=pid"]),
    ("l1", &["controller.kind=l1"]),
    ("tdc", &["predictor.kind=persistence"]),
    ("oracle", &["predictor.kind=oracle"]),
    ("tdc_extrapolated", &["predictor.kind=tdc_extrapolated"]),
    ("arx_rls", &["predictor.kind=arx_rls"]),
    ("random_features", &["predictor.kind=random_features"]),
    ("fdt", &["predictor.kind=fdt", "gains.adapter_on=0"]),
    ("fdt_lra", &["predictor.kind=fdt"]),
];

/// Overrides of a baseline from a file. The adapter is off, because a baseline that adapts does so by itself.
const BASELINE: [&str; 2] = ["predictor.kind=trained", "gains.adapter_on=0"];

pub(super) fn run(args: &TrackingArgs) -> anyhow::Result<End> {
    let jobs = jobs(args)?;
    let flown = inputs_of(jobs.iter().map(|job| &job.file));
    let places = args.output.reserve(args.weights.iter().cloned().chain(flown))?;
    let threads =
        args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let cache = if args.no_cache {
        None
    } else {
        Some(Cache::open(&args.cache).with_context(|| args.cache.display().to_string())?)
    };
    let bar = ProgressBar::new(jobs.len() as u64).with_style(
        ProgressStyle::with_template(
            "{elapsed_precise} [{wide_bar}] {pos}/{len} flights, {eta} left  {msg}",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let outcomes = fly_all(&jobs, threads, cache.as_ref(), &|outcome| {
        bar.inc(1);
        if let Some(trouble) = trouble(outcome).filter(|_| interruption::requested().is_none()) {
            bar.suspend(|| note(format_args!("{trouble}")));
        }
    });
    bar.finish_and_clear();
    interruption::check()?;
    let lines = condense(&outcomes);
    let (table, title) = if args.path_alone {
        ("tracking_path_alone", "Tracking of the paths alone, payload in hand")
    } else {
        ("tracking", "Tracking in full missions")
    };
    let outputs = places.write_pictures(title, &sheet(&lines), || paths(&jobs))?;
    print(&outputs, |out| {
        let command = super::command();
        if args.output.json {
            let value = serde_json::json!({ "table": table, "command": command, "lines": lines, "paper": PAPER });
            writeln!(out, "{value}")?;
        } else {
            let [transport, settled, whole] = SCORES;
            if args.path_alone {
                print_matrix(out, &lines, settled, "position RMS from 8 s on, m")?;
            } else {
                print_matrix(out, &lines, transport, "rms e8 in transport, m and rad")?;
            }
            print_matrix(out, &lines, whole, "rms e8 of the whole flight (waiting dilutes it)")?;
            print_paper(out, &lines)?;
            print_table(out, &lines)?;
            writeln!(out, "\n{command}")?;
        }
        Ok(())
    })?;
    let all =
        outcomes.iter().all(|o| o.result.as_ref().is_ok_and(|r| r.verdict == Verdict::Completed));
    Ok(if all { End::Passed } else { End::Failed })
}

/// Figures of a line: name on the page, name in JSON, decimals.
const FIGURES: [(&str, &str, usize); 17] = [
    ("e8 in transport, completed, mean", "completed_rms_error_e8_transport_mean", 4),
    ("e8 in transport, completed, std", "completed_rms_error_e8_transport_std", 4),
    ("position from 8 s, m, mean", "completed_position_rmse_settled_m_mean", 4),
    ("position from 8 s, m, std", "completed_position_rmse_settled_m_std", 4),
    ("e8 whole flight, mean", "completed_rms_error_e8_mean", 4),
    ("e8 whole flight, std", "completed_rms_error_e8_std", 4),
    ("e8 mean, all flights", "rms_error_e8_mean", 4),
    ("e8 in transport", "rms_error_e8_transport_mean", 4),
    ("cruise m/s, least", "transport_speed_m_s_min", 3),
    ("cruise m/s, most", "transport_speed_m_s_max", 3),
    ("placing mm, median", "placement_error_mm_median", 1),
    ("placing mm, most", "placement_error_mm_max", 1),
    ("slip mm, median", "grasp_slip_mm_median", 2),
    ("slip mm, most", "grasp_slip_mm_max", 2),
    ("flight s, median", "flight_s_median", 1),
    ("retries, most", "retries_max", 0),
    ("a-priori RMSE z", "residual_rmse_z_mean", 3),
];

fn sheet(lines: &[Line]) -> Sheet {
    let head = ["row", "scenario", "flights", "completed", "other ends", "paper e8"];
    let mut sheet = Sheet::new(head.into_iter().chain(FIGURES.map(|(name, ..)| name)));
    sheet.rows.extend(lines.iter().map(|line| {
        let others = line.other_verdicts.iter().map(|(end, n)| format!("{n} {end}"));
        let mut cells = vec![
            line.row.clone(),
            line.scenario.clone(),
            line.flights.to_string(),
            line.completed.to_string(),
            others.collect::<Vec<_>>().join(" "),
            figure(line.paper_rms_error_e8, 3),
        ];
        cells.extend(FIGURES.map(|(_, key, n)| figure(line.values.get(key).copied(), n)));
        cells
    }));
    sheet
}

/// Pictures of the paths of the last line, with the first seed of each column. They are flown again, because reports hold no path.
fn paths(jobs: &[Job]) -> anyhow::Result<String> {
    let Some(last) = jobs.last() else { return Ok(String::new()) };
    let mut drawn: Vec<(String, Scenario)> = Vec::new();
    for job in jobs.iter().filter(|job| job.row == last.row) {
        if drawn.iter().all(|(_, scenario)| scenario.file != job.file) {
            drawn.push((job.row.clone(), Scenario::load(&job.file, &job.overrides)?));
        }
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let pictures = side_by_side(&drawn, threads, &|(row, scenario)| path(scenario, row));
    let mut text = format!("<h2>Paths from above, {}</h2>", last.row);
    for picture in pictures {
        text.push_str(&picture?.svg());
    }
    Ok(text)
}

/// A line of the table: its name and the overrides that make it.
struct Row {
    name: String,
    keys: Vec<String>,
}

fn rows(args: &TrackingArgs) -> anyhow::Result<Vec<Row>> {
    let strings = |keys: &[&str]| keys.iter().map(|key| (*key).to_owned()).collect::<Vec<_>>();
    let keys = |name: &str| {
        let known = || ROWS.map(|(name, _)| name).join(", ");
        let found = ROWS.iter().find(|(row, _)| *row == name);
        found
            .map(|(_, keys)| strings(keys))
            .with_context(|| format!("--rows: found {name:?}, expected {}", known()))
    };
    let mut rows = Vec::new();
    for name in args.rows.iter().filter(|name| !name.is_empty()) {
        rows.push(Row { name: name.clone(), keys: keys(name)? });
    }
    for file in &args.weights {
        let weights = read_weights(file)?;
        // A scenario resolves the path of the weights relative to itself, so the path is made absolute.
        let whole = std::fs::canonicalize(file)?;
        let flown =
            [format!("predictor.weights={}", whole.display()), "predictor.force=true".to_owned()];
        let model = weights.head.model;
        let names = if model == "fdt" { vec!["fdt", "fdt_lra"] } else { vec![model.as_str()] };
        for name in names {
            let keys = if model == "fdt" { keys(name)? } else { strings(&BASELINE) };
            rows.push(Row { name: name.to_owned(), keys: [keys, flown.to_vec()].concat() });
        }
    }
    Ok(rows)
}

fn jobs(args: &TrackingArgs) -> anyhow::Result<Vec<Job>> {
    let files = if args.scenarios.is_empty() {
        COLUMNS.iter().map(|name| PathBuf::from(format!("scenarios/{name}.toml"))).collect()
    } else {
        args.scenarios.clone()
    };
    let mut jobs = Vec::new();
    for row in rows(args)? {
        for preset in &args.presets {
            for file in &files {
                for seed in 1..=args.seeds {
                    let mut overrides = args.overrides.set.clone();
                    overrides.extend(row.keys.iter().cloned());
                    overrides.extend([format!("gains.preset={preset}"), format!("seed={seed}")]);
                    if args.path_alone {
                        overrides.extend(super::PATH_ALONE.map(str::to_owned));
                    }
                    let row = format!("{}/{preset}", row.name);
                    jobs.push(Job { row, file: file.clone(), overrides });
                }
            }
        }
    }
    Ok(jobs)
}

/// A sentence about a flight that did not complete; `None` for one that did.
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

/// Prints a table in the paper's form: a line per method, a column per scenario, mean ± standard deviation of `metric` over the flights that
/// completed. Scenarios that are not the paper's have no such table.
fn print_matrix(out: &mut dyn Write, lines: &[Line], metric: &str, title: &str) -> io::Result<()> {
    if !lines.iter().any(|line| COLUMNS.contains(&line.scenario.as_str())) {
        return Ok(());
    }
    writeln!(out, "{title}")?;
    write!(out, "{:24}", "")?;
    for column in COLUMNS {
        write!(out, " {column:>15}")?;
    }
    writeln!(out)?;
    let mut rows: Vec<&str> = Vec::new();
    for line in lines {
        if rows.last() != Some(&line.row.as_str()) {
            rows.push(&line.row);
        }
    }
    for row in rows {
        write!(out, "{row:24}")?;
        for column in COLUMNS {
            let cell = lines.iter().find(|line| line.row == row && line.scenario == column);
            write!(
                out,
                " {:>15}",
                cell.map_or_else(|| "-".to_owned(), |line| matrix_cell(line, metric))
            )?;
        }
        writeln!(out)?;
    }
    writeln!(out)
}

/// Prints the figures of the paper, which are of whole flights.
fn print_paper(out: &mut dyn Write, lines: &[Line]) -> io::Result<()> {
    if !lines.iter().any(|line| COLUMNS.contains(&line.scenario.as_str())) {
        return Ok(());
    }
    for (row, figures) in PAPER {
        write!(out, "paper {row:18}")?;
        for value in figures {
            write!(out, " {value:>15.3}")?;
        }
        writeln!(out)?;
    }
    writeln!(out)
}

fn matrix_cell(line: &Line, metric: &str) -> String {
    let v = |part: &str| line.values.get(&format!("completed_{metric}_{part}")).copied();
    let lost = line.flights - line.completed;
    let lost = if lost > 0 { format!(" {lost}x") } else { String::new() };
    match (v("mean"), v("std")) {
        (Some(mean), Some(std)) => format!("{mean:.4}±{std:.4}{lost}"),
        _ => format!("none{lost}"),
    }
}

fn print_table(out: &mut dyn Write, lines: &[Line]) -> io::Result<()> {
    writeln!(
        out,
        "{:22} {:12} {:>5}  {:>7} {:>9} {:>6}  {:>17}  {:>13}  {:>13}  {:>11}  {:>11}  others",
        "row",
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
    )?;
    for line in lines {
        // A path alone places nothing, so it has no placing error.
        let v = |name: &str, decimals: usize| {
            let value = line.values.get(name).filter(|value| value.is_finite());
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
        };
        let others: Vec<String> =
            line.other_verdicts.iter().map(|(k, n)| format!("{n} {k}")).collect();
        writeln!(
            out,
            "{:22} {:12} {:>2}/{:<2}  {:>7} {:>9} {:>6}  {:>8} ..{:>7}  {:>7} / {:>5}  {:>7} / {:>5}  {:>11}  {:>11}  {}",
            line.row,
            line.scenario,
            line.completed,
            line.flights,
            v("rms_error_e8_mean", 3),
            v("rms_error_e8_transport_mean", 3),
            line.paper_rms_error_e8.map_or_else(|| "-".to_owned(), |p| format!("{p:.3}")),
            v("transport_speed_m_s_min", 3),
            v("transport_speed_m_s_max", 3),
            v("placement_error_mm_median", 1),
            v("placement_error_mm_max", 1),
            v("grasp_slip_mm_median", 2),
            v("grasp_slip_mm_max", 2),
            v("flight_s_median", 1),
            v("retries_max", 0),
            others.join(", "),
        )?;
    }
    for preset in lines.iter().map(|l| &l.row).collect::<std::collections::BTreeSet<_>>() {
        let of =
            |f: fn(&Line) -> usize| lines.iter().filter(|l| &l.row == preset).map(f).sum::<usize>();
        writeln!(out, "{preset}: completed {} of {}", of(|l| l.completed), of(|l| l.flights))?;
    }
    Ok(())
}
