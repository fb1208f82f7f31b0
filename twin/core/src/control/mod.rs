//! What makes `tau`: total functions that cannot fail. An outer law makes a [`Setpoint`] at 100 Hz, the inner rows turn it
//! into rotor thrusts and joint torques at 500 Hz.

pub mod gains;
pub mod compensation;
pub mod adaptive;
pub mod pid;
pub mod l1;
pub mod excited;
pub mod attitude;
pub mod allocation;
pub mod inner;
pub mod safe_set;

use nalgebra::Vector3;

use crate::notation::Coords;
use crate::tick::{ControlState, Measurement, Reference, Setpoint};

pub use adaptive::Adaptive;
pub use allocation::{Allocation, Rotor};
pub use excited::{Excited, Multisine};
pub use gains::{Gains, Preset};
pub use inner::InnerController;
pub use l1::{L1, L1Settings};
pub use pid::Pid;
pub use safe_set::SafeSet;

/// What an outer law sees at one tick.
pub struct Input<'a> {
    /// Measurement of this tick; finite (the flight checked it).
    pub measurement: &'a Measurement,
    /// What to fly.
    pub reference: &'a Reference,
    /// Adapted residual estimate, N and N m; finite.
    pub r_hat: &'a Coords,
    /// Measured residual of this tick, N and N m; finite.
    pub residual: &'a Coords,
    /// Gravity force of the vehicle without payload, N and N m.
    pub nominal_gravity: &'a Coords,
    /// Desired attitude and its rate from the command filter of the inner rows, rad and rad/s.
    pub desired_attitude: (Vector3<f64>, Vector3<f64>),
    /// Control period, s.
    pub dt_s: f64,
}

/// An outer control law.
pub trait Controller: Send {
    /// The set-point until the next tick, and what an operator wants to see of how it came about.
    fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState);
}
