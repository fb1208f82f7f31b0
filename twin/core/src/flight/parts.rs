//! What a flight is put together from, and the stages of its tick. In and out: plain values; no state.

use super::Trigger;
use crate::control::{Controller, Rows};
use crate::residual::lra::Adapter;
use crate::residual::{GravityModel, Predictor};
use crate::source::{Disturbance, Source};
use crate::task::Task;
use crate::tick::Setpoint;
use crate::tuning::Tuning;

/// A stage of one tick, for whoever measures where the time goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The source advanced: plant, sensors, estimator, inner rows.
    Source,
    /// Residual, history and base forecast.
    Predict,
    /// Task and reference.
    Task,
    /// Latent Residual Adapter.
    Adapt,
    /// Control law.
    Control,
    /// The tick is put together.
    Record,
}

/// The parts a flight is made of.
pub struct Parts {
    /// The vehicle.
    pub source: Box<dyn Source + Send>,
    /// Base forecast.
    pub predictor: Box<dyn Predictor>,
    /// Latent Residual Adapter.
    pub adapter: Adapter,
    /// Outer law.
    pub controller: Box<dyn Controller>,
    /// Inner rows.
    pub rows: Rows,
    /// What to fly.
    pub task: Box<dyn Task>,
    /// Gravity of the vehicle without payload.
    pub gravity: GravityModel,
    /// Values in force at the start.
    pub tuning: Tuning,
    /// Changes of the world by time, s.
    pub schedule: Vec<(f64, Disturbance)>,
    /// Changes of the world that wait for something to come to pass.
    pub triggers: Vec<Trigger>,
    /// First set-point, before anything was measured.
    pub setpoint: Setpoint,
    /// Ticks of history a predictor may look back.
    pub history_len: usize,
    /// Residual, adapter and control law run every so many ticks (1: at 100 Hz).
    pub outer_divisor: u64,
}
