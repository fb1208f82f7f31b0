//! Where measurements come from: the simulated vehicle, or a recorded or live one.
//!
//! In: a [`Setpoint`] and the pure inner loop. Out: a [`Measurement`] one tick later.

use dyn_clone::{DynClone, clone_trait_object};
use nalgebra::{Vector2, Vector3};

use crate::quantity::{self, Quantity};
use crate::tick::{ActuatorCommand, Measurement, Setpoint, Truth};

/// State that the inner controller reads, at 500 Hz.
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

impl InnerState {
    /// True if every angle and rate is finite.
    pub fn is_finite(&self) -> bool {
        let attitude = self.eta.iter().chain(&self.eta_dot);
        attitude.chain(self.joint.iter()).chain(&self.joint_dot).all(|x| x.is_finite())
    }
}

/// The inner controller with allocation: pure; the source calls it every `inner_period_s`.
pub trait InnerLoop {
    /// The actuator command for this state; total, never fails, finite for finite input.
    fn command(&mut self, setpoint: &Setpoint, state: &InnerState) -> ActuatorCommand;
}

/// A source of measurements that can be flown or replayed.
///
/// Example: a point mass, integrated by hand. It has no attitude, so the force acts at once, and it calls no inner controller.
///
/// ```
/// # use nalgebra::{Vector2, Vector3};
/// # use twin_core::{control::{Allocation, InnerController, Rotor}, fixture};
/// use twin_core::notation::{Coords, GRAVITY_M_S2, N, TICK_S};
/// use twin_core::source::{Disturbance, InnerLoop, Source};
/// use twin_core::tick::{GripperReading, Measurement, Setpoint, Truth};
///
/// const MASS_KG: f64 = 2.0;
/// #[derive(Clone)]
/// struct PointMass {
///     t_s: f64,
///     chi: Coords,
///     chi_dot: Coords,
/// }
///
/// impl Source for PointMass {
///     fn advance(&mut self, setpoint: &Setpoint, _: &mut dyn InnerLoop) -> Measurement {
///         let tau = setpoint.force_in_world_n.fixed_resize::<N, 1>(0.0);
///         let mut chi_ddot = tau / MASS_KG;
///         chi_ddot[2] -= GRAVITY_M_S2;
///         // Exact, because the force is constant during a tick.
///         self.chi += self.chi_dot * TICK_S + chi_ddot * (TICK_S * TICK_S / 2.0);
///         self.chi_dot += chi_ddot * TICK_S;
///         self.t_s += TICK_S;
///         Measurement {
///             t_s: self.t_s,
///             chi: self.chi.into(),
///             chi_dot: self.chi_dot.into(),
///             chi_ddot: chi_ddot.into(), // nothing is noisy, so neither this nor the force passes H
///             tau_applied: tau.into(),
///             gripper: GripperReading::default(),
///             payload: None,
///             saturated: false,
///             airborne: true,
///         }
///     }
///
///     fn truth(&self) -> Option<Truth> { None }
///     fn disturb(&mut self, _: &Disturbance) {}
/// }
/// # let rotor = Rotor { position_in_body: Vector3::zeros(), torque_per_thrust_m: 0.0 };
/// # let mut inner = InnerController::new(Allocation::new(&[rotor], 0., 0.), Vector3::zeros(), Vector2::zeros(), 0., 0.002);
/// // Without force it falls g t²/2 in t = 1 s.
/// let setpoint = Setpoint { force_in_world_n: Vector3::zeros(), ..fixture::tick(0).setpoint };
/// let mut mass = PointMass { t_s: 0.0, chi: Coords::zeros(), chi_dot: Coords::zeros() };
/// let fallen = (0..100).map(|_| mass.advance(&setpoint, &mut inner)).last().expect("100 ticks");
/// assert!((fallen.chi[2] + GRAVITY_M_S2 / 2.0).abs() < 1e-12);
/// ```
pub trait Source: DynClone {
    /// Advances one tick under `setpoint`, calls `inner` at its own rate, and measures.
    fn advance(&mut self, setpoint: &Setpoint, inner: &mut dyn InnerLoop) -> Measurement;

    /// The true state after the last advance; `None` if the source does not know it.
    fn truth(&self) -> Option<Truth>;

    /// Applies a change that an operator or a scenario asked for, between two ticks.
    fn disturb(&mut self, disturbance: &Disturbance);
}

clone_trait_object!(Source);

/// Names of the effects that [`Disturbance::Effect`] switches: air, then vehicle, then links.
pub const EFFECTS: [&str; 14] = [
    "inflow",
    "flapping",
    "rotor_drag",
    "body_drag",
    "ground_effect",
    "recirculation",
    "downwash",
    "unsteady",
    "wind",
    "mismatch",
    "battery",
    "servo",
    "link",
    "mocap_link",
];

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
    /// Switches one effect on or off.
    Effect {
        /// One of [`EFFECTS`].
        name: String,
        /// True switches it on.
        on: bool,
    },
    /// A part of the vehicle fails or works again.
    Failure {
        /// What fails.
        failure: Failure,
        /// True if the failure begins, false if it ends.
        on: bool,
    },
}

/// How a part of the vehicle fails. A second failure of the same kind replaces the first; the end of either ends both.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Failure {
    /// Motion capture sees nothing.
    MocapLoss,
    /// Motion capture reports the base displaced in the world.
    MocapOutlier {
        /// `[x y z]`, m.
        offset_m: [f64; 3],
    },
    /// The IMU's biases jump, in the body frame.
    ImuBias {
        /// Accelerometer, m/s².
        accelerometer_m_s2: [f64; 3],
        /// Gyro, rad/s.
        gyro_rad_s: [f64; 3],
    },
    /// The joint encoders repeat their last angle and report no fresh rate.
    EncoderDropout,
    /// A rotor gives only a part of its thrust.
    MotorEfficiency {
        /// Index of the rotor, from 0.
        rotor: usize,
        /// Actual thrust divided by the thrust of a healthy rotor.
        factor: f64,
    },
    /// The friction between pads and payload changes.
    GripperSlip {
        /// Coefficient of friction during the failure.
        friction: f64,
    },
    /// A gust is added to the scenario's wind.
    Gust {
        /// `[x y z]` in the world, m/s.
        velocity_m_s: [f64; 3],
    },
    /// The actuators keep the last command of the inner controller.
    ComputerStall,
    /// The predictor answers NaN.
    PredictorNan,
}

impl Failure {
    /// A few words for the event on the tick.
    pub fn words(&self) -> &'static str {
        match self {
            Self::MocapLoss => "motion capture lost",
            Self::MocapOutlier { .. } => "motion capture displaced",
            Self::ImuBias { .. } => "IMU bias",
            Self::EncoderDropout => "joint encoders dead",
            Self::MotorEfficiency { .. } => "rotor weak",
            Self::GripperSlip { .. } => "grip slippery",
            Self::Gust { .. } => "gust",
            Self::ComputerStall => "control computer stalled",
            Self::PredictorNan => "predictor answers NaN",
        }
    }
}

impl Disturbance {
    /// Every number of it that a client may set, with its quantity; a failure has none, because only a scenario sets its numbers.
    pub fn numbers(&self) -> Vec<(&'static Quantity, f64)> {
        let each = |quantity, values: &[f64]| values.iter().map(|v| (quantity, *v)).collect();
        match self {
            Self::PayloadMass { kg } => vec![(&quantity::PAYLOAD_MASS, *kg)],
            Self::Wind { velocity_m_s } => each(&quantity::WIND, velocity_m_s),
            Self::Push { force_n, duration_s } => {
                let mut numbers: Vec<_> = each(&quantity::PUSH_FORCE, force_n);
                numbers.push((&quantity::PUSH_DURATION, *duration_s));
                numbers
            }
            Self::DropPayload | Self::Effect { .. } | Self::Failure { .. } => Vec::new(),
        }
    }

    /// One sentence for people.
    pub fn sentence(&self) -> String {
        match self {
            Disturbance::PayloadMass { kg } => format!("payload is now {:.0} g", kg * 1e3),
            Disturbance::Wind { velocity_m_s: v } => {
                format!("wind is now [{:.1} {:.1} {:.1}] m/s", v[0], v[1], v[2])
            }
            Disturbance::Push { force_n: f, duration_s } => {
                format!("push of [{:.1} {:.1} {:.1}] N for {duration_s:.2} s", f[0], f[1], f[2])
            }
            Disturbance::DropPayload => "payload dropped".to_owned(),
            Disturbance::Effect { name, on } => {
                format!("{name} switched {}", if *on { "on" } else { "off" })
            }
            Disturbance::Failure { failure, on: true } => format!("failure: {}", failure.words()),
            Disturbance::Failure { failure, .. } => format!("over: {}", failure.words()),
        }
    }
}
