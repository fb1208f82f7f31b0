//! What to fly: a task turns measurements into references, and says when a phase ends.
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

use nalgebra::{Isometry3, Vector2, Vector3};

use crate::notation::KnownCoords;
use crate::tick::{Event, Measurement, Reference};

pub use excitation::{Excitation, Region};
pub use follow::FollowPath;
pub use hover::Hover;
pub use pick_place::{PickPlace, PickPlacePlan};

/// What a task sees at one tick.
pub struct View<'a> {
    /// Measurement of this tick.
    pub measurement: &'a Measurement,
    /// Measured residual `r_t`, N and N m.
    pub residual: &'a KnownCoords,
}

/// What a task says at one tick.
#[derive(Clone, Debug)]
pub struct Step {
    /// What to fly now.
    pub reference: Reference,
    /// Name of the phase.
    pub phase: &'static str,
    /// What happened.
    pub events: Vec<Event>,
    /// The task is done.
    pub finished: bool,
    /// Why the task cannot be done, if it gave up.
    pub gave_up: Option<String>,
}

/// Where the vehicle's arm holds its tool: all that a task needs to know of the vehicle's geometry.
pub trait ToolKinematics: std::fmt::Debug + Send + Sync {
    /// `body_from_tool` at the joint angles `q = [q1 q2]`, rad; translation in m.
    fn tool_in_body(&self, q: &Vector2<f64>) -> Isometry3<f64>;

    /// Velocity of the tool relative to the body, in the body frame, m/s, at the joint angles `q`, rad, and rates `q_dot`, rad/s.
    fn tool_velocity_in_body(&self, q: &Vector2<f64>, q_dot: &Vector2<f64>) -> Vector3<f64>;
}

/// Something to fly; deterministic.
pub trait Task: Send {
    /// One tick of `dt_s`.
    fn update(&mut self, view: &View<'_>, dt_s: f64) -> Step;
}
