//! The parts from which a flight is assembled, and the stages of its tick. In and out: plain values; no state.

use super::Trigger;
use crate::control::{Controller, InnerController, LoopDelays};
use crate::residual::lra::Adapter;
use crate::residual::{GravityModel, Predictor};
use crate::source::{Disturbance, Source};
use crate::task::Task;
use crate::tick::Setpoint;
use crate::tuning::Tuning;

/// A stage of one tick, for callers that measure the time of each stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The source advanced: plant, sensors, estimator, inner controllers.
    Source,
    /// Residual, history and base forecast.
    Predict,
    /// Task and reference.
    Task,
    /// Latent Residual Adapter.
    Adapt,
    /// Control law.
    Control,
    /// The tick was assembled.
    Record,
}

/// The parts of a flight.
///
/// Four parts that were written for it fly 100 ticks. They are shorter than their like at [`Source`], [`Predictor`], [`Controller`]
/// and [`Task`], and hidden here except for their names:
///
/// ```
/// # use nalgebra::Vector3;
/// # use twin_core::control::{Allocation, Controller, Gains, InnerController, Input, LoopDelays, Preset, Rotor};
/// # use twin_core::residual::{HORIZON, History, NOMINAL_SCALE, Predictor, lra};
/// # use twin_core::task::motion::{Motion, Posture};
/// # use twin_core::task::{Step, Task, View};
/// # use twin_core::{fixture, flight::{Flight, Parts}, notation::*, source::*, tick::*, tuning::Tuning};
/// #[derive(Clone)]
/// struct PointMass(Measurement); // 2 kg
/// # impl Source for PointMass {
/// #     fn advance(&mut self, setpoint: &Setpoint, _: &mut dyn InnerLoop) -> Measurement {
/// #         let (now, tau) = (&mut self.0, setpoint.force_in_world_n.fixed_resize::<N, 1>(0.0));
/// #         let mut chi_ddot = tau / 2.0;
/// #         chi_ddot[2] -= GRAVITY_M_S2;
/// #         now.chi = (*now.chi + *now.chi_dot * TICK_S + chi_ddot * (TICK_S * TICK_S / 2.0)).into();
/// #         now.chi_dot = (*now.chi_dot + chi_ddot * TICK_S).into();
/// #         (now.chi_ddot, now.tau_applied) = (chi_ddot.into(), tau.into());
/// #         now.clone()
/// #     }
/// #     fn truth(&self) -> Option<Truth> { None }
/// #     fn disturb(&mut self, _: &Disturbance) {}
/// # }
/// #[derive(Clone)]
/// struct SameAgain; // expects the last residual
/// # impl Predictor for SameAgain {
/// #     fn regime_len(&self) -> usize { 0 }
/// #     fn predict(&mut self, history: &History) -> Forecast {
/// #         let last = history.newest().map_or_else(Coords::zeros, |entry| entry.residual_previous);
/// #         Forecast { base: vec![last.into(); HORIZON + 1], regime: Vec::new(), attention: Vec::new() }
/// #     }
/// # }
/// #[derive(Clone)]
/// struct Pd(Setpoint); // critically damped, 8 rad/s
/// # impl Controller for Pd {
/// #     fn control(&mut self, input: &Input<'_>, _: &Gains) -> (Setpoint, ControlState) {
/// #         let e = *input.measurement.chi - *input.reference.chi_des;
/// #         let tau = input.r_hat - 128.0 * e - 32.0 * *input.measurement.chi_dot;
/// #         let state = ControlState { error: e.into(), sliding: Coords::zeros().into(), robust_gain: 0.0 };
/// #         (Setpoint { force_in_world_n: position(&tau), ..self.0 }, state)
/// #     }
/// # }
/// #[derive(Clone)]
/// struct Rise(Motion); // stays at its goal
/// # impl Task for Rise {
/// #     fn update(&mut self, view: &View<'_>, _: f64) -> Step {
/// #         let reference = self.0.reference(GripperCommand::Open);
/// #         let finished = (view.measurement.chi[2] - reference.chi_des[2]).abs() < 0.001;
/// #         Step { reference, phase: "rise", events: Vec::new(), finished, gave_up: None }
/// #     }
/// # }
/// # let Tick { mut measurement, setpoint, .. } = fixture::tick(0);
/// # (measurement.chi, measurement.chi_dot) = (Coords::zeros().into(), Coords::zeros().into());
/// # let rotor = Rotor { position_in_body: Vector3::zeros(), torque_per_thrust_m: 0.0 };
/// # let allocation = Allocation::new(&[rotor], 0.0, 0.0);
/// # let inner = InnerController::new(allocation, Vector3::zeros(), Default::default(), 0.0, 0.002);
/// let goal = Posture::new(0.0, 0.0, 0.1, 0.0, 0.0, 0.0);
/// let tuning = Tuning { gains: Gains::preset(Preset::Tuned), adapter: lra::Settings::default() };
/// let mut flight = Flight::new(Parts {
///     source: Box::new(PointMass(measurement)),
///     predictor: Box::new(SameAgain),
///     adapter: lra::Adapter::new(0, Coords::from(NOMINAL_SCALE), &tuning.adapter),
///     controller: Box::new(Pd(setpoint)),
///     inner,
///     task: Box::new(Rise(Motion::new(goal))),
///     gravity: std::sync::Arc::new(|_| Coords::zeros()), // no model knows the weight
///     tuning,
///     schedule: Vec::new(),
///     triggers: Vec::new(),
///     setpoint,
///     delays: LoopDelays::default(),
///     history_len: 1,
///     outer_divisor: 1,
/// });
/// let tick = (0..100).map(|_| flight.tick()).last().expect("100 ticks");
/// // The nominal inertia is 2 kg, too, so the residual is the weight.
/// assert!((tick.adapted.r_hat[2] - 2.0 * GRAVITY_M_S2).abs() < 1e-12);
/// // Of 0.1 m the exact solution leaves (1 + 8) exp(-8) = 0.3 % after 1 s; the first ticks and the delay of one tick change little.
/// assert!((tick.measurement.chi[2] - 0.1).abs() < 0.0005 && tick.finished);
/// ```
#[derive(Clone)]
pub struct Parts {
    /// The source: a simulated, recorded or live vehicle.
    pub source: Box<dyn Source + Send>,
    /// The predictor, which gives the base forecast.
    pub predictor: Box<dyn Predictor>,
    /// Latent Residual Adapter.
    pub adapter: Adapter,
    /// The outer control law.
    pub controller: Box<dyn Controller>,
    /// The inner controllers.
    pub inner: InnerController,
    /// The task, which says what to fly.
    pub task: Box<dyn Task>,
    /// Model of the gravity force of the vehicle without payload.
    pub gravity: GravityModel,
    /// Values in force at the start.
    pub tuning: Tuning,
    /// Disturbances by time, s.
    pub schedule: Vec<(f64, Disturbance)>,
    /// Disturbances that wait for a condition.
    pub triggers: Vec<Trigger>,
    /// The set-point before the first measurement.
    pub setpoint: Setpoint,
    /// Delays of the loop, which the compensation looks ahead over.
    pub delays: LoopDelays,
    /// Length of the history for the predictor, ticks.
    pub history_len: usize,
    /// Period of residual, adapter and control law, ticks (1 is 100 Hz).
    pub outer_divisor: u64,
}
