//! Numbers that are not finite from the source or the predictor: the tick has a fault, commands stay finite, the flight recovers.

use std::sync::{Arc, Mutex};

use twin_core::flight::{Flight, Parts};
use twin_core::notation::{Coords, N};
use twin_core::residual::{History, Predictor};
use twin_core::source::{Disturbance, InnerLoop, InnerState, Source};
use twin_core::tick::{
    ActuatorCommand, EventKind, Fault, Forecast, Measurement, Setpoint, Tick, Truth,
};

use super::flown::scenario;

/// Ticks at which the numbers are not finite.
const BROKEN: std::ops::Range<u64> = 150..160;

/// Largest distance of the vehicle from its place, m, although its numbers were not finite for a tenth of a second.
const STRAY_M: f64 = 0.15;

/// Every command that reached the actuators, also between ticks.
type Commands = Arc<Mutex<Vec<ActuatorCommand>>>;

/// A source that breaks coordinates of its measurement, so that they are not finite for a while. It records every command.
#[derive(Clone)]
struct Broken {
    source: Box<dyn Source + Send>,
    breaks: fn(&mut Measurement),
    ticks: u64,
    commands: Commands,
}

/// Inner controllers that record their commands.
struct Listening<'a> {
    inner: &'a mut dyn InnerLoop,
    commands: &'a Commands,
}

impl InnerLoop for Listening<'_> {
    fn command(&mut self, setpoint: &Setpoint, state: &InnerState) -> ActuatorCommand {
        let command = self.inner.command(setpoint, state);
        self.commands.lock().expect("nobody panicked").push(command);
        command
    }
}

impl Source for Broken {
    fn advance(&mut self, setpoint: &Setpoint, inner: &mut dyn InnerLoop) -> Measurement {
        let mut listening = Listening { inner, commands: &self.commands };
        let mut measurement = self.source.advance(setpoint, &mut listening);
        if BROKEN.contains(&self.ticks) {
            (self.breaks)(&mut measurement);
        }
        self.ticks += 1;
        measurement
    }

    fn truth(&self) -> Option<Truth> {
        self.source.truth()
    }

    fn disturb(&mut self, disturbance: &Disturbance) {
        self.source.disturb(disturbance);
    }
}

/// A predictor that breaks its forecast, so that a number of it is not finite for a while.
#[derive(Clone)]
struct Dreaming {
    predictor: Box<dyn Predictor>,
    breaks: fn(&mut Forecast),
    ticks: u64,
}

impl Predictor for Dreaming {
    fn regime_len(&self) -> usize {
        self.predictor.regime_len()
    }

    fn predict(&mut self, history: &History) -> Forecast {
        let mut forecast = self.predictor.predict(history);
        if BROKEN.contains(&self.ticks) {
            (self.breaks)(&mut forecast);
        }
        self.ticks += 1;
        forecast
    }
}

fn parts(breaks: fn(&mut Measurement)) -> (Parts, Commands) {
    let mut parts = scenario("hover", &[]).parts().expect("it builds");
    let commands = Commands::default();
    parts.source =
        Box::new(Broken { source: parts.source, breaks, ticks: 0, commands: commands.clone() });
    (parts, commands)
}

fn fly(parts: Parts) -> Vec<Tick> {
    let mut flight = Flight::new(parts);
    (0..350).map(|_| flight.tick()).collect()
}

/// Asserts that every number that leaves the loop is finite, and that the vehicle stays where it is.
fn check(ticks: &[Tick], commands: &Commands, fault: Fault) {
    for command in commands.lock().expect("nobody panicked").iter() {
        let finite =
            command.rotor_thrust_n.iter().chain(&command.joint_torque_n_m).all(|x| x.is_finite());
        assert!(finite, "{command:?}");
    }
    for tick in ticks {
        let wanted = BROKEN.contains(&tick.index).then_some(fault);
        assert_eq!(tick.fault, wanted, "tick {}", tick.index);
        let numbers = tick
            .setpoint
            .force_in_world_n
            .iter()
            .chain(&tick.setpoint.r_hat)
            .chain(tick.adapted.r_hat.iter());
        let mut numbers = numbers.chain(tick.measurement.chi.iter());
        assert!(numbers.all(|x| x.is_finite()), "tick {}", tick.index);
        assert!(
            tick.adapted.frozen || tick.fault.is_none(),
            "the adapter learned from tick {}",
            tick.index
        );
    }
    let told = |range: std::ops::Range<usize>| {
        ticks[range]
            .iter()
            .flat_map(|tick| &tick.events)
            .filter(|event| event.kind == EventKind::Fault)
            .count()
    };
    assert_eq!(
        (told(0..150), told(150..160), told(160..350)),
        (0, 1, 1),
        "the operator is told of begin and end"
    );
    let start =
        ticks[100].truth.as_ref().expect("it is simulated").chi.fixed_rows::<3>(0).into_owned();
    for tick in &ticks[100..] {
        let place =
            tick.truth.as_ref().expect("it is simulated").chi.fixed_rows::<3>(0).into_owned();
        assert!(
            (place - start).norm() < STRAY_M,
            "tick {}: {:.2} m away",
            tick.index,
            (place - start).norm()
        );
    }
}

#[test]
fn broken_measurements_become_a_fault_and_reach_no_actuator() {
    let breaks: [fn(&mut Measurement); 5] = [
        |measurement| measurement.chi[0] = f64::NAN,
        |measurement| measurement.chi_dot[4] = f64::INFINITY,
        |measurement| measurement.chi_ddot[7] = f64::NAN,
        |measurement| measurement.tau_applied[2] = f64::NEG_INFINITY,
        |measurement| measurement.chi = Coords::repeat(f64::NAN).into(),
    ];
    for breaks in breaks {
        let (parts, commands) = parts(breaks);
        check(&fly(parts), &commands, Fault::NonFiniteMeasurement);
    }
}

#[test]
fn broken_forecasts_become_a_fault_and_reach_no_actuator() {
    let breaks: [fn(&mut Forecast); 4] = [
        |forecast| forecast.base[0][2] = f64::NAN,
        |forecast| forecast.base.last_mut().expect("a horizon")[0] = f64::INFINITY,
        |forecast| forecast.regime[3] = f64::NAN,
        |forecast| forecast.base.clear(),
    ];
    for breaks in breaks {
        let (mut parts, commands) = parts(|_| {});
        parts.predictor = Box::new(Dreaming { predictor: parts.predictor, breaks, ticks: 0 });
        check(&fly(parts), &commands, Fault::NonFinitePrediction);
    }
}

/// A source that has never measured anything.
#[derive(Clone)]
struct Dead;
impl Source for Dead {
    fn advance(&mut self, setpoint: &Setpoint, inner: &mut dyn InnerLoop) -> Measurement {
        let state = InnerState {
            eta: nalgebra::Vector3::zeros(),
            eta_dot: nalgebra::Vector3::zeros(),
            joint: setpoint.joint_des,
            joint_dot: nalgebra::Vector2::zeros(),
        };
        let command = inner.command(setpoint, &state);
        assert!(
            command.rotor_thrust_n.iter().chain(&command.joint_torque_n_m).all(|x| x.is_finite())
        );
        Measurement {
            t_s: 0.0,
            chi: Coords::repeat(f64::NAN).into(),
            chi_dot: Coords::repeat(f64::NAN).into(),
            chi_ddot: Coords::repeat(f64::NAN).into(),
            tau_applied: Coords::repeat(f64::NAN).into(),
            gripper: twin_core::tick::GripperReading::default(),
            payload: None,
            saturated: false,
            airborne: true,
        }
    }

    fn truth(&self) -> Option<Truth> {
        None
    }

    fn disturb(&mut self, _disturbance: &Disturbance) {}
}

#[test]
fn a_source_that_is_broken_from_its_first_tick_gets_finite_commands() {
    let mut parts = scenario("hover", &[]).parts().expect("it builds");
    parts.source = Box::new(Dead);
    for tick in fly(parts) {
        assert_eq!(tick.fault, Some(Fault::NonFiniteMeasurement));
        assert_eq!(tick.measurement.chi.len(), N);
        assert!(
            tick.setpoint
                .r_hat
                .iter()
                .chain(&tick.setpoint.force_in_world_n)
                .all(|x| x.is_finite())
        );
    }
}
