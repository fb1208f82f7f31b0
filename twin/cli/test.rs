//! `twin test`: flies scenarios as tests.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use twin_console::replay;
use twin_input::budget::REPORT_BYTES;
use twin_input::interruption;
use twin_record::output::{Output, Outputs, note};
use twin_scenario::suite::{
    Evidence, Options, Plan, Selection, Shard, SuiteReport, junit, merge, page, plan, run,
};
use twin_scenario::{Report, Scenario};

use super::test_table::{line, print_table};
use super::{End, Overrides, Overwrite, place, print};

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
    /// Folder for the evidence of each failed flight: its recording, and a page that opens at the failure. If they exist, the new ones
    /// are numbered.
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
    /// Write the results as `JUnit` XML; `-` is stdout.
    #[arg(long, value_name = "FILE.xml")]
    junit: Option<PathBuf>,
    /// Write the results as a page with links to the replays of failed flights; `-` is stdout.
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,
    /// Print one JSON object instead of a table; `twin test merge` reads that of a shard.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// The places of the reports, reserved before the first flight.
struct Places {
    outputs: Outputs,
    junit: Option<Output>,
    html: Option<Output>,
}

impl Reports {
    /// Reserves the places; the run reads `inputs`.
    fn reserve(&self, inputs: impl IntoIterator<Item = PathBuf>) -> anyhow::Result<Places> {
        let outputs = self.overwrite.outputs_beside(inputs, self.json)?;
        let junit = place(&outputs, self.junit.as_deref(), "--junit")?;
        let html = place(&outputs, self.html.as_deref(), "--html")?;
        Ok(Places { outputs, junit, html })
    }
}

impl TestArgs {
    /// Whether stdout is to hold one JSON object.
    pub(super) fn prints_json(&self) -> bool {
        self.fly.reports.json
    }
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
    let places = args.reports.reserve(inputs(&plan, args.update))?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let options = Options {
        jobs: args.jobs.unwrap_or(cores),
        fail_fast: args.fail_fast,
        update: args.update,
        evidence: Some(Evidence { folder: args.artifacts.clone(), make_page: Some(replay_page) }),
        outputs: places.outputs.clone(),
    };
    let bar = ProgressBar::new(plan.cases.len() as u64).with_style(
        ProgressStyle::with_template(
            "{elapsed_precise} [{wide_bar}] {pos}/{len} flights, {eta} left",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let report = run(&plan, &options, &|result| {
        bar.suspend(|| note(format_args!("{}", line(result))));
        bar.inc(1);
    });
    let wall_s = bar.elapsed().as_secs_f64();
    bar.finish_and_clear();
    hand_over(&report, places, args.reports.json, wall_s)
}

/// The files that the flights read. A golden run is not one of them if it is to be stored anew.
fn inputs(plan: &Plan, update: bool) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = Vec::new();
    for case in &plan.cases {
        if files.contains(&case.file) {
            continue;
        }
        files.push(case.file.clone());
        // A scenario that cannot be loaded is reported by its flight.
        if let Ok(mut scenario) = Scenario::load(&case.file, &case.overrides) {
            scenario.settings.golden = scenario.settings.golden.filter(|_| !update);
            files.extend(scenario.input_files());
        }
    }
    files
}

/// The replay page of a failed flight, and the time at which it opens: that of the failure.
fn replay_page(recording: &Path, report: &Report) -> Result<(String, f64), String> {
    replay::export(recording, Some(report)).map_err(|error| error.to_string())
}

fn merged(args: &MergeArgs) -> anyhow::Result<End> {
    let read = |path: &PathBuf| {
        let text = twin_input::file::read_text(path, REPORT_BYTES)
            .with_context(|| format!("{}: cannot be read", path.display()))?;
        let report = serde_json::from_str(&text)
            .with_context(|| format!("{}: not the output of twin test --json", path.display()))?;
        Ok((path.display().to_string(), report))
    };
    let places = args.reports.reserve(args.shards.clone())?;
    let shards = args.shards.iter().map(read).collect::<anyhow::Result<Vec<_>>>()?;
    let report = merge(shards)?;
    let wall_s = report.cases.iter().map(|result| result.wall_s).sum();
    hand_over(&report, places, args.reports.json, wall_s)
}

/// Writes and prints the results, and returns the outcome of the command.
fn hand_over(report: &SuiteReport, places: Places, json: bool, wall_s: f64) -> anyhow::Result<End> {
    if let Some(output) = places.junit {
        output.write(junit::xml(report)?.as_bytes())?;
    }
    if let Some(output) = places.html {
        let folder = output.path().parent().unwrap_or_else(|| Path::new("")).to_owned();
        output.write(page::html(report, &folder, wall_s).as_bytes())?;
    }
    print(&places.outputs, |out| {
        if json {
            writeln!(out, "{}", serde_json::to_string(report)?)?;
        } else {
            print_table(out, report, wall_s)?;
        }
        Ok(())
    })?;
    if let (Some(_), Some(signal)) = (&report.verdict, interruption::requested()) {
        return Ok(End::Interrupted(signal));
    }
    Ok(match (report.could_not_run, report.failed) {
        // A shard was interrupted: what is missing may have failed.
        (0, 0) if report.verdict.is_some() => End::Failed,
        (0, 0) => End::Passed,
        (0, _) => End::Failed,
        _ => End::Unusable,
    })
}
