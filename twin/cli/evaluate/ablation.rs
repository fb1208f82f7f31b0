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
    /// Weights trained without the linear path: `twin train --architecture paper`.
    #[arg(long, value_name = "FILE")]
    without_skip: Option<PathBuf>,
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

impl AblationArgs {
    /// The file of each of [`VARIANTS`], in their order; `None` where the command names none.
    fn files(&self) -> [Option<&PathBuf>; VARIANTS.len()] {
        [
            Some(&self.full),
            Some(&self.full),
            self.without_global_token.as_ref(),
            self.without_short_horizon.as_ref(),
            self.without_long_memory.as_ref(),
            self.without_skip.as_ref(),
        ]
    }
}

pub(super) fn run(args: &AblationArgs) -> anyhow::Result<End> {
    let files = args.files();
    let weights = files.into_iter().flatten().cloned();
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
    let mut rows: Vec<Variant> = Vec::new();
    for ((name, paper), file) in VARIANTS.into_iter().zip(files) {
        let Some(file) = file else { continue };
        let weights = read_weights(file)?;
        let (by_horizon, r2) = measure(name, (&weights, file), &scenario, &flights, &statistics)?;
        let rmse_z = by_horizon.first().copied().unwrap_or(f64::NAN);
        let change = |value: f64, full: f64| (value / full - 1.0) * 100.0;
        let reference = rows.first().map_or(rmse_z, |row| row.rmse_z);
        rows.push(Variant {
            name: name.to_owned(),
            weights: file.clone(),
            rmse_z,
            rmse_z_by_horizon: by_horizon,
            r2,
            delta_percent: change(rmse_z, reference),
            paper: paper.zip(VARIANTS[0].1).map(|(paper, full)| [paper, change(paper, full)]),
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
            let paper = row.paper.map_or_else(
                || format!("{:>8} {:>8}", "-", "-"),
                |[rmse, change]| format!("{rmse:8.3} {change:+8.1}"),
            );
            writeln!(
                out,
                "{:24} {:8.3} {:8.3} {:+8.1}   {paper}",
                row.name, row.rmse_z, row.r2, row.delta_percent
            )?;
        }
        writeln!(out, "\n{}", super::command())?;
    }
    Ok(())
}
