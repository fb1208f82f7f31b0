//! `twin evaluate pickup`: the response to a change of the payload.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use twin_lab::evaluate::Sheet;
use twin_lab::evaluate::pickup::{MODES, PickupFlight, pick_up, pictures};
use twin_scenario::{Scenario, side_by_side};

use super::output::{Output, inputs_of};
use crate::cli::{End, Overrides, print};

#[derive(Args)]
pub(super) struct PickupArgs {
    /// Scenario files [default: the slow figure-8 with 300 and 500 g, and the demonstration of a reset].
    scenarios: Vec<PathBuf>,
    /// Flights at a time [default: one per core].
    #[arg(long)]
    jobs: Option<usize>,
    #[command(flatten)]
    pub(super) output: Output,
    #[command(flatten)]
    overrides: Overrides,
}

const DEFAULT: [&str; 3] = ["b_300g_slow", "b_500g_slow", "reset_demo"];

pub(super) fn run(args: &PickupArgs) -> anyhow::Result<End> {
    let files: Vec<PathBuf> = if args.scenarios.is_empty() {
        DEFAULT.iter().map(|name| PathBuf::from(format!("scenarios/{name}.toml"))).collect()
    } else {
        args.scenarios.clone()
    };
    let places = args.output.reserve(inputs_of(&files))?;
    let mut jobs = Vec::new();
    for file in &files {
        for (mode, keys) in MODES {
            let mut overrides = args.overrides.set.clone();
            overrides.extend(keys.iter().map(|key| (*key).to_owned()));
            jobs.push((mode, Scenario::load(file, &overrides)?));
        }
    }
    let threads =
        args.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let flown = side_by_side(&jobs, threads, &|(mode, scenario)| pick_up(scenario, mode));
    let flown = flown.into_iter().collect::<Result<Vec<PickupFlight>, _>>()?;
    let mut sheet = Sheet::new(HEAD);
    sheet.rows.extend(flown.iter().map(|flown| cells(flown).to_vec()));
    let outputs = places.write_pictures("When the load changes", &sheet, || {
        let pictures = flown.chunks(MODES.len()).flat_map(pictures);
        Ok(pictures.map(|picture| picture.svg()).collect())
    })?;
    print(&outputs, |out| {
        if args.output.json {
            let command = super::command();
            let value =
                serde_json::json!({ "table": "pickup", "command": command, "flights": flown });
            writeln!(out, "{value}")?;
        } else {
            print_table(out, &flown)?;
        }
        Ok(())
    })?;
    Ok(if flown.iter().all(|flown| flown.at_s.is_some()) { End::Passed } else { End::Failed })
}

fn cells(flown: &PickupFlight) -> [String; 8] {
    let seconds =
        |value: Option<f64>| value.map_or_else(|| "never".to_owned(), |v| format!("{v:.2}"));
    [
        flown.scenario.clone(),
        flown.mode.to_owned(),
        flown.verdict.to_string(),
        seconds(flown.at_s),
        format!("{:.2}/{:.1}", flown.innovation_peak, flown.threshold),
        flown.resets_s.len().to_string(),
        seconds(flown.recovery_s),
        format!("{:.3}", flown.error_peak_m),
    ]
}

const HEAD: [&str; 8] =
    ["scenario", "mode", "verdict", "load at s", "peak/δ", "resets", "recovery s", "e_pos peak m"];

fn print_table(out: &mut dyn Write, flown: &[PickupFlight]) -> io::Result<()> {
    let mut line = |cells: [&str; 8]| {
        let [scenario, mode, rest @ ..] = cells;
        let rest: Vec<String> = rest.iter().map(|cell| format!(" {cell:>13}")).collect();
        writeln!(out, "{scenario:14} {mode:15}{}", rest.concat())
    };
    line(HEAD)?;
    for flown in flown {
        let cells = cells(flown);
        line(std::array::from_fn(|i| cells[i].as_str()))?;
    }
    writeln!(out, "\n{}", super::command())
}
