//! A change of a flight that is in the air: other gains, another predictor or control law, another world, failures to come.
//!
//! In: the parts that replace those of the flight. Out: the flight goes on with them, and the next tick has an event for each. No state.

use super::{Flight, Trigger};
use crate::control::Controller;
use crate::notation::TICK_S;
use crate::residual::Predictor;
use crate::residual::foresight::Foresight;
use crate::residual::lra::Adapter;
use crate::source::Disturbance;
use crate::tick::{Event, EventKind, InnerLaw};
use crate::tuning::Tuning;

/// Another part of a flight, and the words that stand in the event.
#[derive(Clone)]
pub struct Other<T> {
    /// The part, as it is at the start of a flight.
    pub part: T,
    /// The name of the old part and of the new part.
    pub names: [String; 2],
}

/// What changes. Nothing changes by default.
#[derive(Clone, Default)]
pub struct Alteration {
    /// The predictor and an adapter for it, which both begin to learn.
    pub predictor: Option<Other<(Box<dyn Predictor>, Adapter)>>,
    /// The control law, which begins without integral or estimate.
    pub controller: Option<Other<Box<dyn Controller>>>,
    /// The values in force before and after; a gain that is equal in both keeps the value that it has in the flight.
    pub tuning: Option<Box<[Tuning; 2]>>,
    /// What happens to the world at once.
    pub disturbances: Vec<Disturbance>,
    /// What happens to the world later: time of the flight, s, and the disturbance.
    pub schedule: Vec<(f64, Disturbance)>,
    /// Disturbances that wait for a condition.
    pub triggers: Vec<Trigger>,
}

impl Flight {
    /// Changes the flight before its next tick.
    pub fn alter(&mut self, alteration: Alteration) {
        let Alteration { predictor, controller, tuning, disturbances, schedule, triggers } =
            alteration;
        if let Some(Other { part: (predictor, adapter), names }) = predictor {
            self.history.lengthen(predictor.history_len());
            (self.parts.predictor, self.parts.adapter) = (predictor, adapter);
            // Its trust is that of the old predictor.
            self.foresight = Foresight::default();
            self.note(Event::new(EventKind::Gain, exchanged("predictor", &names)));
        }
        if let Some(Other { part, names }) = controller {
            self.parts.controller = part;
            self.note(Event::new(EventKind::Gain, exchanged("controller", &names)));
        }
        if let Some(both) = tuning {
            self.retune(&both);
        }
        for disturbance in &disturbances {
            self.disturb(disturbance);
        }
        self.schedule.extend(schedule, triggers);
    }

    /// Replaces the alterations to come. Each has its time, s, and is made before the first tick at or after it; those that were due before
    /// the last tick are left out.
    pub fn set_alterations(&mut self, mut all: Vec<(f64, Alteration)>) {
        if let Some(last) = self.index.checked_sub(1) {
            all.retain(|(at_s, _)| *at_s > last as f64 * TICK_S);
        }
        self.alterations = all;
    }

    /// Makes the alterations that are due, in the order in which they were given.
    pub(super) fn make_due_alterations(&mut self, now_s: f64) {
        let is_due = |due: &mut (f64, Alteration)| due.0 <= now_s;
        let due: Vec<_> = self.alterations.extract_if(.., is_due).collect();
        for (_, alteration) in due {
            self.alter(alteration);
        }
    }

    /// Sets the gains that differ between `before` and `after`.
    fn retune(&mut self, [before, after]: &[Tuning; 2]) {
        let mut tuning = self.parts.tuning;
        for parameter in Tuning::parameters() {
            let name = parameter.name.as_str();
            let (Some(old), Some(new)) = (before.get(name), after.get(name)) else { continue };
            // A value out of range cannot occur in a `Tuning`, so nothing is refused here.
            if old.to_bits() != new.to_bits() && tuning.set(name, new).is_ok() {
                let was = self.parts.tuning.get(name).unwrap_or(old);
                let text = format!("{} ({name}) {was} -> {new}", parameter.label);
                self.note(Event::new(EventKind::Gain, text));
            }
        }
        if before.gains.inner_law != after.gains.inner_law {
            tuning.gains.inner_law = after.gains.inner_law;
            let names = [before, after].map(|tuning| law(tuning.gains.inner_law));
            self.note(Event::new(EventKind::Gain, exchanged("inner_law", &names)));
        }
        self.parts.tuning = tuning;
    }
}

fn exchanged(what: &str, [old, new]: &[String; 2]) -> String {
    format!("{what} {old} -> {new}")
}

/// The word of a scenario for `law`.
fn law(law: InnerLaw) -> String {
    match law {
        InnerLaw::Rows => "rows".to_owned(),
        InnerLaw::RateLoop => "rate_loop".to_owned(),
    }
}
