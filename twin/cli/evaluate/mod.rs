//! `twin evaluate`.

mod output;
mod prediction;
mod tracking;
mod ablation;
mod pickup;
mod l1;

use clap::{Args, Subcommand};

use super::End;

#[derive(Args)]
pub(super) struct EvaluateArgs {
    #[command(subcommand)]
    table: Table,
}

#[derive(Subcommand)]
enum Table {
    /// How well residuals are forecast: a recording replayed through every predictor, a priori, beside the paper's table.
    Prediction(prediction::PredictionArgs),
    /// Full pick, carry and place in all eight scenarios: methods, presets and seeds beside the paper's table.
    Tracking(tracking::TrackingArgs),
    /// How well the FDT predicts without one of its parts, beside the paper's table.
    Ablation(ablation::AblationArgs),
    /// What happens when the load changes: innovation, resets, recovery, with the adapter, without it, and without its reset.
    Pickup(pickup::PickupArgs),
    /// Sweep of what the L1 row depends on: pole and corners of its low-pass.
    L1(l1::L1Args),
    /// Fly trained weights without the adapter and write how well they predict then into their file; exit 0 if accepted.
    Acceptance(super::acceptance::AcceptanceArgs),
}

pub(super) fn run(args: &EvaluateArgs) -> anyhow::Result<End> {
    match &args.table {
        Table::Prediction(args) => prediction::run(args),
        Table::Tracking(args) => tracking::run(args),
        Table::Ablation(args) => ablation::run(args),
        Table::Pickup(args) => pickup::run(args),
        Table::L1(args) => l1::run(args),
        Table::Acceptance(args) => super::acceptance::run(args),
    }
}

/// Keys that fly a scenario's path with the payload in hand from the start, and nothing else of its mission.
const PATH_ALONE: [&str; 2] = ["task.kind=path", "task.start=grasped"];

/// The command line as it was given, to make a table again.
fn command() -> String {
    let mut words: Vec<String> = std::env::args().collect();
    if let Some(program) = words.first_mut() {
        "twin".clone_into(program);
    }
    words.join(" ")
}
