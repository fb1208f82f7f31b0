//! `twin collect`: flies and records the training flights and the test flight.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use twin_core::notation::{COORDINATE_NAMES, TICK_S};
use twin_input::interruption::{self, Signal};
use twin_record::output::{Outputs, make_folder, note};
use twin_scenario::collect::{
    CollectError, Collected, EXPECTED_STD, Extent, Flight, Plan, Spread, collect,
};
use twin_scenario::{Verdict, side_by_side};

use super::{End, Overrides, Overwrite, print};

#[derive(Args)]
pub(super) struct CollectArgs {
    /// Folder for the recordings and `collect.json`; files of these names in it are refused without --overwrite.
    #[arg(long, value_name = "DIR", default_value = "out/data")]
    out: PathBuf,
    /// Length of each flight, s.
    #[arg(long, default_value_t = 300.0, value_parser = parse_seconds)]
    seconds: f64,
    /// Collect the paper's flights alone: 5 min of plain PID with each payload, without the flights of the adaptive controller.
    #[arg(long)]
    paper: bool,
    /// Collect other flights instead: those in which the controller compensates what these weights forecast. A model that is trained on
    /// them, too, knows how the vehicle moves under its own forecasts.
    #[arg(long, value_name = "FILE.safetensors", conflicts_with = "paper")]
    with: Option<PathBuf>,
    /// Payloads in the gripper, g; each gives one of the paper's training flights.
    #[arg(long, value_delimiter = ',', default_value = "0,200,400", value_parser = clap::value_parser!(u32).range(0..=1000))]
    payloads: Vec<u32>,
    /// Seed of the first flight; each further flight has the next seed.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Flights at a time [default: one per core].
    #[arg(long)]
    jobs: Option<usize>,
    /// Folder with `collect_*.toml` and `test_300g.toml`.
    #[arg(long, value_name = "DIR", default_value = "scenarios")]
    scenarios: PathBuf,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    overrides: Overrides,
}

/// Name of the manifest; flights that are collected later into the same folder get their own.
fn manifest_name(args: &CollectArgs) -> &'static str {
    if args.with.is_some() { "collect_foreseen.json" } else { "collect.json" }
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (5.0..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err(format!("found {text:?}, expected 5..=3600 s")),
    }
}

fn extent(args: &CollectArgs) -> anyhow::Result<Extent> {
    Ok(match &args.with {
        // A scenario resolves the path of the weights relative to itself, so the path is made absolute.
        Some(file) => Extent::Foreseen(
            std::fs::canonicalize(file).with_context(|| file.display().to_string())?,
        ),
        None if args.paper => Extent::Paper,
        None => Extent::All,
    })
}

pub(super) fn run(args: &CollectArgs) -> anyhow::Result<End> {
    let plan = Plan {
        scenarios: args.scenarios.clone(),
        out: args.out.clone(),
        extent: extent(args)?,
        payloads_g: args.payloads.clone(),
        seconds: args.seconds,
        seed: args.seed,
        overrides: args.overrides.set.clone(),
    };
    let flights = plan.flights()?;
    let inputs = flights.iter().flat_map(|flight| flight.scenario.input_files());
    let outputs = args.overwrite.outputs_beside(inputs, args.json)?;
    make_folder(&args.out, "--out")?;
    let table = outputs.reserve(&args.out.join(manifest_name(args)), "--out")?;
    for flight in &flights {
        outputs.may_write(&flight.file, "--out")?;
    }
    let threads =
        args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let collected = fly(&flights, &outputs, threads, args.seconds);
    if let Some(signal) = interruption::requested() {
        return interrupted((args, &outputs), &flights, collected, signal);
    }
    let collected = collected.into_iter().collect::<Result<Vec<_>, _>>()?;
    let training: Vec<Spread> = collected
        .iter()
        .filter(|flight| flight.scenario.starts_with("collect_"))
        .map(|flight| flight.residual)
        .collect();
    let together = Spread::together(&training);
    let manifest = serde_json::json!({
        "table": "collect",
        "flights": collected,
        "residual_training": together,
        "residual_std_expected": EXPECTED_STD,
    });
    table.write(format!("{manifest:#}\n").as_bytes())?;
    print(&outputs, |out| {
        if args.json {
            writeln!(out, "{manifest}")?;
        } else {
            print_table(out, &collected, &together)?;
        }
        Ok(())
    })?;
    Ok(if collected.iter().all(Collected::usable) { End::Passed } else { End::Failed })
}

/// Reports the flights that were begun before the signal; their recordings are finished. The table of all flights is not written.
fn interrupted(
    (args, outputs): (&CollectArgs, &Outputs),
    flights: &[Flight],
    collected: Vec<Result<Collected, CollectError>>,
    signal: Signal,
) -> anyhow::Result<End> {
    let mut begun = Vec::new();
    for flight in collected {
        match flight {
            Ok(flight) => begun.push(flight),
            Err(CollectError::Interrupted(_)) => {}
            Err(error) => return Err(error.into()),
        }
    }
    for flight in &begun {
        note(format_args!("{}: {}: {}", flight.file.display(), flight.verdict, flight.reason));
    }
    note(format_args!(
        "{} of {} flights were not begun",
        flights.len() - begun.len(),
        flights.len()
    ));
    if args.json {
        let found = serde_json::json!({
            "table": "collect",
            "verdict": Verdict::Interrupted,
            "reason": signal.to_string(),
            "flights": begun,
            "not_begun": flights.len() - begun.len(),
        });
        print(outputs, |out| Ok(writeln!(out, "{found}")?))?;
    }
    Ok(End::Interrupted(signal))
}

fn fly(
    flights: &[Flight],
    outputs: &Outputs,
    threads: usize,
    seconds: f64,
) -> Vec<Result<Collected, CollectError>> {
    let ticks = (seconds / TICK_S) as u64 * flights.len() as u64;
    let bar = ProgressBar::new(ticks).with_style(
        ProgressStyle::with_template(
            "{elapsed_precise} [{wide_bar}] {pos}/{len} ticks, {eta} left  {msg}",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let collected =
        side_by_side(flights, threads, &|flight| collect(flight, outputs, &|ticks| bar.inc(ticks)));
    bar.finish_and_clear();
    collected
}

fn print_table(out: &mut dyn Write, collected: &[Collected], together: &Spread) -> io::Result<()> {
    writeln!(
        out,
        "{:28} {:>5} {:>6} {:>7}  {:10} {:>8} {:>7} {:>6} {:>8}  {:16}  sha-256 of the recording",
        "flight",
        "seed",
        "kg",
        "ticks",
        "verdict",
        "e_pos m",
        "tilt °",
        "sat %",
        "contacts",
        "state hash"
    )?;
    for flight in collected {
        writeln!(
            out,
            "{:28} {:>5} {:>6.3} {:>7}  {:10} {:>8.3} {:>7.1} {:>6.2} {:>8}  {:16}  {}",
            flight.scenario,
            flight.seed,
            flight.payload_kg,
            flight.ticks,
            flight.verdict.to_string(),
            flight.position_rmse_m,
            flight.tilt_peak_rad.to_degrees(),
            flight.saturation_share * 100.0,
            flight.contact_ticks,
            flight.state_hash,
            &flight.sha256,
        )?;
        if !flight.usable() {
            note(format_args!("{}: not usable for training: {}", flight.scenario, flight.reason));
        }
    }
    writeln!(
        out,
        "\nresidual std, N and N m      {}",
        COORDINATE_NAMES.map(|row| format!("{row:>7}")).join("")
    )?;
    let mut line = |name: &str, values: &[f64]| {
        let cells: Vec<String> = values.iter().map(|value| format!("{value:7.3}")).collect();
        writeln!(out, "{name:28} {}", cells.concat())
    };
    for flight in collected {
        line(&flight.scenario, flight.residual.std.as_slice())?;
    }
    line("training flights together", together.std.as_slice())?;
    line("control study, expected", &EXPECTED_STD)?;
    line("mean, training together", together.mean.as_slice())
}
