//! Turns the `[[faults]]` of a scenario into disturbances by time, triggers, and a failing predictor.

use super::BuildError;
use super::settings::{ScheduledFailure, Settings};
use twin_core::flight::Trigger;
use twin_core::notation::TICK_S;
use twin_core::residual::{Failing, Predictor};
use twin_core::source::{Disturbance, Failure};

/// Disturbances by time (s), and triggers that wait for a condition.
type Changes = (Vec<(f64, Disturbance)>, Vec<Trigger>);

/// The begin and the end of every fault.
pub(super) fn schedule(settings: &Settings) -> Result<Changes, BuildError> {
    let (mut schedule, mut triggers) = (Vec::new(), Vec::new());
    for ScheduledFailure { at_s, duration_s, when, failure } in &settings.faults {
        fits(settings, failure)?;
        let change = |on| Disturbance::Failure { failure: failure.clone(), on };
        let begin = [(*at_s, change(true))].into_iter();
        let then = begin.chain(duration_s.map(|duration_s| (at_s + duration_s, change(false))));
        match when {
            None => schedule.extend(then),
            Some(when) => triggers.push(Trigger { when: when.clone(), then: then.collect() }),
        }
    }
    Ok((schedule, triggers))
}

fn fits(settings: &Settings, failure: &Failure) -> Result<(), BuildError> {
    let rotors = settings.vehicle.rotors.len();
    match failure {
        Failure::MotorEfficiency { rotor, .. } if *rotor >= rotors => Err(BuildError::Unfit {
            key: "faults.rotor",
            reason: format!(
                "found {rotor}, the vehicle has rotors 0..={}",
                rotors.saturating_sub(1)
            ),
        }),
        Failure::GripperSlip { .. } if settings.vehicle.gripper.joint.is_empty() => {
            let reason = "gripper_slip needs a gripper, vehicle.gripper.joint is empty".to_owned();
            Err(BuildError::Unfit { key: "faults.kind", reason })
        }
        _ => Ok(()),
    }
}

/// The predictor, which fails while a fault of the scenario is active.
pub(super) fn predictor(settings: &Settings, predictor: Box<dyn Predictor>) -> Box<dyn Predictor> {
    let period_s = TICK_S * f64::from(settings.controller.outer_divisor.max(1));
    let call = |t_s: f64| (t_s / period_s).ceil() as u64;
    let broken: Vec<_> = settings
        .faults
        .iter()
        .filter(|fault| fault.failure == Failure::PredictorNan)
        .map(|fault| call(fault.at_s)..fault.duration_s.map_or(u64::MAX, |d| call(fault.at_s + d)))
        .collect();
    if broken.is_empty() { predictor } else { Box::new(Failing::new(predictor, broken)) }
}
