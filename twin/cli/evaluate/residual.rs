//! `twin evaluate residual`: what the residual consists of, and whether a long window foresees it better.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use twin_lab::evaluate::Sheet;
use twin_lab::evaluate::residual::{Measured, Plan, ResidualTable, Variant, measure, pictures};
use twin_record::output::note;
use twin_scenario::{Scenario, Verdict, side_by_side};

use super::output::{Output, inputs_of};
use crate::cli::{End, Overrides, print};

#[derive(Args)]
#[command(after_help = HELP)]
pub(super) struct ResidualArgs {
    /// Scenarios of training flights.
    #[arg(default_values = DEFAULT)]
    scenarios: Vec<PathBuf>,
    /// Length of each flight, s.
    #[arg(long, default_value_t = 300.0, value_parser = parse_seconds)]
    seconds: f64,
    /// Seeds 1..=N of each scenario; the last third of them, at least one, scores the forecasts and fits nothing.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u64).range(2..=100))]
    seeds: u64,
    /// Variants at a time [default: one per core].
    #[arg(long)]
    jobs: Option<usize>,
    #[command(flatten)]
    pub(super) output: Output,
    #[command(flatten)]
    overrides: Overrides,
}

const DEFAULT: [&str; 3] =
    ["scenarios/collect_0g.toml", "scenarios/collect_200g.toml", "scenarios/collect_400g.toml"];

const HELP: &str = "Example:
  twin evaluate residual --html residual.html       all effects, 3 payloads, 3 seeds, 5 min each
  twin evaluate residual scenarios/collect_0g.toml --seconds 60 --seeds 2     a quick look

Each scenario is flown with every effect on, with each effect off in turn, and with every effect off, always with the same seeds. An \
effect is off from 0 s on. The first 2 s of a flight count for nothing.

Bands: the discrete Fourier transform of a whole flight splits the variance of r about the mean of that flight into < 0.5 Hz, 0.5-2 Hz \
and > 2 Hz; the bands add up to the variance. The mean of a flight, such as the weight of a payload, belongs to no band.

Shares: 1 - var(off)/var(on) of each coordinate and band, where var(off) comes from the flights without the effect. The closed loop flies \
differently without an effect, so a share can be negative, and shares need not add up to one. Effects are in the order of the mean over \
the coordinates; ± is its standard deviation over the flights.

Forecasts of r(t + h), h = 0, 60, 100, 200 ms, made at the tick t before r(t) is known: 0 ms is one tick after the newest r. The models \
are the newest r (persistence), and ridge regressions on the last 10 and on the last 120 ticks of the channels of the network (chi \
without x, y and psi, chi_dot, tau) and of r. Beyond the newest 10 ticks the long window holds means of 5 ticks. The last fifth of each \
training flight chooses the ridge. Errors are RMSE over coordinates and time, in standard deviations of r with everything on.";

fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (10.0..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err(format!("found {text:?}, expected 10..=3600 s")),
    }
}

pub(super) fn run(args: &ResidualArgs) -> anyhow::Result<End> {
    let places = args.output.reserve(inputs_of(&args.scenarios))?;
    let plan = plan(args)?;
    let threads =
        args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let (on, others) = measure_all(&plan, threads)?;
    let table = ResidualTable::new(super::command(), &on, others);
    let page = || {
        let sheets = table.sheets();
        let sheet = |(title, sheet): &(String, Sheet)| {
            format!("<h2>{}</h2>{}", twin_scenario::markup::escaped(title), sheet.html())
        };
        let conclusion = format!("<p>{}</p>", table.conclusion);
        let body = conclusion + &sheets.iter().map(sheet).collect::<String>() + &pictures(&table);
        Ok(twin_lab::evaluate::pictures_page("The residual", &body, &table.command))
    };
    let outputs = places.write(&table.sheet(), page)?;
    print(&outputs, |out| {
        if args.output.json {
            writeln!(out, "{}", serde_json::to_string(&table)?)?;
        } else {
            print_table(out, &table)?;
        }
        Ok(())
    })?;
    let unfinished = table.flights.iter().filter(|f| f.verdict != Verdict::Completed);
    let unfinished = unfinished.map(|f| {
        note(format_args!(
            "{}, {} seed {}: {}: {}",
            f.variant.words(),
            f.scenario,
            f.seed,
            f.verdict,
            f.reason
        ));
    });
    Ok(if unfinished.count() == 0 { End::Passed } else { End::Failed })
}

/// The flights of the training with the first seeds, those of the test with the last ones.
fn plan(args: &ResidualArgs) -> anyhow::Result<Plan> {
    let mut plan = Plan::default();
    let first_test = args.seeds - (args.seeds / 3).max(1) + 1;
    for seed in 1..=args.seeds {
        for file in &args.scenarios {
            let mut overrides = args.overrides.set.clone();
            overrides
                .extend([format!("seed={seed}"), format!("task.duration_s={:?}", args.seconds)]);
            let scenario = Scenario::load(file, &overrides)?;
            let part = if seed < first_test { &mut plan.training } else { &mut plan.test };
            part.push(scenario);
        }
    }
    Ok(plan)
}

/// Measures every variant, and returns the one with everything on apart from the others.
fn measure_all(plan: &Plan, threads: usize) -> anyhow::Result<(Measured, Vec<Measured>)> {
    let variants = Variant::all();
    let bar = ProgressBar::new((variants.len() * plan.steps()) as u64).with_style(
        ProgressStyle::with_template(
            "{elapsed_precise} [{wide_bar}] {pos}/{len} flights and fits, {eta} left",
        )
        .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    let measured =
        side_by_side(&variants, threads, &|variant| measure(plan, *variant, &|| bar.inc(1)));
    bar.finish_and_clear();
    let mut measured = measured.into_iter().collect::<Result<Vec<Measured>, _>>()?;
    let on = measured.remove(0);
    Ok((on, measured))
}

fn print_table(out: &mut dyn Write, table: &ResidualTable) -> io::Result<()> {
    for (title, sheet) in table.sheets() {
        writeln!(out, "{title}")?;
        print_sheet(out, &sheet)?;
        writeln!(out)?;
    }
    if let Some(on) = table.foresight.first() {
        let [fitted, scored] = on.samples;
        let ridge = on.ridge.map_or_else(
            || "none".to_owned(),
            |[short, long]| format!("{short:e} with 10 ticks, {long:e} with 120 ticks"),
        );
        writeln!(
            out,
            "everything on: fitted to {fitted} windows, scored on {scored}, ridge {ridge}"
        )?;
    }
    writeln!(out, "{}\n\n{}", table.conclusion, table.command)
}

/// Prints a sheet with aligned columns, the first one to the left.
fn print_sheet(out: &mut dyn Write, sheet: &Sheet) -> io::Result<()> {
    let lines = || std::iter::once(&sheet.head).chain(&sheet.rows);
    let width = |column: usize| lines().map(|cells| cells[column].chars().count()).max();
    let widths: Vec<usize> = (0..sheet.head.len()).filter_map(width).collect();
    for cells in lines() {
        for (column, (cell, width)) in cells.iter().zip(&widths).enumerate() {
            let cell = if cell.is_empty() { "-" } else { cell };
            if column == 0 {
                write!(out, "{cell:width$}")?;
            } else {
                write!(out, "  {cell:>width$}")?;
            }
        }
        writeln!(out)?;
    }
    Ok(())
}
