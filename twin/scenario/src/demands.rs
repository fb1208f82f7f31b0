//! Validates the changes that a scenario makes and the demands it has on its flight, and lists the events that the flight must be checked for.

use super::checks::{self, CheckError, EventCheck};
use super::settings::{Scheduled, ScheduledFailure, Settings};
use super::{golden, sweep};
use twin_core::source::{Disturbance, EFFECTS, Failure};
use twin_core::tick::EventKind;

/// Refuses demands that could never be judged or could never fail, and changes that would change nothing.
///
/// # Errors
/// [`CheckError`] with the key of the first of them.
pub(super) fn validate(settings: &Settings) -> Result<(), CheckError> {
    checks::validate(&settings.checks)?;
    if let Some(sweep) = &settings.sweep {
        sweep::validate(sweep, settings)?;
    }
    if let Some(golden) = &settings.golden {
        golden::validate(golden)?;
    }
    disturbances(&settings.disturbances)?;
    faults(&settings.faults)?;
    checks::validate_events(&settings.expect.events)
}

fn disturbances(disturbances: &[Scheduled]) -> Result<(), CheckError> {
    for (index, scheduled) in disturbances.iter().enumerate() {
        if let Disturbance::Effect { name, .. } = &scheduled.disturbance
            && !EFFECTS.contains(&name.as_str())
        {
            let reason = format!("found {name:?}; expected one of {}", EFFECTS.join(", "));
            return Err(CheckError { key: format!("disturbances.{index}.name"), reason });
        }
    }
    Ok(())
}

fn faults(faults: &[ScheduledFailure]) -> Result<(), CheckError> {
    for (index, fault) in faults.iter().enumerate() {
        let Some(when) = &fault.when else { continue };
        let refuse = |key: &str, reason: &str| {
            Err(CheckError { key: format!("faults.{index}.{key}"), reason: reason.to_owned() })
        };
        if when.phase.is_none() && when.event.is_none() {
            return refuse("when", "expected a phase or an event to wait for");
        }
        if when.text.is_some() && when.event.is_none() {
            return refuse("when.text", "found without `event`; name the kind of event too");
        }
        if fault.failure == Failure::PredictorNan {
            return refuse("when", "predictor_nan begins at a time only; give at_s without `when`");
        }
    }
    Ok(())
}

/// The events that the scenario demands, and the beginning of each of its faults. A fault that never began would prove nothing.
pub(super) fn events(settings: &Settings) -> Vec<EventCheck> {
    let begins = settings.faults.iter().map(|fault| {
        let text = Some(format!("failure: {}", fault.failure.words()));
        EventCheck { text, ..EventCheck::of(EventKind::Disturbance) }
    });
    settings.expect.events.iter().cloned().chain(begins).collect()
}
