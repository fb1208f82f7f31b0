//! The parts from which a flight is assembled, and the stages of its tick. In and out: plain values; no state.

use super::Trigger;
use crate::control::{Controller, InnerController};
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
    /// Length of the history for the predictor, ticks.
    pub history_len: usize,
    /// Period of residual, adapter and control law, ticks (1 is 100 Hz).
    pub outer_divisor: u64,
}
