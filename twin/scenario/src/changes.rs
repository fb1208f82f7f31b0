//! Keys of a scenario that change while its flight is in the air: by `[[changes]]` in the file, or by a fork.
//!
//! In: the scenario before and after. Out: the [`Alteration`] of the flight, or a refusal in words.

use super::checks::CheckError;
use super::differences::differences;
use super::settings::{PredictorKind, Scheduled, ScheduledFailure, Settings};
use super::{BuildError, Scenario, ScenarioError, assemble, failures};
use twin_core::flight::{Alteration, Other};
use twin_core::quantity::PAYLOAD_MASS;
use twin_core::source::{Disturbance, EFFECTS, Failure};
use twin_plant::PlantSettings;

/// What may change, for errors.
const ALLOWED: &str = "gains.*, predictor.*, controller.kind, payload.mass_kg, wind.velocity_m_s, the switch of an effect (such as \
    wind.on or aero.downwash), and more faults and disturbances";

/// The scenario after each of its changes, with the time of the change, s; each change builds on those before it.
///
/// # Errors
/// [`ScenarioError`] for a change that is no valid scenario, or that changes what a flight in the air keeps.
pub(super) fn after_each(scenario: &Scenario) -> Result<Vec<(f64, Scenario)>, ScenarioError> {
    let mut now = Scenario { settings: without_changes(&scenario.settings), ..scenario.clone() };
    let mut all = Vec::new();
    let mut last_s = 0.0;
    for (index, change) in scenario.settings.changes.iter().enumerate() {
        let refuse = |key: &str, reason: String| ScenarioError::Value {
            place: scenario.file.display().to_string(),
            key: format!("changes.{index}.{key}"),
            reason,
        };
        if change.at_s < last_s {
            let reason = format!(
                "found {} s after a change at {last_s} s, put the earlier first",
                change.at_s
            );
            return Err(refuse("at_s", reason));
        }
        last_s = change.at_s;
        let next = now.with(&change.set).map_err(|error| refuse("set", error.to_string()))?;
        check(&now.settings, &next.settings, change.at_s)
            .map_err(|error| refuse("set", format!("{}: {}", error.key, error.reason)))?;
        now = next.clone();
        all.push((change.at_s, next));
    }
    Ok(all)
}

/// The settings with no changes to come.
pub(super) fn without_changes(settings: &Settings) -> Settings {
    Settings { changes: Vec::new(), ..settings.clone() }
}

/// Refuses a difference that a flight in the air cannot make at `at_s`, s.
///
/// # Errors
/// [`CheckError`] with the first key that must stay as it is.
fn check(before: &Settings, after: &Settings, at_s: f64) -> Result<(), CheckError> {
    let refuse = |key: &str, reason: String| Err(CheckError { key: key.to_owned(), reason });
    if let Some(kept) = differences(&allowed(before, after), after).first() {
        let reason =
            format!("{} -> {} cannot change in the air; {ALLOWED} can", kept.from, kept.to);
        return refuse(&kept.key, reason);
    }
    if before.predictor != after.predictor {
        if after.predictor.kind == PredictorKind::Oracle {
            let reason = "an oracle rehearses whole flights, so it cannot begin in the air";
            return refuse("predictor.kind", reason.to_owned());
        }
        if before.faults.iter().any(|fault| fault.failure == Failure::PredictorNan) {
            let reason = "the scenario has a fault predictor_nan, which belongs to the predictor; remove the fault";
            return refuse("predictor.kind", reason.to_owned());
        }
    }
    let [was, is] = [before, after].map(|settings| settings.payload.mass_kg);
    if (was > 0.0) != (is > 0.0) {
        let reason = if is > 0.0 {
            "the flight has no payload whose mass could change".to_owned()
        } else {
            format!(
                "found 0, expected {}; a disturbance drop_payload drops it",
                PAYLOAD_MASS.range()
            )
        };
        return refuse("payload.mass_kg", reason);
    }
    let Some(faults) = added(&before.faults, &after.faults) else {
        return refuse(
            "faults",
            "a change adds faults; keep those that the scenario has".to_owned(),
        );
    };
    let Some(disturbances) = added(&before.disturbances, &after.disturbances) else {
        let reason = "a change adds disturbances; keep those that the scenario has".to_owned();
        return refuse("disturbances", reason);
    };
    if faults.iter().any(|fault| fault.failure == Failure::PredictorNan) {
        let reason = "predictor_nan is built into the predictor at the start; choose another fault";
        return refuse("faults", reason.to_owned());
    }
    let times = faults.iter().filter(|fault| fault.when.is_none()).map(|fault| fault.at_s);
    let past = times.chain(disturbances.iter().map(|d| d.at_s)).find(|time| *time < at_s);
    if let Some(past) = past {
        let reason = format!("at_s = {past} is before the change at {at_s} s; choose a later time");
        return refuse(if faults.is_empty() { "disturbances" } else { "faults" }, reason);
    }
    Ok(())
}

/// `before` with everything of `after` that may change.
fn allowed(before: &Settings, after: &Settings) -> Settings {
    let mut all = before.clone();
    all.gains.clone_from(&after.gains);
    all.predictor.clone_from(&after.predictor);
    all.controller.kind = after.controller.kind;
    all.faults.clone_from(&after.faults);
    all.disturbances.clone_from(&after.disturbances);
    let other = after.plant();
    for name in EFFECTS {
        all.switch_effect(name, other.effect(name) == Some(true));
    }
    all.wind.velocity_m_s = after.wind.velocity_m_s;
    all.payload.mass_kg = after.payload.mass_kg;
    all
}

impl Settings {
    /// Switches the effect `name`, if there is one.
    pub fn switch_effect(&mut self, name: &str, on: bool) {
        let mut plant = self.plant();
        if let Some(switch) = plant.effect_mut(name) {
            *switch = on;
        }
        let PlantSettings { vehicle, aero, wind, sensors, .. } = plant;
        (self.vehicle, self.aero, self.wind, self.sensors) = (vehicle, aero, wind, sensors);
    }
}

/// The elements that `after` has behind those of `before`; `None` if one of `before` is missing.
fn added<'a, T: PartialEq>(before: &[T], after: &'a [T]) -> Option<&'a [T]> {
    after.strip_prefix(before)
}

/// The alterations that the changes of `scenario` make to its flight, each with its time, s.
///
/// # Errors
/// [`BuildError`] if a change is refused, or if another predictor cannot be built.
pub(super) fn alterations(scenario: &Scenario) -> Result<Vec<(f64, Alteration)>, BuildError> {
    let mut before = Scenario { settings: without_changes(&scenario.settings), ..scenario.clone() };
    let mut all = Vec::new();
    for (at_s, after) in after_each(scenario)? {
        all.push((at_s, alteration(&before, &after)?));
        before = after;
    }
    Ok(all)
}

/// The alteration that turns a flight of `before` into one of `after`, which [`check`] allows.
///
/// # Errors
/// [`BuildError`] if the other predictor cannot be built, or if a fault does not fit the vehicle.
fn alteration(before: &Scenario, after: &Scenario) -> Result<Alteration, BuildError> {
    let (old, new) = (&before.settings, &after.settings);
    let mut alteration = Alteration::default();
    let (was, is) = (before.tuning()?, after.tuning()?);
    if was != is {
        alteration.tuning = Some(Box::new([was, is]));
    }
    if old.predictor != new.predictor {
        let names = [old, new].map(|settings| assemble::word(&settings.predictor.kind));
        alteration.predictor = Some(Other { part: assemble::learners_of(after)?, names });
    }
    if old.controller.kind != new.controller.kind {
        let names = [old, new].map(|settings| assemble::word(&settings.controller.kind));
        alteration.controller = Some(Other { part: assemble::controller(new), names });
    }
    alteration.disturbances = world(old, new);
    let faults = added(&old.faults, &new.faults).unwrap_or_default().to_vec();
    alteration.triggers = schedule(&mut alteration.schedule, new, faults)?;
    let disturbances = added(&old.disturbances, &new.disturbances).unwrap_or_default();
    let timed =
        disturbances.iter().map(|Scheduled { at_s, disturbance }| (*at_s, disturbance.clone()));
    alteration.schedule.extend(timed);
    Ok(alteration)
}

/// Adds the `faults` by time to `timed`; returns those that wait for a condition.
fn schedule(
    timed: &mut Vec<(f64, Disturbance)>,
    settings: &Settings,
    faults: Vec<ScheduledFailure>,
) -> Result<Vec<twin_core::flight::Trigger>, BuildError> {
    let (schedule, triggers) = failures::schedule(&Settings { faults, ..settings.clone() })?;
    timed.extend(schedule);
    Ok(triggers)
}

/// The changes of payload, wind and effects.
fn world(old: &Settings, new: &Settings) -> Vec<Disturbance> {
    let mut all = Vec::new();
    if old.payload.mass_kg.to_bits() != new.payload.mass_kg.to_bits() {
        all.push(Disturbance::PayloadMass { kg: new.payload.mass_kg });
    }
    let bits = |settings: &Settings| settings.wind.velocity_m_s.map(f64::to_bits);
    if bits(old) != bits(new) {
        all.push(Disturbance::Wind { velocity_m_s: new.wind.velocity_m_s });
    }
    let (was, is) = (old.plant(), new.plant());
    for name in EFFECTS {
        if let Some(on) = is.effect(name).filter(|on| was.effect(name) != Some(*on)) {
            all.push(Disturbance::Effect { name: name.to_owned(), on });
        }
    }
    all
}
