//! `twin fly`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::Args;
use twin_console::server::{AppOrigin, Limits, ServeOptions, serve};
use twin_core::quantity;
use twin_input::interruption;
use twin_record::output::note;
use twin_record::{Outputs, Recorder, RecordingEnd, RecordingStatus};
use twin_scenario::run::event_lines;
use twin_scenario::{Report, Scenario, Verdict, fly_until_signal};

use super::orders::Orders;
use super::{End, Overwrite, default_scenario, print};

#[derive(Args, Clone)]
#[allow(clippy::struct_excessive_bools, reason = "each is a flag of the command line")]
pub(super) struct FlyArgs {
    /// Scenario file [default: `scenarios/a_300g_slow.toml`].
    scenario: Option<PathBuf>,
    /// No server: fly as fast as the machine can, print the verdict, exit 0 if it is the expected one.
    #[arg(long)]
    headless: bool,
    /// Print exactly one JSON object on stdout (with --headless).
    #[arg(long, requires = "headless")]
    pub(super) json: bool,
    /// Seed instead of the scenario's.
    #[arg(long)]
    seed: Option<u64>,
    /// Record the flight as MCAP (opens in Foxglove, Lichtblick, Rerun and PlotJuggler), and its forks beside it as FILE-fork-1.mcap, ….
    /// If the file exists, the recording goes to FILE-2.mcap, FILE-3.mcap, … If the disk fails, the flight goes on, and the exit code is 1; `twin recover` finishes the file.
    #[arg(long, value_name = "FILE.mcap")]
    pub(super) record: Option<PathBuf>,
    /// Simulated seconds per second, or `max`.
    #[arg(long, default_value = "1", conflicts_with = "headless", value_parser = parse_speed)]
    speed: Speed,
    /// Port of the console; 0 takes any free one.
    #[arg(long, default_value_t = 8080, conflicts_with = "headless")]
    port: u16,
    /// Address to listen on; loopback only.
    #[arg(long, default_value = "127.0.0.1", conflicts_with = "headless")]
    host: String,
    /// Wait for an operator before the first tick.
    #[arg(long, conflicts_with = "headless")]
    start_paused: bool,
    /// Folder of the stock viewers [default: where `twin viewers fetch` puts them].
    #[arg(long, value_name = "DIR", conflicts_with = "headless")]
    viewer_dir: Option<PathBuf>,
    /// Fly trained weights that were not accepted in closed loop (`predictor.force`).
    #[arg(long)]
    force_weights: bool,
    /// Serve Foxglove on this port too (8765 is its default), for watching and for setting gains. Foxglove, Lichtblick, their desktop
    /// programs, pages of this machine, and programs may connect.
    #[arg(long, value_name = "PORT", conflicts_with = "headless")]
    foxglove_port: Option<u16>,
    /// Another page that may use the port for Foxglove, such as your own Lichtblick; may be given more than once.
    #[arg(long, value_name = "https://HOST[:PORT]", requires = "foxglove_port")]
    foxglove_origin: Vec<AppOrigin>,
    #[command(flatten)]
    pub(super) overwrite: Overwrite,
    /// Write the scenario that repeats the fork, or with several forks one file for each (with --fork-at).
    #[arg(long, value_name = "FILE.toml", requires = "fork_at")]
    pub(super) scenario_out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) orders: Orders,
}

/// Simulated seconds per second; `None` flies as fast as the machine can.
#[derive(Clone, Copy)]
pub(super) struct Speed(pub(super) Option<f64>);

pub(super) fn parse_speed(text: &str) -> Result<Speed, String> {
    if text == "max" {
        return Ok(Speed(None));
    }
    match text.parse::<f64>() {
        Ok(speed) if quantity::SPEED.allows(speed) => Ok(Speed(Some(speed))),
        _ => Err(format!("found {text:?}, expected {} or max", quantity::SPEED.range())),
    }
}

/// The file of the scenario that the flags name, and the scenario.
pub(super) fn scenario(args: &FlyArgs) -> anyhow::Result<(PathBuf, Scenario)> {
    let file = args.scenario.clone().unwrap_or_else(default_scenario);
    if args.scenario.is_none() && !file.exists() {
        anyhow::bail!(
            "no scenario named and {} is not here; name a scenario file, or run twin in the folder of its repository",
            file.display()
        );
    }
    let mut overrides = args.orders.set.clone();
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    overrides.extend(args.force_weights.then(|| "predictor.force=true".to_owned()));
    let scenario = Scenario::load(&file, &overrides)?;
    Ok((file, scenario))
}

pub(super) fn run(args: &FlyArgs) -> anyhow::Result<End> {
    let (file, scenario) = scenario(args)?;
    if args.headless {
        return headless(&scenario, args);
    }
    let catalogue = catalogue(&file, &args.orders.set);
    let outputs = args.overwrite.outputs();
    outputs.protect(catalogue.iter().map(|known| &known.file));
    let served = serve(ServeOptions {
        catalogue,
        scenario,
        host: args.host.clone(),
        port: args.port,
        speed: args.speed.0,
        start_paused: args.start_paused,
        record: args.record.clone(),
        outputs,
        viewer_dir: args.viewer_dir.clone().or_else(super::viewers::default_folder),
        foxglove_port: args.foxglove_port,
        foxglove_origins: args.foxglove_origin.clone(),
        limits: Limits::STANDARD,
    })?;
    Ok(if served.recordings_whole { End::Interrupted(served.signal) } else { End::Failed })
}

/// Usable scenarios in the folder of `file`, by name: a restart chooses from them.
fn catalogue(file: &Path, overrides: &[String]) -> Vec<Scenario> {
    let folder = file
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or_else(|| Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .filter(|path| path.file_stem().is_some_and(|stem| stem != "defaults"))
        .collect();
    files.sort();
    files.iter().filter_map(|path| Scenario::load(path, overrides).ok()).collect()
}

/// Flies to the end, with events on stderr as they happen and the verdict on stdout.
fn headless(scenario: &Scenario, args: &FlyArgs) -> anyhow::Result<End> {
    #[allow(
        clippy::disallowed_methods,
        reason = "the real-time factor needs a clock; the flight does not see it"
    )]
    let started = std::time::Instant::now();
    let outputs = args.overwrite.outputs();
    let mut recorder = record(scenario, args, &outputs)?;
    let mut report = fly_until_signal(scenario, &mut |tick| {
        if !args.json {
            event_lines(tick).for_each(|line| note(format_args!("{line}")));
        }
        if let Some(recorder) = &mut recorder {
            // A recording that fails does not end the flight; its status tells below.
            let _ = recorder.record(Arc::new(tick.clone()));
        }
    })
    .with_context(|| scenario.file.display().to_string())?;
    let recording = match recorder {
        Some(recorder) => Some(recorder.close(RecordingEnd {
            state_hash: u64::from_str_radix(&report.state_hash, 16)?,
            verdict: format!("{}: {}", report.verdict, report.reason),
        })),
        None => None,
    };
    report.real_time_factor = Some(report.flight_s / started.elapsed().as_secs_f64().max(1e-9));
    let is_recorded = recording.as_ref().is_none_or(told);
    print(&outputs, |out| {
        if args.json {
            let flown = Flown { report: &report, recording: recording.as_ref() };
            writeln!(out, "{}", serde_json::to_string(&flown)?)?;
        } else {
            print_report(out, &report)?;
        }
        Ok(())
    })?;
    if !is_recorded {
        return Ok(End::Failed);
    }
    Ok(match (interruption::requested(), report.passed) {
        (Some(signal), _) if report.verdict == Verdict::Interrupted => End::Interrupted(signal),
        (_, true) => End::Passed,
        (_, false) => End::Failed,
    })
}

/// What a flight and its recording came to, for `--json`.
#[derive(serde::Serialize)]
struct Flown<'a> {
    #[serde(flatten)]
    report: &'a Report,
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<&'a RecordingStatus>,
}

/// Says how a recording went; returns whether it is whole.
pub(super) fn told(recording: &RecordingStatus) -> bool {
    match &recording.error {
        None => note(format_args!("{} ticks recorded", recording.ticks)),
        Some(error) => note(format_args!("error: {error}")),
    }
    recording.error.is_none()
}

/// Starts the recording that the flags ask for, and tells its name if it is another than they gave.
fn record(
    scenario: &Scenario,
    args: &FlyArgs,
    outputs: &Outputs,
) -> anyhow::Result<Option<Recorder>> {
    let Some(path) = &args.record else { return Ok(None) };
    recorder(scenario, path, outputs).map(Some)
}

/// Starts a recording of `scenario` at `path`, and tells its name if it is another.
pub(super) fn recorder(
    scenario: &Scenario,
    path: &Path,
    outputs: &Outputs,
) -> anyhow::Result<Recorder> {
    let info = scenario.recording_info(&scenario.tuning()?)?;
    outputs.protect(scenario.input_files());
    let file = outputs.recording(path, "--record")?;
    if let Some(renamed) = file.renamed() {
        note(renamed);
    }
    let recorder = Recorder::start(file, &info)?;
    Ok(recorder.for_flight_of(scenario.settings.planned_s()))
}

pub(super) fn print_report(out: &mut dyn Write, report: &Report) -> std::io::Result<()> {
    let factor = report.real_time_factor.map(|factor| format!(", {factor:.1} x real time"));
    writeln!(
        out,
        "{} (seed {}): {:?}: {}",
        report.scenario, report.seed, report.verdict, report.reason
    )?;
    writeln!(
        out,
        "  {:.1} s flown{}, state hash {}, kernel {}",
        report.flight_s,
        factor.unwrap_or_default(),
        report.state_hash,
        report.kernel
    )?;
    for (name, value) in &report.metrics {
        writeln!(out, "  {name:28} {value:10.4}")?;
    }
    for broken in &report.broken {
        writeln!(out, "  BROKEN: {broken}")?;
    }
    Ok(())
}
