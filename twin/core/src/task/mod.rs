//! Tasks: a task turns measurements into references and decides when a phase ends.
//!
//! In: measurement and measured residual. Out: [`Step`] with the [`Reference`] of this tick. Tasks see measured signals only,
//! never the truth.

pub mod quintic;
pub mod motion;
pub mod path;
pub mod hover;
pub mod follow;
pub mod pick_place;
pub mod excitation;

use dyn_clone::{DynClone, clone_trait_object};
use nalgebra::{Isometry3, Vector2, Vector3};

use crate::notation::KnownCoords;
use crate::tick::{Event, Measurement, Reference};

pub use excitation::{Excitation, Region};
pub use follow::FollowPath;
pub use hover::Hover;
pub use pick_place::{PickPlace, PickPlacePlan};

/// Input of a task at one tick.
pub struct View<'a> {
    /// Measurement of this tick.
    pub measurement: &'a Measurement,
    /// Measured residual `r_t`, N and N m.
    pub residual: &'a KnownCoords,
}

/// Output of a task at one tick.
#[derive(Clone, Debug)]
pub struct Step {
    /// Desired motion of this tick.
    pub reference: Reference,
    /// Name of the phase.
    pub phase: &'static str,
    /// Events of this tick.
    pub events: Vec<Event>,
    /// True if the task is done.
    pub finished: bool,
    /// Why the task cannot be done, if it gave up.
    pub gave_up: Option<String>,
}

/// Kinematics of the arm's tool, the only part of the vehicle's geometry that a task needs.
pub trait ToolKinematics: std::fmt::Debug + Send + Sync {
    /// `body_from_tool` at the joint angles `q = [q1 q2]`, rad; translation in m.
    fn tool_in_body(&self, q: &Vector2<f64>) -> Isometry3<f64>;

    /// Velocity of the tool relative to the body, in the body frame, m/s, at the joint angles `q`, rad, and rates `q_dot`, rad/s.
    fn tool_velocity_in_body(&self, q: &Vector2<f64>, q_dot: &Vector2<f64>) -> Vector3<f64>;
}

/// A task to fly; deterministic.
///
/// Example: a quarter of a turn on the spot, which ends as soon as the measured heading arrives.
///
/// ```
/// use std::f64::consts::FRAC_PI_2;
/// use twin_core::task::motion::{Motion, Posture};
/// use twin_core::task::{Step, Task, View};
/// use twin_core::tick::GripperCommand;
/// # use twin_core::{fixture, notation::TICK_S};
///
/// const RATE_RAD_S: f64 = 0.5;
///
/// #[derive(Clone)]
/// struct QuarterTurn {
///     yaw_rad: f64,
/// }
///
/// impl Task for QuarterTurn {
///     fn update(&mut self, view: &View<'_>, dt_s: f64) -> Step {
///         self.yaw_rad = (self.yaw_rad + RATE_RAD_S * dt_s).min(FRAC_PI_2);
///         let turning = self.yaw_rad < FRAC_PI_2;
///         let posture = Posture::new(0.0, 0.0, 1.0, self.yaw_rad, 0.0, 0.0);
///         let mut reference = Motion::new(posture).reference(GripperCommand::Open);
///         reference.chi_des_dot[5] = if turning { RATE_RAD_S } else { 0.0 };
///         let phase = if turning { "turn" } else { "hold" };
///         let finished = !turning && (view.measurement.chi[5] - FRAC_PI_2).abs() < 0.01;
///         Step { reference, phase, events: Vec::new(), finished, gave_up: None }
///     }
/// }
///
/// // A vehicle that is always where it was asked to be: a quarter of a turn at 0.5 rad/s takes 3.14 s.
/// # let residual = fixture::tick(0).residual;
/// let mut measurement = fixture::tick(0).measurement;
/// let mut task = QuarterTurn { yaw_rad: 0.0 };
/// let ticks = (1..1000).find(|_| {
///     let step = task.update(&View { measurement: &measurement, residual: &residual }, TICK_S);
///     measurement.chi = step.reference.chi_des;
///     step.finished
/// });
/// assert_eq!(ticks, Some(315));
/// ```
pub trait Task: DynClone + Send {
    /// One tick of `dt_s`.
    fn update(&mut self, view: &View<'_>, dt_s: f64) -> Step;
}

clone_trait_object!(Task);
