//! Every record that crosses a stage of the loop. A [`Tick`] is one control period, built once at its end and never changed: recorder,
//! browser, verdict and tests all read this record.
//!
//! A value that the source does not provide is unknown in the record itself, per coordinate ([`KnownCoords`]).
//!
//! No record here contains wall-clock time, so two runs of one seed are equal bit for bit.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::force_budget::ForceBudget;
use crate::foreseen::Foreseen;
use crate::notation::{Coords, KnownCoords, KnownMask, PerRotor, known_in_both};

/// Measurement of one control period: the input of every stage after the source.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Simulated (or recorded) time at the end of the period, s.
    pub t_s: f64,
    /// Estimated coordinates, `psi` unwrapped.
    pub chi: KnownCoords,
    /// Estimated rates.
    pub chi_dot: KnownCoords,
    /// Accelerations through `H`, the 2nd-order 8 Hz Butterworth at 1 kHz.
    pub chi_ddot: KnownCoords,
    /// Applied generalised force (rotor delay and lag modelled, actual thrust axis) through the same `H`, N and N m.
    pub tau_applied: KnownCoords,
    /// Gripper encoder.
    pub gripper: GripperReading,
    /// Payload pose by motion capture; `None` where nothing measures it.
    pub payload: Option<PayloadReading>,
    /// A rotor or a joint reached its limit during the period.
    pub saturated: bool,
    /// The vehicle flies, according to its source; on the ground the residual would be the force of the floor.
    #[serde(default = "flies", skip_serializing_if = "is_true")]
    pub airborne: bool,
}

/// Default for recordings without this field: simulated flights, and those made before the field existed.
fn flies() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
fn is_true(value: &bool) -> bool {
    *value
}

impl Measurement {
    /// The coordinates in which a residual can be formed: force and acceleration are known, and the vehicle flies.
    pub fn residual_known(&self) -> KnownMask {
        let known = known_in_both(self.tau_applied.known(), self.chi_ddot.known());
        known.map(|known| known && self.airborne)
    }
}

/// Finger encoder of the gripper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GripperReading {
    /// Distance between the two pads, m.
    pub opening_m: f64,
    /// Rate of the distance between the pads, m/s.
    pub speed_m_s: f64,
}

/// Motion-capture pose of the payload.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PayloadReading {
    /// Centre of the payload in the world, m.
    pub position_in_world: Vector3<f64>,
    /// Heading of the payload, rad.
    pub yaw_rad: f64,
}

/// A pose in the format of the viewers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin in the world, m.
    pub position: [f64; 3],
    /// World-from-body quaternion, `[w x y z]`.
    pub quaternion_wxyz: [f64; 4],
}

/// One contact point with the force on the second body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Point in the world, m.
    pub point_in_world: [f64; 3],
    /// Normal plus friction force on the payload or the vehicle in the world, N.
    pub force_in_world_n: [f64; 3],
}

/// The true state, which only the simulated plant knows: for metrics, verdict and viewers, never for the loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// True coordinates.
    pub chi: Coords,
    /// True rates.
    pub chi_dot: Coords,
    /// Pose of every body in scene order: the vehicle's links as in the URDF, then the arena's moving bodies.
    pub poses: Vec<Pose>,
    /// Payload centre in the world, m.
    pub payload_position: Vector3<f64>,
    /// Tilt of the payload's z axis from vertical, rad.
    pub payload_tilt_rad: f64,
    /// Payload speed, m/s.
    pub payload_speed_m_s: f64,
    /// Payload centre in the palm frame, m: grasp slip is its change.
    pub payload_in_palm: Vector3<f64>,
    /// Sum of contact forces between fingers and payload (normal), N.
    pub grip_force_n: f64,
    /// Largest contact force on the vehicle, except through the fingers' pads, N.
    pub collision_force_n: f64,
    /// Wind at the vehicle in the world, m/s.
    pub wind_in_world: Vector3<f64>,
    /// Actual thrust of each rotor, N.
    pub rotor_thrust_n: PerRotor,
    /// Contact points with their forces.
    pub contacts: Vec<Contact>,
    /// The forces that accelerated the vehicle in this tick; `None` in recordings that were made before this field existed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub budget: Option<ForceBudget>,
}

/// Desired motion at this tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Desired coordinates; the command filter of the inner controller fills roll and pitch.
    pub chi_des: KnownCoords,
    /// Desired rates.
    pub chi_des_dot: KnownCoords,
    /// Desired accelerations.
    pub chi_des_ddot: Coords,
    /// Command to the gripper.
    pub gripper: GripperCommand,
    /// Freedom of the residual estimate at this tick.
    pub adaptation: Adaptation,
    /// The reference follows the measured pose (in contact only); transport metrics leave this tick out.
    pub follows_measurement: bool,
    /// The payload hangs in the gripper and moves with it: `rms_error_e8_transport` covers these ticks.
    pub transporting: bool,
    /// The path runs at its cruise speed: `transport_speed_m_s` covers these ticks.
    pub cruising: bool,
    /// Residual without the payload, N and N m, at the tick in which the payload is put down: estimate and adapter jump to it.
    pub release: Option<Coords>,
}

/// Freedom of the residual estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Adaptation {
    /// The estimate follows the adapter.
    #[default]
    Free,
    /// The estimate stays within a window around its value when the window began, so a finger that stands on something cannot wind it up.
    Bounded,
    /// The estimate is frozen in contact with box or table, and so are the adapter and its reset detector.
    Held,
}

/// Command to the gripper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GripperCommand {
    /// Keep the fingers open.
    #[default]
    Open,
    /// Close and squeeze with the gripper's force.
    Close,
}

/// Output of the predictor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// Base forecast `r_hat_base(t+j|t)` for `j = 0..=k`, N and N m; never empty. Known where the residual is.
    pub base: Vec<KnownCoords>,
    /// Regime latent `g'`, `d_k`; empty for predictors that have none.
    pub regime: Vec<f64>,
    /// Attention over the input channels, sums to one; empty for predictors that have none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attention: Vec<f64>,
}

/// Output of the Latent Residual Adapter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adapted {
    /// Adapted residual estimate of this tick, N and N m. It is known where the residual is known, and so are the following fields.
    pub r_hat: KnownCoords,
    /// The estimate before this tick's residual was known (a priori), N and N m: every prediction metric uses it.
    pub r_hat_prior: KnownCoords,
    /// A-priori innovation `eps_t` in the adapter's units (z-scored by default).
    pub innovation: KnownCoords,
    /// Norm of the exponential moving average of the innovation, compared with the reset threshold.
    pub innovation_mean_norm: f64,
    /// Trace of the covariance.
    pub covariance_trace: f64,
    /// Largest diagonal entry of the covariance.
    pub covariance_max: f64,
    /// Smallest diagonal entry of the covariance.
    pub covariance_min: f64,
    /// Norm of the gain `K`.
    pub gain_norm: f64,
    /// Frobenius norm of the weights `W`.
    pub weight_norm: f64,
    /// Constant part of the correction, N and N m.
    #[serde(default = "Coords::zeros")]
    pub bias: Coords,
    /// Correction of later ticks at the knots of [`crate::residual::horizon`], N and N m; empty if the horizon is not corrected.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub horizon: Vec<Coords>,
    /// The covariance was reset at this tick.
    pub reset: bool,
    /// The adapter was frozen at this tick.
    pub frozen: bool,
}

/// Set-point of the inner controller until the next tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setpoint {
    /// Desired force in the world, N.
    pub force_in_world_n: Vector3<f64>,
    /// Desired yaw, rad, with its rate and acceleration.
    pub yaw_des: [f64; 3],
    /// Desired joint angles, rad.
    pub joint_des: Vector2<f64>,
    /// Desired joint rates, rad/s.
    pub joint_des_dot: Vector2<f64>,
    /// Desired joint accelerations, rad/s².
    pub joint_des_ddot: Vector2<f64>,
    /// Residual estimate in force (low-passed and clipped), N and N m: it has a number in every coordinate, even where the residual is
    /// unknown.
    pub r_hat: Coords,
    /// Norm of the sliding variable, constant between ticks.
    pub sliding_norm: f64,
    /// Robust gain `sigma_hat`, constant between ticks.
    pub robust_gain: f64,
    /// Law and gains of the inner controller.
    pub rows: InnerGains,
    /// Gripper command.
    pub gripper: GripperCommand,
}

impl Setpoint {
    /// True if every number that is not a gain is finite.
    pub fn is_finite(&self) -> bool {
        let joints = [&self.joint_des, &self.joint_des_dot, &self.joint_des_ddot];
        let vectors = self.force_in_world_n.iter().chain(&self.r_hat).chain(&self.yaw_des);
        let scalars = [&self.sliding_norm, &self.robust_gain];
        vectors.chain(joints.into_iter().flatten()).chain(scalars).all(|x| x.is_finite())
    }
}

/// Control law of attitude and joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InnerLaw {
    /// The paper's law (`eq:control_input`) on attitude and joints.
    #[default]
    Rows,
    /// A PX4-like rate controller on attitude, the paper's law on the joints.
    RateLoop,
}

/// Gains of the inner controller, in coordinate order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InnerGains {
    /// Law on attitude.
    pub law: InnerLaw,
    /// Error slope `Phi`, 1/s.
    pub slope: Coords,
    /// Damping `Lambda`.
    pub damping: Coords,
    /// Nominal inertia `M_bar`.
    pub nominal_inertia: Coords,
    /// Below this norm of `s` the robust term is linear.
    pub boundary_layer: f64,
}

/// Last command to the actuators.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActuatorCommand {
    /// Thrust of each rotor, N.
    pub rotor_thrust_n: PerRotor,
    /// Joint torques, N m.
    pub joint_torque_n_m: Vector2<f64>,
    /// The allocation could not realise the whole command.
    pub saturated: bool,
}

impl ActuatorCommand {
    /// True if every thrust and torque is finite.
    pub fn is_finite(&self) -> bool {
        self.rotor_thrust_n.iter().chain(self.joint_torque_n_m.iter()).all(|x| x.is_finite())
    }
}

/// Internal values of the controller, for an operator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlState {
    /// Tracking error `e`, yaw wrapped; roll and pitch are compared with the command filter.
    pub error: KnownCoords,
    /// Sliding variable `s`.
    pub sliding: KnownCoords,
    /// Robust gain `sigma_hat`.
    pub robust_gain: f64,
}

/// Fault that makes a tick use a safer mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// A measurement was not finite: the last measurement stays in force.
    NonFiniteMeasurement,
    /// The attitude and joint rows had a non-finite state or command: their last command stays in force.
    NonFiniteCommand,
    /// The predictor or adapter returned a non-finite value: the nominal residual is used.
    NonFinitePrediction,
    /// `|theta| > 80°`: Euler angles are near their singularity.
    PitchBeyondRange,
}

/// Kind of an [`Event`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// The task entered a phase.
    Phase,
    /// The payload is gripped.
    Grasp,
    /// The payload is put down.
    Release,
    /// A pick attempt failed and is repeated.
    Retry,
    /// The covariance was reset.
    Reset,
    /// A gain changed.
    Gain,
    /// A scenario or an operator changed the payload or the wind.
    Disturbance,
    /// A fault began or ended.
    Fault,
    /// The rotors were saturated for long.
    Saturation,
    /// The flight ended.
    Verdict,
}

/// An event that an operator wants to find on the time line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// Kind of the event.
    pub kind: EventKind,
    /// One sentence for people.
    pub text: String,
}

impl Event {
    /// An event of `kind` with its sentence.
    pub fn new(kind: EventKind, text: impl Into<String>) -> Self {
        Self { kind, text: text.into() }
    }
}

/// One control period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tick {
    /// Number of the tick, from 0.
    pub index: u64,
    /// Measurement of this tick.
    pub measurement: Measurement,
    /// True state; `None` for a real flight.
    pub truth: Option<Truth>,
    /// Reference of this tick.
    pub reference: Reference,
    /// Measured residual `r_t`, N and N m (`eq:residual_dynamics`).
    pub residual: KnownCoords,
    /// Base forecast and regime.
    pub forecast: Forecast,
    /// Adapted forecast.
    pub adapted: Adapted,
    /// The residual at the loop's delay; `None` in recordings that were made before this field existed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foreseen: Option<Foreseen>,
    /// Internal values of the controller.
    pub control: ControlState,
    /// Set-point of the inner controller until the next tick.
    pub setpoint: Setpoint,
    /// Last command to the actuators.
    pub actuators: ActuatorCommand,
    /// Name of the task's phase.
    pub phase: String,
    /// Events of this tick.
    pub events: Vec<Event>,
    /// The fault in force, if any.
    pub fault: Option<Fault>,
    /// The task is finished.
    pub finished: bool,
    /// Why the task gave up, if it did.
    pub gave_up: Option<String>,
}
