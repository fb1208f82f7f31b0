//! `twin evaluate ablation`: the ablation table.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use twin_lab::evaluate::ablation::{
    VARIANTS, Variant, flown, measure, over_horizon, sheet, statistics,
};
use twin_record::output::note;
use twin_scenario::Scenario;

use super::output::{Output, inputs_of};
use crate::cli::{End, Overrides, print, read_weights};

#[derive(Args)]
pub(super) struct AblationArgs {
    /// Weights of the full model; they give two lines, with and without the adapter.
    #[arg(long, value_name = "FILE")]
    full: PathBuf,
    /// Weights trained without the global token.
    #[arg(long, value_name = "FILE")]
    without_global_token: Option<PathBuf>,
    /// Weights trained without the short horizon.
    #[arg(long, value_name = "FILE")]
    without_short_horizon: Option<PathBuf>,
    /// Weights trained without the long memory.
    #[arg(long, value_name = "FILE")]
    without_long_memory: Option<PathBuf>,
    /// Scenario that the full model flies; the paper's is B with 500 g at 1 m/s.
    #[arg(long, value_name = "FILE", default_value = "scenarios/b_500g_fast.toml")]
    scenario: PathBuf,
    /// Seeds 1..=N.
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    #[command(flatten)]
    pub(super) output: Output,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn run(args: &AblationArgs) -> anyhow::Result<End> {
    let parts =
        [&args.without_global_token, &args.without_short_horizon, &args.without_long_memory];
    let weights = parts.into_iter().flatten().chain([&args.full]).cloned();
    let places = args.output.reserve(weights.chain(inputs_of([&args.scenario])))?;
    let full = read_weights(&args.full)?;
    let whole = std::fs::canonicalize(&args.full)?;
    let mut flights = Vec::new();
    let mut scenario = None;
    for seed in 1..=args.seeds {
        let mut overrides = vec![
            "predictor.kind=fdt".to_owned(),
            format!("predictor.weights={}", whole.display()),
            format!("seed={seed}"),
        ];
        overrides.extend(args.overrides.set.iter().cloned());
        let loaded = Scenario::load(&args.scenario, &overrides)?;
        note(format_args!("flying {} seed {seed}", loaded.name));
        let (series, report) = flown(&loaded)?;
        note(format_args!("{} seed {seed}: {}: {}", loaded.name, report.verdict, report.reason));
        flights.push(series);
        scenario = Some(loaded);
    }
    let scenario = scenario.context("--seeds 0: there is nothing to fly")?;
    let statistics = statistics(&full);
    let files = [
        Some(&args.full),
        Some(&args.full),
        args.without_global_token.as_ref(),
        args.without_short_horizon.as_ref(),
        args.without_long_memory.as_ref(),
    ];
    let mut rows: Vec<Variant> = Vec::new();
    for ((name, paper), file) in VARIANTS.into_iter().zip(files) {
        let Some(file) = file else { continue };
        let weights = read_weights(file)?;
        let (by_horizon, r2) = measure(name, (&weights, file), &scenario, &flights, &statistics)?;
        let rmse_z = by_horizon[0];
        let change = |value: f64, full: f64| (value / full - 1.0) * 100.0;
        let reference = rows.first().map_or(rmse_z, |row| row.rmse_z);
        rows.push(Variant {
            name: name.to_owned(),
            weights: file.clone(),
            rmse_z,
            rmse_z_by_horizon: by_horizon,
            r2,
            delta_percent: change(rmse_z, reference),
            paper: [paper, change(paper, VARIANTS[0].1)],
        });
    }
    let outputs =
        places.write_pictures("The FDT without one of its parts", &sheet(&rows), || {
            Ok(over_horizon(&rows).svg())
        })?;
    print(&outputs, |out| Ok(print_rows(out, args, &rows)?))?;
    Ok(End::Passed)
}

fn print_rows(out: &mut dyn Write, args: &AblationArgs, rows: &[Variant]) -> io::Result<()> {
    if args.output.json {
        let command = super::command();
        writeln!(
            out,
            "{}",
            serde_json::json!({ "table": "ablation", "command": command, "rows": rows })
        )?;
    } else {
        writeln!(
            out,
            "{:24} {:>8} {:>8} {:>8}   {:>8} {:>8}",
            "a priori, z-scored", "RMSE", "R²", "Δ %", "paper", "Δ %"
        )?;
        for row in rows {
            writeln!(
                out,
                "{:24} {:8.3} {:8.3} {:+8.1}   {:8.3} {:+8.1}",
                row.name, row.rmse_z, row.r2, row.delta_percent, row.paper[0], row.paper[1]
            )?;
        }
        writeln!(out, "\n{}", super::command())?;
    }
    Ok(())
}
