//! Every record that crosses a stage of the loop. [`Tick`] = one control period, built once at its end and never changed:
//! the recorder, the browser, the verdict and the tests all read this one record.
//!
//! What nobody knows is unknown in the record itself, row by row ([`KnownCoords`]).
//!
//! No record here holds wall-clock time, so two runs of one seed are equal bit for bit.

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::notation::{Coords, KnownCoords, KnownMask, PerRotor, known_in_both};

/// What the source measured in one control period: the input of everything above the source.
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
    /// A rotor or a joint ran into its limit during the period.
    pub saturated: bool,
    /// The vehicle flies, as far as its source can tell: on the ground the residual would be the force of the floor.
    #[serde(default = "flies", skip_serializing_if = "is_true")]
    pub airborne: bool,
}

/// Recordings of simulated flights, and those made before this field existed, do not say it.
fn flies() -> bool {
    true
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
fn is_true(value: &bool) -> bool {
    *value
}

impl Measurement {
    /// The rows of which a residual can be formed: force and acceleration are known, and the vehicle flies.
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

/// A pose as the viewers want it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin in the world, m.
    pub position: [f64; 3],
    /// World-from-body quaternion, `[w x y z]`.
    pub quaternion_wxyz: [f64; 4],
}

/// One contact point with the force the second body receives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Point in the world, m.
    pub point_in_world: [f64; 3],
    /// Normal plus friction force on the payload or the vehicle in the world, N.
    pub force_in_world_n: [f64; 3],
}

/// What really happened, known to the simulated plant alone: for metrics, verdict and viewers, never for the loop.
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
    /// Largest contact force on the vehicle other than through the fingers' pads, N.
    pub collision_force_n: f64,
    /// Wind at the vehicle in the world, m/s.
    pub wind_in_world: Vector3<f64>,
    /// Actual thrust of each rotor, N.
    pub rotor_thrust_n: PerRotor,
    /// Contact points with their forces.
    pub contacts: Vec<Contact>,
}

/// What to fly at this tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Desired coordinates; the roll and pitch entries are filled by the command filter of the inner loop.
    pub chi_des: KnownCoords,
    /// Desired rates.
    pub chi_des_dot: KnownCoords,
    /// Desired accelerations.
    pub chi_des_ddot: Coords,
    /// What the gripper shall do.
    pub gripper: GripperCommand,
    /// How freely the residual estimate may move at this tick.
    pub adaptation: Adaptation,
    /// The reference holds the measured pose (allowed in contact only); left out of transport metrics.
    pub follows_measurement: bool,
    /// The payload hangs in the gripper and moves with it: the ticks of `rms_error_e8_transport`.
    pub transporting: bool,
    /// The path runs at its cruise speed: the ticks of `transport_speed_m_s`.
    pub cruising: bool,
    /// The payload is put down at this tick and the residual without it is known, N and N m: estimate and adapter jump there.
    pub release: Option<Coords>,
}

/// How freely the residual estimate may move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Adaptation {
    /// Follows the adapter.
    #[default]
    Free,
    /// Stays within a window around its value when the window began: a finger that stands on something cannot wind it up.
    Bounded,
    /// Held: in contact with box or table. The adapter and its reset detector are held too.
    Held,
}

/// What the gripper shall do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GripperCommand {
    /// Keep the fingers open.
    #[default]
    Open,
    /// Close and squeeze with the force of the gripper.
    Close,
}

/// Output of the frozen predictor.
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
    /// Adapted residual estimate of this tick, N and N m; known where the residual is, as all of the following.
    pub r_hat: KnownCoords,
    /// The same before this tick's residual was seen (a priori): what every prediction metric uses, N and N m.
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
    /// The covariance was reset at this tick.
    pub reset: bool,
    /// The adapter was held at this tick.
    pub frozen: bool,
}

/// What the outer loop asks of the inner rows until the next tick.
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
    /// Residual estimate in force (low-passed and clipped), N and N m: a number in every row, also where the residual is unknown.
    pub r_hat: Coords,
    /// Norm of the sliding variable, held between ticks.
    pub sliding_norm: f64,
    /// Robust gain `sigma_hat`, held between ticks.
    pub robust_gain: f64,
    /// Law and gains of the inner rows.
    pub rows: InnerGains,
    /// Gripper command.
    pub gripper: GripperCommand,
}

/// Which law drives attitude and joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InnerLaw {
    /// The paper's rows (`eq:control_input`) on attitude and joints.
    #[default]
    Rows,
    /// A PX4-like rate loop on attitude, the paper's rows on the joints.
    RateLoop,
}

/// Gains of the inner rows, in coordinate order.
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

/// What the actuators were asked last.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActuatorCommand {
    /// Thrust of each rotor, N.
    pub rotor_thrust_n: PerRotor,
    /// Joint torques, N m.
    pub joint_torque_n_m: Vector2<f64>,
    /// The allocation had to give something up.
    pub saturated: bool,
}

/// Internal values of the controller that an operator wants to see.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlState {
    /// Tracking error `e`, yaw wrapped; roll and pitch against the command filter.
    pub error: KnownCoords,
    /// Sliding variable `s`.
    pub sliding: KnownCoords,
    /// Robust gain `sigma_hat`.
    pub robust_gain: f64,
}

/// Why a tick fell back to a safer mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// A measurement was not finite: the last command is held.
    NonFiniteMeasurement,
    /// The predictor or adapter returned a non-finite value: the nominal residual is used.
    NonFinitePrediction,
    /// `|theta| > 80°`: Euler angles are about to lose their meaning.
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
    /// A pick attempt was given up and is tried again.
    Retry,
    /// The covariance was reset.
    Reset,
    /// A gain changed.
    Gain,
    /// The payload or the wind changed by the scenario or an operator.
    Disturbance,
    /// A fault began or ended.
    Fault,
    /// The flight ended.
    Verdict,
}

/// Something an operator wants to find again on the time line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// What kind of thing happened.
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
    /// What was measured.
    pub measurement: Measurement,
    /// What really happened; `None` for a real flight.
    pub truth: Option<Truth>,
    /// What was to be flown.
    pub reference: Reference,
    /// Measured residual `r_t`, N and N m (`eq:residual_dynamics`).
    pub residual: KnownCoords,
    /// Base forecast and regime.
    pub forecast: Forecast,
    /// Adapted forecast.
    pub adapted: Adapted,
    /// Controller internals.
    pub control: ControlState,
    /// What the inner rows will follow until the next tick.
    pub setpoint: Setpoint,
    /// What the actuators were asked last.
    pub actuators: ActuatorCommand,
    /// Name of the task's phase.
    pub phase: String,
    /// What happened at this tick.
    pub events: Vec<Event>,
    /// The fault in force, if any.
    pub fault: Option<Fault>,
    /// The task is finished.
    pub finished: bool,
    /// Why the task gave up, if it did.
    pub gave_up: Option<String>,
}
