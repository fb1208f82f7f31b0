//! Algorithm 1 of the paper, one tick at a time: the file to read first.
//!
//! In: the [`Parts`], among them a source of measurements, a task, a predictor with its adapter, a controller. Out: one [`Tick`] per 10 ms.
//! State: the state of those parts, the values in force ([`Tuning`]) and the last command. No I/O, no clock, no thread, no unseeded
//! randomness.

mod schedule;
mod parts;
mod stand_ins;
mod inner_guard;
mod saturation;
mod alteration;
pub mod snapshots;

pub use alteration::{Alteration, Other};
pub use parts::{Parts, Stage};
pub use saturation::LONG_S as LONG_SATURATION_S;
pub use schedule::{Condition, Trigger};

use crate::control::Input;
use crate::foreseen::Foreseen;
use crate::notation::{Coords, KnownCoords, MAX_ROTORS, TICK_S};
use crate::residual::foresight::Foresight;
use crate::residual::{History, Predictor, label};
use crate::source::Disturbance;
use crate::task::View;
use crate::tick::{
    ActuatorCommand, Adaptation, Adapted, ControlState, Event, EventKind, Fault, Forecast,
    Measurement, Reference, Setpoint, Tick,
};
use crate::tuning::Tuning;
use inner_guard::InnerGuard;
use saturation::SaturationWatch;
use schedule::Schedule;
use stand_ins::StandIns;

/// Pitch beyond which ZYX Euler angles are too near to their singularity, rad.
const PITCH_LIMIT_RAD: f64 = 80.0 * std::f64::consts::PI / 180.0;

/// A flight in progress. [`Parts`] has an example, from the parts to the last tick. A copy of it flies on by itself, tick by tick as the
/// original would; weights and models are shared.
#[derive(Clone)]
pub struct Flight {
    parts: Parts,
    schedule: Schedule,
    /// Alterations to come, each with its time, s.
    alterations: Vec<(f64, Alteration)>,
    history: History,
    stand_ins: StandIns,
    foresight: Foresight,
    index: u64,
    setpoint: Setpoint,
    last_good: Option<Measurement>,
    actuators: ActuatorCommand,
    fault: Option<Fault>,
    notes: Vec<Event>,
    saturation: SaturationWatch,
    hash: u64,
    outer: Option<Outer>,
    /// Residual after a release that the outer loop has not yet processed, N and N m.
    release: Option<Coords>,
}

impl Flight {
    /// A flight from its parts, at tick 0.
    pub fn new(mut parts: Parts) -> Self {
        let timed = std::mem::take(&mut parts.schedule);
        Self {
            schedule: Schedule::new(timed, std::mem::take(&mut parts.triggers)),
            alterations: Vec::new(),
            history: History::new(parts.history_len),
            stand_ins: StandIns::new(),
            foresight: Foresight::default(),
            index: 0,
            setpoint: parts.setpoint,
            last_good: None,
            actuators: ActuatorCommand {
                rotor_thrust_n: [0.0; MAX_ROTORS],
                joint_torque_n_m: nalgebra::Vector2::zeros(),
                saturated: false,
            },
            fault: None,
            notes: Vec::new(),
            saturation: SaturationWatch::default(),
            hash: FNV_OFFSET,
            outer: None,
            release: None,
            parts,
        }
    }

    /// A flight from its parts whose first tick has the number `index`: it starts in the middle of a recording.
    pub fn starting_at(parts: Parts, index: u64) -> Self {
        Self { index, ..Self::new(parts) }
    }

    /// Number of the next tick.
    pub fn index(&self) -> u64 {
        self.index
    }

    /// The values in force.
    pub fn tuning(&self) -> &Tuning {
        &self.parts.tuning
    }

    /// Replaces the values in force, between ticks.
    pub fn set_tuning(&mut self, tuning: Tuning) {
        self.parts.tuning = tuning;
    }

    /// Changes the world, between ticks.
    pub fn disturb(&mut self, disturbance: &Disturbance) {
        self.notes.push(Event::new(EventKind::Disturbance, disturbance.sentence()));
        self.prolong(disturbance);
    }

    /// Continues a disturbance that was already noted: it changes the world without another event.
    pub fn prolong(&mut self, disturbance: &Disturbance) {
        self.parts.source.disturb(disturbance);
    }

    /// Eigenvalues of the adapter's covariance, largest first.
    pub fn covariance_spectrum(&self) -> Vec<f64> {
        self.parts.adapter.spectrum()
    }

    /// The predictor.
    pub fn predictor(&self) -> &dyn Predictor {
        self.parts.predictor.as_ref()
    }

    /// Puts an event on the next tick.
    pub fn note(&mut self, event: Event) {
        self.notes.push(event);
    }

    /// Hash of everything measured and commanded so far: equal for equal flights.
    pub fn state_hash(&self) -> u64 {
        self.hash
    }

    /// One control period.
    pub fn tick(&mut self) -> Tick {
        self.tick_with(&mut |_| {})
    }

    /// One control period; calls `done` at the end of each stage.
    pub fn tick_with(&mut self, done: &mut dyn FnMut(Stage)) -> Tick {
        let now_s = self.index as f64 * TICK_S;
        self.make_due_alterations(now_s);
        while let Some(disturbance) = self.schedule.next(now_s) {
            self.disturb(&disturbance);
        }
        // Line 2: measure. The inner controller runs inside the source.
        let mut inner = InnerGuard::new(&mut self.parts.inner, self.actuators);
        let measured = self.parts.source.advance(&self.setpoint, &mut inner);
        let commands_finite = inner.all_finite();
        self.actuators = inner.last();
        let measurement = self.check(measured, commands_finite);
        done(Stage::Source);
        let residual = label::residual(&measurement, &self.parts.tuning.gains.nominal_inertia);
        let step = self
            .parts
            .task
            .update(&View { measurement: &measurement, residual: &residual }, TICK_S);
        self.release = step.reference.release.or(self.release);
        done(Stage::Task);
        let outer = match self.outer.take() {
            Some(outer) if !self.index.is_multiple_of(self.parts.outer_divisor) => {
                outer.held(residual)
            }
            _ => self.outer(&measurement, residual, &step.reference, done),
        };
        self.outer = Some(outer.clone());
        let tick = self.record(measurement, outer, step);
        self.schedule.watch(&tick);
        done(Stage::Record);
        tick
    }

    /// Lines 3 to 11: residual, forecast, adaptation, control.
    fn outer(
        &mut self,
        measurement: &Measurement,
        residual: KnownCoords,
        reference: &Reference,
        done: &mut dyn FnMut(Stage),
    ) -> Outer {
        let tuning = self.parts.tuning;
        let dt_s = TICK_S * self.parts.outer_divisor as f64;
        // Line 3: residual into the history. Line 4: base forecast and regime.
        let chi = self.stand_ins.coordinates(&measurement.chi);
        let nominal_gravity = (self.parts.gravity)(&chi);
        let inertia = &tuning.gains.nominal_inertia;
        let seen = stand_ins::remembered(measurement, &residual, &nominal_gravity, inertia);
        let known = residual.known();
        self.history.push_masked(chi, seen.chi_dot, seen.tau, seen.residual, known);
        let mut forecast = self.forecast(&nominal_gravity);
        forecast.base.iter_mut().for_each(|base| *base = base.only(known));
        done(Stage::Predict);
        // Lines 5 to 8: adapt.
        let mut reference = *reference;
        reference.release = self.release.take();
        if let Some(known) = &reference.release {
            self.parts.adapter.move_to(&forecast, known, &tuning.adapter);
        }
        let frozen = reference.adaptation == Adaptation::Held || self.fault.is_some();
        let adapted = self.parts.adapter.step(
            &forecast,
            &self.history,
            &residual,
            dt_s,
            frozen,
            &tuning.adapter,
        );
        let lead_s = self.parts.delays.lead(&tuning.gains);
        let judged = reference.adaptation == Adaptation::Free && self.fault.is_none();
        let foreseen = self.foresight.step(&forecast, &adapted, &residual, &lead_s, dt_s, judged);
        let r_hat = usable(&foreseen.used, &nominal_gravity);
        done(Stage::Adapt);
        // Lines 9 to 11: control.
        let (measured, asked) = stand_ins::for_control(measurement, &reference, &nominal_gravity);
        let input = Input {
            measurement: &measured,
            reference: &asked,
            r_hat: &r_hat,
            residual: &seen.residual,
            nominal_gravity: &nominal_gravity,
            desired_attitude: self.parts.inner.desired_attitude(),
            dt_s,
        };
        let (setpoint, control) = self.parts.controller.control(&input, &tuning.gains);
        self.accept(&setpoint);
        let control = stand_ins::as_known(control, measurement, &reference);
        done(Stage::Control);
        Outer { residual, forecast, adapted, foreseen, control }
    }

    /// Replaces a non-finite measurement by the last finite one. Sets a fault for it, and for commands of the inner controller that were
    /// not finite.
    fn check(&mut self, measured: Measurement, commands_finite: bool) -> Measurement {
        let finite = [&measured.chi, &measured.chi_dot, &measured.chi_ddot, &measured.tau_applied]
            .iter()
            .all(|v| v.is_finite());
        let fault = if !finite {
            Some(Fault::NonFiniteMeasurement)
        } else if !commands_finite {
            Some(Fault::NonFiniteCommand)
        } else if measured.chi[4].abs() > PITCH_LIMIT_RAD {
            Some(Fault::PitchBeyondRange)
        } else {
            None
        };
        // Only the next forecast shows whether a fault of the prediction is over.
        if fault.is_some() || self.fault != Some(Fault::NonFinitePrediction) {
            self.set_fault(fault);
        }
        if finite {
            self.last_good = Some(measured.clone());
            return measured;
        }
        let t_s = measured.t_s;
        match &self.last_good {
            Some(good) => Measurement { t_s, ..good.clone() },
            None => Measurement {
                chi: Coords::zeros().into(),
                chi_dot: Coords::zeros().into(),
                chi_ddot: Coords::zeros().into(),
                tau_applied: Coords::zeros().into(),
                ..measured
            },
        }
    }

    fn set_fault(&mut self, fault: Option<Fault>) {
        if fault != self.fault {
            let text = match fault {
                Some(Fault::NonFiniteMeasurement) => {
                    "a measurement is not finite: the last one is held"
                }
                Some(Fault::NonFiniteCommand) => {
                    "a command of attitude and joints is not finite: the last one is held"
                }
                Some(Fault::NonFinitePrediction) => {
                    "the prediction is not finite: nominal gravity is used"
                }
                Some(Fault::PitchBeyondRange) => "pitch is beyond 80 degrees: adaptation is held",
                None => "fault is over",
            };
            self.notes.push(Event::new(EventKind::Fault, text));
        }
        self.fault = fault;
    }

    fn forecast(&mut self, nominal_gravity: &Coords) -> Forecast {
        let forecast = self.parts.predictor.predict(&self.history);
        let finite = forecast.base.iter().all(KnownCoords::is_finite)
            && forecast.regime.iter().chain(&forecast.attention).all(|x| x.is_finite());
        if finite && !forecast.base.is_empty() {
            if self.fault == Some(Fault::NonFinitePrediction) {
                self.set_fault(None);
            }
            return forecast;
        }
        if self.fault.is_none() {
            self.set_fault(Some(Fault::NonFinitePrediction));
        }
        Forecast {
            base: vec![(*nominal_gravity).into(); forecast.base.len().max(1)],
            regime: vec![0.0; forecast.regime.len()],
            attention: Vec::new(),
        }
    }

    /// Passes a set-point to the inner controller only if it is finite.
    fn accept(&mut self, setpoint: &Setpoint) {
        if setpoint.is_finite() {
            self.setpoint = *setpoint;
        }
    }

    fn record(&mut self, measurement: Measurement, outer: Outer, step: crate::task::Step) -> Tick {
        let Outer { residual, forecast, adapted, foreseen, control } = outer;
        let mut events = std::mem::take(&mut self.notes);
        events.extend(step.events);
        events.extend(self.saturation.step(measurement.saturated));
        if adapted.reset {
            let text = format!(
                "covariance reset: mean innovation {:.3} exceeded {:.3}",
                adapted.innovation_mean_norm, self.parts.tuning.adapter.reset_threshold
            );
            events.push(Event::new(EventKind::Reset, text));
        }
        for value in measurement
            .chi
            .iter()
            .chain(measurement.chi_dot.iter())
            .chain(adapted.r_hat.iter())
            .chain(&self.setpoint.r_hat)
        {
            self.hash = fnv(self.hash, value.to_bits());
        }
        let tick = Tick {
            index: self.index,
            measurement,
            truth: self.parts.source.truth(),
            reference: step.reference,
            residual,
            forecast,
            adapted,
            foreseen: Some(foreseen),
            control,
            setpoint: self.setpoint,
            actuators: self.actuators,
            phase: step.phase.to_owned(),
            events,
            fault: self.fault,
            finished: step.finished,
            gave_up: step.gave_up,
        };
        self.index += 1;
        tick
    }
}

/// Result of the outer loop, which stays in force until its next period.
#[derive(Clone)]
struct Outer {
    residual: KnownCoords,
    forecast: Forecast,
    adapted: Adapted,
    foreseen: Foreseen,
    control: ControlState,
}

impl Outer {
    /// The same result one tick later: only the measured residual is new.
    fn held(mut self, residual: KnownCoords) -> Self {
        self.residual = residual;
        self.adapted.reset = false;
        self
    }
}

/// The estimate, with nominal gravity in the coordinates whose residual is unknown; nominal gravity alone if the estimate is not finite.
/// N and N m.
fn usable(r_hat: &KnownCoords, nominal_gravity: &Coords) -> Coords {
    if r_hat.is_finite() { r_hat.or(nominal_gravity) } else { *nominal_gravity }
}

/// FNV-1a, 64 bit.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0100_0000_01b3;

fn fnv(hash: u64, bits: u64) -> u64 {
    bits.to_le_bytes().iter().fold(hash, |h, byte| (h ^ u64::from(*byte)).wrapping_mul(FNV_PRIME))
}
