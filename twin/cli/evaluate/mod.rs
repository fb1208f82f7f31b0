//! `twin evaluate`: the tables of the paper.

mod output;
mod prediction;
mod tracking;
mod ablation;
mod pickup;
mod l1;
mod plant;
mod residual;

use clap::{Args, Subcommand};

use super::End;

#[derive(Args)]
pub(super) struct EvaluateArgs {
    #[command(subcommand)]
    table: Table,
}

#[derive(Subcommand)]
enum Table {
    /// Accuracy of the forecasts: replay a recording through every predictor, a priori, and compare with the paper's table.
    Prediction(prediction::PredictionArgs),
    /// Tracking: fly full missions of all eight scenarios with several methods, presets and seeds, and compare with the paper's table.
    Tracking(tracking::TrackingArgs),
    /// Accuracy of the FDT without one of its parts, compared with the paper's table.
    Ablation(ablation::AblationArgs),
    /// Response to a change of the payload: innovation, resets, recovery, with the adapter, without it, and without its reset.
    Pickup(pickup::PickupArgs),
    /// Sweep of the parameters of the L1 controller: pole, and corners of its low-pass.
    L1(l1::L1Args),
    /// The plant against published curves, effect by effect: rotors, ground, wakes, drag, turbulence, battery, servos.
    Plant(plant::PlantArgs),
    /// What the residual consists of, by band and by effect, and whether a long window foresees it better than a short one.
    Residual(residual::ResidualArgs),
    /// Fly trained weights without the adapter, and write the scores of their forecasts into their file; exit code 0 if accepted.
    Acceptance(super::acceptance::AcceptanceArgs),
}

impl EvaluateArgs {
    /// Whether stdout is to hold one JSON object.
    pub(super) fn prints_json(&self) -> bool {
        match &self.table {
            Table::Prediction(args) => args.output.json,
            Table::Tracking(args) => args.output.json,
            Table::Ablation(args) => args.output.json,
            Table::Pickup(args) => args.output.json,
            Table::L1(args) => args.output.json,
            Table::Plant(args) => args.output.json,
            Table::Residual(args) => args.output.json,
            Table::Acceptance(args) => args.json,
        }
    }
}

pub(super) fn run(args: &EvaluateArgs) -> anyhow::Result<End> {
    match &args.table {
        Table::Prediction(args) => prediction::run(args),
        Table::Tracking(args) => tracking::run(args),
        Table::Ablation(args) => ablation::run(args),
        Table::Pickup(args) => pickup::run(args),
        Table::L1(args) => l1::run(args),
        Table::Plant(args) => plant::run(args),
        Table::Residual(args) => residual::run(args),
        Table::Acceptance(args) => super::acceptance::run(args),
    }
}

/// Overrides that fly the path of a scenario alone, with the payload in the gripper from the start.
const PATH_ALONE: [&str; 2] = ["task.kind=path", "task.start=grasped"];

/// The command line as it was given. Tables contain it, so that a reader can make them again.
fn command() -> String {
    let mut words: Vec<String> = std::env::args().collect();
    if let Some(program) = words.first_mut() {
        "twin".clone_into(program);
    }
    words.join(" ")
}
