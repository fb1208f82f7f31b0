//! `twin evaluate acceptance`.

use std::path::PathBuf;

use clap::Args;
use twin::notation::ROWS;
use twin::residual::weights::Acceptance;
use twin::scenario::acceptance::{Flown, fly, write};

use super::{End, Overrides};

#[derive(Args)]
pub(super) struct AcceptanceArgs {
    /// File of weights; its head receives the figures.
    weights: PathBuf,
    /// Scenario of the hover.
    #[arg(long, default_value = "scenarios/hover.toml")]
    hover: PathBuf,
    /// Scenario of the figure-8.
    #[arg(long, default_value = "scenarios/free_flight.toml")]
    figure_eight: PathBuf,
    /// Only measure; the file stays as it is.
    #[arg(long)]
    dry_run: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn run(args: &AcceptanceArgs) -> anyhow::Result<End> {
    let flown = [&args.hover, &args.figure_eight]
        .into_iter()
        .map(|scenario| {
            eprintln!("{} without the adapter", scenario.display());
            fly(scenario, &args.weights, &args.overrides.set)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let acceptance = Acceptance { hover_r2: flown[0].figure(), figure_eight_r2: flown[1].figure() };
    if !args.dry_run {
        write(&args.weights, acceptance)?;
    }
    if args.json {
        let accepted = acceptance.passed();
        println!(
            "{}",
            serde_json::json!({
                "weights": args.weights, "accepted": accepted, "acceptance": acceptance, "flights": flown,
            })
        );
    } else {
        flown.iter().for_each(print);
        let words = if acceptance.passed() { "accepted" } else { "not accepted" };
        println!("{words}: {acceptance}, both must be above {}", Acceptance::LEAST_R2);
    }
    Ok(if acceptance.passed() { End::Passed } else { End::Failed })
}

fn print(flown: &Flown) {
    println!("{}: R² {:.3}; {}: {}", flown.scenario, flown.r2, flown.verdict, flown.reason);
    for (row, r2) in ROWS.iter().zip(flown.r2_rows) {
        println!("  {row:5} {r2:7.3}");
    }
}
