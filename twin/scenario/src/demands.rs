//! Validates the changes that a scenario makes and the demands it has on its flight, and lists the events with which its faults begin.

use super::checks::{self, CheckError};
use super::settings::{Scheduled, ScheduledFailure, Settings};
use super::{golden, sweep};
use twin_core::source::{Disturbance, EFFECTS, Failure};
use twin_input::Excess;
use twin_input::budget::SCENARIO_CHECKS;

/// Refuses demands that could never be judged or could never fail, and changes that would change nothing.
///
/// # Errors
/// [`CheckError`] with the key of the first of them.
pub(super) fn validate(settings: &Settings) -> Result<(), CheckError> {
    few_enough("checks", settings.checks.len())?;
    few_enough("expect.events", settings.expect.events.len())?;
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

/// The sentences with which the faults of the scenario begin. A fault that never began would prove nothing.
pub(super) fn begins(settings: &Settings) -> Vec<String> {
    let begins = |fault: &ScheduledFailure| {
        Disturbance::Failure { failure: fault.failure.clone(), on: true }.sentence()
    };
    settings.faults.iter().map(begins).collect()
}

/// Refuses more checks than the budget allows: each costs time at every tick.
fn few_enough(key: &str, count: usize) -> Result<(), CheckError> {
    let refused = |excess: Excess| CheckError { key: key.to_owned(), reason: excess.to_string() };
    SCENARIO_CHECKS.check_count(count).map_err(refused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::{Checks, EventCheck};
    use twin_core::fixture;
    use twin_core::tick::{Event, EventKind};
    use twin_input::work;

    #[test]
    fn as_many_checks_as_the_budget_allows_pass_and_one_more_is_refused() {
        assert_eq!(few_enough("checks", SCENARIO_CHECKS.count()), Ok(()));
        let refused = few_enough("checks", SCENARIO_CHECKS.count() + 1).unwrap_err();
        assert!(refused.key == "checks" && refused.reason.contains("found 1001"), "{refused}");
    }

    /// The violations of a flight in which `happen` of `count` faults begin.
    fn flown(count: usize, happen: usize) -> usize {
        let text = |n: usize| format!("failure: gust of {n} m/s");
        let events: [EventCheck; 0] = [];
        let mut checks = Checks::new(&[], &events, (0..count).map(text).collect());
        for n in 0..happen {
            let event = Event::new(EventKind::Disturbance, text(n));
            checks.add(&twin_core::tick::Tick { events: vec![event], ..fixture::tick(n as u64) });
        }
        checks.finish().len()
    }

    #[test]
    fn faults_that_never_begin_are_found_with_linear_work() {
        assert_eq!((flown(5, 5), flown(5, 3), flown(5, 0)), (0, 2, 5));
        let growth = work::growth(200, &mut |count| assert_eq!(flown(count, count / 2), count / 2));
        assert!(growth < work::LINEAR, "four times the faults took {growth:.1} times the steps");
    }
}
