//! `twin test`: flies scenarios as tests.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use twin_console::replay;
use twin_input::budget::REPORT_BYTES;
use twin_scenario::Report;
use twin_scenario::suite::{
    Evidence, Options, Selection, Shard, SuiteReport, junit, merge, page, plan, run,
};

use super::test_table::{line, print_table};
use super::{End, Overrides};

#[derive(Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct TestArgs {
    #[command(subcommand)]
    merge: Option<TestCommand>,
    #[command(flatten)]
    fly: FlyTests,
}

#[derive(Subcommand)]
enum TestCommand {
    /// Merge the --json reports of all shards of a run into the report of a run without shards.
    Merge(MergeArgs),
}

#[derive(Args)]
struct FlyTests {
    /// Scenario files, folders of them, or patterns.
    #[arg(default_value = "scenarios")]
    paths: Vec<String>,
    /// Flights at a time [default: one per core].
    #[arg(long)]
    jobs: Option<usize>,
    /// Fly only every N-th flight, from the K-th on: the shard of one of several machines.
    #[arg(long, value_name = "K/N")]
    shard: Option<Shard>,
    /// Seeds for each scenario instead of its own: a count (1 to N) or a list. A sweep keeps its own seeds.
    #[arg(long, value_name = "N|LIST", value_parser = parse_seeds)]
    seeds: Option<Seeds>,
    /// Number of times that each case is flown; a state hash that changes is a failure.
    #[arg(long, default_value_t = 1)]
    iterations: usize,
    /// Fly only the cases whose name contains this text.
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// Folder for the evidence of each failed flight: its recording, and a page that opens at the failure.
    #[arg(long, value_name = "FOLDER", default_value = "out/failed")]
    artifacts: PathBuf,
    /// Store the flights as golden runs instead of comparing them.
    #[arg(long)]
    update: bool,
    /// Start no new flight after a failure.
    #[arg(long)]
    fail_fast: bool,
    #[command(flatten)]
    reports: Reports,
    #[command(flatten)]
    overrides: Overrides,
}

#[derive(Args)]
struct MergeArgs {
    /// Output of every shard with --json.
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    #[command(flatten)]
    reports: Reports,
}

/// The files and formats in which the results are reported.
#[derive(Args)]
struct Reports {
    /// Write the results as `JUnit` XML.
    #[arg(long, value_name = "FILE.xml")]
    junit: Option<PathBuf>,
    /// Write the results as a page with links to the replays of failed flights.
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// Print one JSON object instead of a table; `twin test merge` reads that of a shard.
    #[arg(long)]
    json: bool,
}

/// Seeds for every scenario.
#[derive(Clone)]
struct Seeds(Vec<u64>);

fn parse_seeds(text: &str) -> Result<Seeds, String> {
    let refused = || format!("found {text:?}, expected a count such as 20, or a list such as 3,7");
    let numbers: Option<Vec<u64>> =
        text.split(',').filter(|part| !part.is_empty()).map(|part| part.parse().ok()).collect();
    match numbers.ok_or_else(refused)?.as_slice() {
        [] | [0] => Err(refused()),
        [count] if !text.contains(',') => Ok(Seeds((1..=*count).collect())),
        list => Ok(Seeds(list.to_vec())),
    }
}

pub(super) fn run_tests(args: &TestArgs) -> anyhow::Result<End> {
    match &args.merge {
        Some(TestCommand::Merge(args)) => merged(args),
        None => flown(&args.fly),
    }
}

fn flown(args: &FlyTests) -> anyhow::Result<End> {
    let plan = plan(&Selection {
        paths: args.paths.clone(),
        seeds: args.seeds.clone().map_or_else(Vec::new, |seeds| seeds.0),
        iterations: args.iterations,
        filter: args.filter.clone(),
        shard: args.shard,
        overrides: args.overrides.set.clone(),
    })?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let options = Options {
        jobs: args.jobs.unwrap_or(cores),
        fail_fast: args.fail_fast,
        update: args.update,
        evidence: Some(Evidence { folder: args.artifacts.clone(), make_page: Some(replay_page) }),
    };
    let bar = ProgressBar::new(plan.cases.len() as u64).with_style(
        ProgressStyle::with_template(
            "{elapsed_precise} [{wide_bar}] {pos}/{len} flights, {eta} left",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let report = run(&plan, &options, &|result| {
        bar.suspend(|| eprintln!("{}", line(result)));
        bar.inc(1);
    });
    let wall_s = bar.elapsed().as_secs_f64();
    bar.finish_and_clear();
    hand_over(&report, &args.reports, wall_s)
}

/// Writes the replay page of a failed flight, which opens at the failure.
fn replay_page(recording: &Path, page: &Path, report: &Report) -> Result<f64, String> {
    replay::export(recording, page, Some(report)).map_err(|error| error.to_string())
}

fn merged(args: &MergeArgs) -> anyhow::Result<End> {
    let read = |path: &PathBuf| {
        let text = twin_input::file::read_text(path, REPORT_BYTES)
            .with_context(|| format!("{}: cannot be read", path.display()))?;
        let report = serde_json::from_str(&text)
            .with_context(|| format!("{}: not the output of twin test --json", path.display()))?;
        Ok((path.display().to_string(), report))
    };
    let shards = args.shards.iter().map(read).collect::<anyhow::Result<Vec<_>>>()?;
    let report = merge(shards)?;
    let wall_s = report.cases.iter().map(|result| result.wall_s).sum();
    hand_over(&report, &args.reports, wall_s)
}

/// Writes and prints the results, and returns the outcome of the command.
fn hand_over(report: &SuiteReport, wanted: &Reports, wall_s: f64) -> anyhow::Result<End> {
    if let Some(path) = &wanted.junit {
        write(path, &junit::xml(report)?, "--junit")?;
    }
    if let Some(path) = &wanted.html {
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        write(path, &page::html(report, folder, wall_s), "--html")?;
    }
    if wanted.json {
        println!("{}", serde_json::to_string(report)?);
    } else {
        print_table(report, wall_s);
    }
    Ok(match (report.could_not_run, report.failed) {
        (0, 0) => End::Passed,
        (0, _) => End::Failed,
        _ => End::Unusable,
    })
}

fn write(path: &Path, text: &str, flag: &str) -> anyhow::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    std::fs::write(path, text)
        .with_context(|| format!("{}: cannot be written; choose another {flag}", path.display()))
}
