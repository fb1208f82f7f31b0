//! `twin evaluate acceptance`: flies trained weights without the adapter and writes the scores into the file of weights.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use twin_core::notation::{COORDINATE_NAMES, N};
use twin_core::residual::weights::Acceptance;
use twin_record::Outputs;
use twin_record::output::note;
use twin_scenario::acceptance::{GateFlight, fly, together, write};

use super::{End, Overrides, print};

#[derive(Args)]
pub(super) struct AcceptanceArgs {
    /// File of weights; the scores are written into its head, so this file is replaced.
    weights: PathBuf,
    /// Scenario of the hover.
    #[arg(long, default_value = "scenarios/hover.toml")]
    hover: PathBuf,
    /// Scenario of the figure-8, with a payload in the gripper.
    #[arg(long, default_value = "scenarios/gate_figure_eight.toml")]
    figure_eight: PathBuf,
    /// Only measure; do not write the scores into the file.
    #[arg(long)]
    dry_run: bool,
    /// Print one JSON object.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn run(args: &AcceptanceArgs) -> anyhow::Result<End> {
    let flown = [&args.hover, &args.figure_eight]
        .into_iter()
        .map(|scenario| {
            note(format_args!("{} without the adapter", scenario.display()));
            fly(scenario, &args.weights, &args.overrides.set)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let both = together(&flown);
    let acceptance = Acceptance {
        r2: both.map(|(mean, _)| mean),
        hover_r2: flown[0].figure(),
        figure_eight_r2: flown[1].figure(),
    };
    if !args.dry_run {
        write(&args.weights, acceptance)?;
    }
    print(&Outputs::default(), |out| {
        if args.json {
            let accepted = acceptance.passed();
            writeln!(
                out,
                "{}",
                serde_json::json!({
                    "weights": args.weights, "accepted": accepted, "acceptance": acceptance, "flights": flown,
                })
            )?;
        } else {
            print_flights(out, &flown, both.map(|(_, rows)| rows))?;
            let words = if acceptance.passed() { "accepted" } else { "not accepted" };
            writeln!(out, "{words}: {acceptance}; R² must be above {}", Acceptance::LEAST_R2)?;
        }
        Ok(())
    })?;
    Ok(if acceptance.passed() { End::Passed } else { End::Failed })
}

fn print_flights(
    out: &mut dyn Write,
    flown: &[GateFlight],
    both: Option<[f64; N]>,
) -> io::Result<()> {
    for flown in flown {
        writeln!(out, "{}: {}: {}", flown.scenario, flown.verdict, flown.reason)?;
    }
    writeln!(
        out,
        "{:20} {:>7}{}",
        "R²",
        "mean",
        COORDINATE_NAMES.map(|row| format!(" {row:>7}")).concat()
    )?;
    let mut line = |name: &str, rows: [f64; N]| {
        let mean = rows.iter().sum::<f64>() / N as f64;
        writeln!(out, "{name:20} {mean:7.3}{}", rows.map(|r2| format!(" {r2:7.3}")).concat())
    };
    for flown in flown {
        line(&flown.scenario, flown.r2_rows)?;
    }
    if let Some(rows) = both {
        line("together", rows)?;
    }
    Ok(())
}
