//! The trained weights of a scenario: reads their file, and checks that they belong to this flight and may fly.

use std::path::Path;

use super::settings::PredictorKind;
use super::{BuildError, Scenario};
use twin_core::notation::{COORDINATE_NAMES, TICK_S};
use twin_core::residual::nn::Precision;
use twin_core::residual::nn::kernels::Kernel;
use twin_core::residual::weights::{Head, SHIPPED, Weights};
use twin_core::residual::{Predictor, trained};
use twin_core::tuning::Tuning;
use twin_input::budget::WEIGHTS_BYTES;
use twin_input::file;

/// The name of the weights that are built into the program.
const DEFAULT: &str = "default";

/// Width from which on the weights of a network exceed the cache of a core; `auto` then rounds them to bf16, which halves their
/// size.
const WIDE: usize = 256;

/// The trained predictor of a scenario: the FDT, or with `trained` any model.
pub(super) fn predictor(
    scenario: &Scenario,
    tuning: &Tuning,
) -> Result<Box<dyn Predictor>, BuildError> {
    let settings = &scenario.settings;
    let name = &settings.predictor.weights;
    let weights = read(scenario.folder(), name)?;
    let unusable = |error| BuildError::Weights { file: name.clone(), error };
    let rate_hz = 1.0 / (TICK_S * f64::from(settings.controller.outer_divisor.max(1)));
    if settings.predictor.kind == PredictorKind::Fdt {
        weights.head.check_model("fdt").map_err(unusable)?;
    }
    weights.head.check_channels().map_err(unusable)?;
    weights.head.check_loop(&tuning.gains.nominal_inertia, rate_hz).map_err(unusable)?;
    fits_vehicle(&weights.head, settings.vehicle.arm_joints.len())?;
    if !settings.predictor.force {
        accepted(&weights.head, name)?;
    }
    let width = weights.head.config.get("d_model").and_then(serde_json::Value::as_u64);
    let (kernel, precision) = arithmetic(&settings.predictor.kernel, width.unwrap_or(0) as usize)?;
    let trained = trained::predictor(&weights, kernel, precision).map_err(unusable)?;
    Ok(trained.predictor)
}

/// Reads the weights called `name`: a path relative to `folder`, or [`DEFAULT`].
fn read(folder: &Path, name: &str) -> Result<Weights, BuildError> {
    let unusable = |error| BuildError::Weights { file: name.to_owned(), error };
    if name != DEFAULT {
        let path = folder.join(name);
        let bytes = file::read(&path, WEIGHTS_BYTES).map_err(|error| BuildError::Unreadable {
            file: path.display().to_string(),
            reason: format!("{error}; predictor.weights names a file that `twin train` wrote"),
        })?;
        return Weights::from_bytes(&bytes).map_err(unusable);
    }
    Weights::from_bytes(SHIPPED).map_err(unusable)
}

/// Refuses weights with channels of joints that the vehicle does not have.
fn fits_vehicle(head: &Head, joints: usize) -> Result<(), BuildError> {
    let absent = &COORDINATE_NAMES[(6 + joints).min(COORDINATE_NAMES.len())..];
    let seen = head.channel_names.iter().find(|name| {
        let row = name.rsplit('.').next().unwrap_or_default();
        absent.contains(&row) && !head.normalisation.masked.contains(name)
    });
    match seen {
        Some(name) => Err(BuildError::Unfit {
            key: "predictor.weights",
            reason: format!(
                "the weights need the channel {name:?}, but this vehicle's arm has {joints} joints; train on this vehicle"
            ),
        }),
        None => Ok(()),
    }
}

/// Refuses weights that have not passed a closed-loop flight, because open-loop scores do not reveal a limit cycle.
fn accepted(head: &Head, name: &str) -> Result<(), BuildError> {
    let figures = &head.acceptance;
    if figures.passed() {
        return Ok(());
    }
    Err(BuildError::Unfit {
        key: "predictor.weights",
        reason: format!(
            "{name} is not accepted: {figures}; it must be above {}; measure with `twin evaluate acceptance`, or fly it anyway with --force-weights (predictor.force = true)",
            twin_core::residual::weights::Acceptance::LEAST_R2
        ),
    })
}

/// The arithmetic called `name` for a network of width `d_model`.
fn arithmetic(name: &str, d_model: usize) -> Result<(Kernel, Precision), BuildError> {
    if name == "auto" {
        let precision = if d_model >= WIDE { Precision::Bf16 } else { Precision::F32 };
        return Ok((Kernel::best(), precision));
    }
    let (kernel, precision) = match name.strip_suffix("_bf16") {
        Some(kernel) => (kernel, Precision::Bf16),
        None => (name, Precision::F32),
    };
    let kernel = Kernel::named(kernel).ok_or_else(|| {
        let names: Vec<_> = Kernel::available().into_iter().map(Kernel::name).collect();
        BuildError::Unfit {
            key: "predictor.kernel",
            reason: format!(
                "found {name:?}, this processor supports auto, {}, each also with _bf16",
                names.join(", ")
            ),
        }
    })?;
    Ok((kernel, precision))
}
