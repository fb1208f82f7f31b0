//! Where measurements come from: the simulated vehicle, or a recorded or live one.
//!
//! In: a [`Setpoint`] and the pure inner loop. Out: a [`Measurement`] one tick later.

use nalgebra::{Vector2, Vector3};

use crate::tick::{ActuatorCommand, Measurement, Setpoint, Truth};

/// What the inner rows see, at 500 Hz.
#[derive(Clone, Copy, Debug)]
pub struct InnerState {
    /// Measured attitude `[phi theta psi]`, rad, `psi` unwrapped.
    pub eta: Vector3<f64>,
    /// Measured Euler rates, rad/s.
    pub eta_dot: Vector3<f64>,
    /// Measured joint angles, rad.
    pub joint: Vector2<f64>,
    /// Measured joint rates, rad/s.
    pub joint_dot: Vector2<f64>,
}

/// Attitude and joint rows with allocation: pure, called by the source every `inner_period_s`.
pub trait InnerLoop {
    /// The command for this instant; total, never fails, finite for finite input.
    fn command(&mut self, setpoint: &Setpoint, state: &InnerState) -> ActuatorCommand;
}

/// Something that can be flown or replayed.
pub trait Source {
    /// Advances one tick under `setpoint`, running `inner` at its own rate, and measures.
    fn advance(&mut self, setpoint: &Setpoint, inner: &mut dyn InnerLoop) -> Measurement;

    /// The true state after the last advance; `None` where nobody knows it.
    fn truth(&self) -> Option<Truth>;

    /// Applies a change that an operator or a scenario asked for, between two ticks.
    fn disturb(&mut self, disturbance: &Disturbance);
}

/// A change of the world between two ticks.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Disturbance {
    /// Mass of the payload, kg.
    PayloadMass {
        /// New mass, kg.
        kg: f64,
    },
    /// Mean wind in the world, m/s.
    Wind {
        /// `[x y z]`, m/s.
        velocity_m_s: [f64; 3],
    },
    /// A push on the base for a time.
    Push {
        /// Force in the world, N.
        force_n: [f64; 3],
        /// How long it lasts, s.
        duration_s: f64,
    },
    /// Removes the payload from the gripper at once (the drop of `reset_demo`).
    DropPayload,
    /// Switches one aerodynamic effect on or off.
    Effect {
        /// `rotor_drag`, `body_drag`, `ground_effect`, `downwash` or `wind`.
        name: String,
        /// In force or not.
        on: bool,
    },
}
