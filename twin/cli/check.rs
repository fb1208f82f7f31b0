//! `twin check`: says whether scenarios, vehicles and trained weights can be used.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::trained;
use twin_plant::model::{Packages, Robot};
use twin_record::Outputs;
use twin_scenario::{Scenario, json_schema};

use super::{End, Overrides, print, read_weights};

#[derive(Args)]
pub(super) struct CheckArgs {
    /// Print the JSON Schema of a scenario, for editors.
    #[arg(long, conflicts_with = "files")]
    schema: bool,
    /// Scenarios (.toml), vehicles (.urdf) and trained weights (.safetensors).
    #[arg(required_unless_present = "schema")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn run(args: &CheckArgs) -> anyhow::Result<End> {
    let mut end = End::Passed;
    print(&Outputs::default(), |out| {
        if args.schema {
            write!(out, "{}", json_schema())?;
        }
        for file in &args.files {
            match check(file, &args.overrides.set) {
                Ok(found) => writeln!(out, "ok    {}: {found}", file.display())?,
                Err(error) => {
                    writeln!(out, "ERROR {error:#}")?;
                    end = End::Failed;
                }
            }
        }
        Ok(())
    })?;
    Ok(end)
}

fn check(file: &Path, overrides: &[String]) -> anyhow::Result<String> {
    if file.extension().is_some_and(|ending| ending == "urdf") {
        let robot = Robot::load(file, &Packages(Vec::new()))?;
        let (links, joints) = (robot.links.len(), robot.joints.len());
        return Ok(format!(
            "{} with {links} links, {joints} joints, {:.3} kg",
            robot.name,
            robot.total_mass_kg()
        ));
    }
    if file.extension().is_some_and(|ending| ending == "safetensors") {
        return weights(file);
    }
    if file.file_name().is_some_and(|name| name == "defaults.toml") {
        return Ok("defaults of every key".to_owned());
    }
    let scenario = Scenario::load(file, overrides)?;
    scenario.build()?;
    Ok(scenario.settings.title)
}

/// Describes a file of weights, after it has built the predictor.
fn weights(file: &Path) -> anyhow::Result<String> {
    let weights = read_weights(file)?;
    let trained = trained::predictor(&weights, Kernel::SCALAR, Precision::F32)
        .with_context(|| file.display().to_string())?;
    let head = &weights.head;
    let accepted = if head.acceptance.passed() { "accepted" } else { "not accepted" };
    Ok(format!(
        "{}, {} numbers, trained on data {:.12}, {accepted}: {}",
        head.model, trained.parameters, head.data_hash, head.acceptance
    ))
}
