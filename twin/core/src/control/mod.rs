//! Control laws that compute `tau`; they are total functions that cannot fail. An outer law computes a [`Setpoint`] at 100 Hz, and the
//! inner controller turns it into rotor thrusts and joint torques at 500 Hz.

pub mod gains;
pub mod delays;
pub mod compensation;
pub mod adaptive;
pub mod pid;
pub mod l1;
pub mod excited;
pub mod attitude;
pub mod allocation;
pub mod inner;
pub mod safe_set;

use dyn_clone::{DynClone, clone_trait_object};
use nalgebra::Vector3;

use crate::notation::Coords;
use crate::tick::{ControlState, Measurement, Reference, Setpoint};

pub use adaptive::Adaptive;
pub use allocation::{Allocation, Rotor};
pub use delays::LoopDelays;
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
    /// Desired motion.
    pub reference: &'a Reference,
    /// Adapted residual estimate, N and N m; finite.
    pub r_hat: &'a Coords,
    /// Measured residual of this tick, N and N m; finite.
    pub residual: &'a Coords,
    /// Gravity force of the vehicle without payload, N and N m.
    pub nominal_gravity: &'a Coords,
    /// Desired attitude and its rate from the command filter of the inner controller, rad and rad/s.
    pub desired_attitude: (Vector3<f64>, Vector3<f64>),
    /// Control period, s.
    pub dt_s: f64,
}

/// An outer control law.
///
/// A proportional and derivative law that lets the estimated residual carry the weight:
///
/// ```
/// use nalgebra::{Vector2, Vector3};
/// use twin_core::control::{Controller, Gains, Input};
/// use twin_core::notation::{Coords, position, tracking_error};
/// use twin_core::tick::{ControlState, Setpoint};
/// # use twin_core::{control::Preset, fixture, notation::TICK_S};
///
/// #[derive(Clone)]
/// struct Pd;
///
/// impl Controller for Pd {
///     fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState) {
///         let (measured, asked) = (input.measurement, input.reference);
///         let mut chi_des = *asked.chi_des;
///         chi_des.fixed_rows_mut::<3>(3).copy_from(&input.desired_attitude.0);
///         let e = tracking_error(&measured.chi, &chi_des);
///         let e_dot = *measured.chi_dot - *asked.chi_des_dot;
///         let tau = input.r_hat - 18.0 * e - 12.0 * e_dot; // 18 N/m and 12 N s/m
///         let joints = |chi: &Coords| Vector2::new(chi[6], chi[7]);
///         let setpoint = Setpoint {
///             force_in_world_n: position(&tau),
///             yaw_des: [asked.chi_des[5], asked.chi_des_dot[5], asked.chi_des_ddot[5]],
///             joint_des: joints(&asked.chi_des),
///             joint_des_dot: joints(&asked.chi_des_dot),
///             joint_des_ddot: joints(&asked.chi_des_ddot),
///             r_hat: *input.r_hat,
///             sliding_norm: 0.0,
///             robust_gain: 0.0,
///             rows: gains.rows(),
///             gripper: asked.gripper,
///         };
///         let sliding = Coords::zeros().into();
///         (setpoint, ControlState { error: e.into(), sliding, robust_gain: 0.0 })
///     }
/// }
///
/// // At rest, 0.2 m too far along x; the weight of the vehicle is 29.43 N.
/// # let (mut measurement, reference) = (fixture::tick(0).measurement, fixture::tick(0).reference);
/// # (measurement.chi, measurement.chi_dot) = (reference.chi_des, reference.chi_des_dot);
/// measurement.chi[0] += 0.2;
/// let weight = Coords::from([0.0, 0.0, 29.43, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// # let input = Input { measurement: &measurement, reference: &reference, r_hat: &weight, residual: &weight,
/// #     nominal_gravity: &weight, desired_attitude: (Vector3::zeros(), Vector3::zeros()), dt_s: TICK_S };
/// let (setpoint, _) = Pd.control(&input, &Gains::preset(Preset::Tuned));
/// let wanted = Vector3::new(-18.0 * 0.2, 0.0, 29.43); // against the error, and up
/// assert!((setpoint.force_in_world_n - wanted).norm() < 1e-12);
/// ```
pub trait Controller: DynClone + Send {
    /// The set-point until the next tick, and the internal values that an operator wants to see.
    fn control(&mut self, input: &Input<'_>, gains: &Gains) -> (Setpoint, ControlState);
}

clone_trait_object!(Controller);
