//! The rehearsals of an oracle: the scenario is flown beforehand, so that the residual of every tick is known.
//!
//! The residual depends on the force that compensates it, so each rehearsal flies with what the one before it saw.

use super::run::Assessor;
use super::settings::PredictorKind;
use super::{BuildError, Scenario, assemble};
use twin_core::flight::{Flight, Parts};
use twin_core::residual::Oracle;
use twin_input::interruption;

/// Rehearsals: the first one compensates by persistence, and each later one by the residual of the one before it.
const ROUNDS: usize = 1;

/// The parts of a flight of `scenario`, whose oracle, if it has one, has rehearsed.
pub(super) fn parts(scenario: &Scenario) -> Result<Parts, BuildError> {
    let mut parts = assemble::parts(scenario)?;
    if scenario.settings.predictor.kind == PredictorKind::Oracle {
        for _ in 0..ROUNDS {
            let oracle = rehearse(scenario, parts)?;
            parts = Parts { predictor: Box::new(oracle), ..assemble::parts(scenario)? };
        }
    }
    Ok(parts)
}

/// Flies `parts` to the end of `scenario`, and remembers the residual of every outer period.
fn rehearse(scenario: &Scenario, parts: Parts) -> Result<Oracle, BuildError> {
    let divisor = parts.outer_divisor;
    let (mut flight, mut assessor) = (Flight::new(parts), Assessor::new(scenario));
    let mut residuals = Vec::new();
    loop {
        interruption::check()?;
        let tick = flight.tick();
        if tick.index.is_multiple_of(divisor) {
            residuals.push(*tick.residual);
        }
        if assessor.add(&tick).is_some() {
            return Ok(Oracle::new(residuals));
        }
    }
}
