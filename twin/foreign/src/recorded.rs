//! A recorded flight on the ticks of the loop: coordinates, rates, accelerations and applied force, `None` where unknown.
//!
//! Cubics interpolate the position, SLERP the attitude, straight lines the rest; inside gaps all values are unknown. The
//! acceleration comes from the best source: the slope of a measured rate, the accelerometer, or the second derivative of the
//! pose. It passes the filter `H` once; a second derivative of the pose passes it twice, because one pass leaves too much noise.
//! The applied force passes the same filters as the acceleration.

use std::ops::Range;

use nalgebra::{Vector2, Vector3};

pub use super::derivation::Derivation;
use super::effort::{Effort, Moved, Settled, along_z, effort, least_thrust};
use super::grid::{Ticks, curvature, filtered, filtered_times, slope};
use super::inertial;
use super::phases::{Evidence, Phase, Span, Yardsticks, spans};
use super::signals::Signals;
use super::topics::VehicleFacts;
use twin_core::notation::{
    Coords, N, TICK_S, body_rate_from_euler_rate, euler_from_rotation, euler_rate_from_body_rate,
    world_from_body, wrap_angle,
};

/// Longest flight, s (ten hours), and in ticks.
pub(super) const LONGEST_S: f64 = 36_000.0;
pub(super) const MOST_TICKS: f64 = LONGEST_S / TICK_S;

/// Number of coordinates of the arm, which are the last ones.
pub(super) const ARM_ROWS: usize = 2;

/// The recorded values at one tick; `None` is unknown.
#[derive(Clone, Debug, Default)]
pub struct RecordedTick {
    /// Value of each coordinate, m and rad.
    pub chi: [Option<f64>; N],
    /// Rate of each coordinate, m/s and rad/s.
    pub chi_dot: [Option<f64>; N],
    /// Acceleration of each coordinate after `H`, m/s² and rad/s².
    pub chi_ddot: [Option<f64>; N],
    /// Applied generalised force on each coordinate after `H`, N and N m.
    pub tau: [Option<f64>; N],
}

/// A recorded flight on ticks.
#[derive(Clone, Debug)]
pub struct RecordedFlight {
    /// Time of every tick, s from the first sample of the recording.
    pub times_s: Vec<f64>,
    /// Values at every tick.
    pub instants: Vec<RecordedTick>,
    /// Source of the applied force.
    pub effort: Effort,
    /// Mass in use, kg: as given; else the mass that fits the wrench; else 1.
    pub mass_kg: f64,
    /// Whether the vehicle is in the air, per tick: the phase [`Phase::Air`].
    pub airborne: Vec<bool>,
    /// The nominal inertia `M_bar` that forms the residual, kg and kg m²; `None` for the known mass and inertia.
    pub nominal_inertia: Option<Coords>,
    /// Sources of the translational and the rotational acceleration.
    pub acceleration: [Derivation; 2],
    /// Phases of the flight, in order of time; none in a recording of this program.
    pub spans: Vec<Span>,
    /// What the flight says about its phases.
    pub yardsticks: Yardsticks,
    /// Names of the joints behind the coordinates q1 and q2, if the recording has joints.
    pub joint_names: Vec<String>,
}

/// Why a recording cannot be mirrored.
#[derive(Debug, thiserror::Error)]
pub enum MirrorError {
    /// The recording contains neither position nor attitude.
    #[error(
        "no position and no attitude in this recording; say with --map which topic and fields hold them"
    )]
    NoPose,
    /// The recording spans an implausible time.
    #[error(
        "the recording spans {0:.0} s, at most ten hours are mirrored; a clock in it is broken"
    )]
    TooLong(f64),
    /// No topic belongs to the vehicle that is asked for.
    #[error("no topic belongs to the vehicle {wanted}; found are {}", if found.is_empty() { "none by name" } else { found.as_str() })]
    NoVehicle {
        /// Namespace that was asked for.
        wanted: String,
        /// Namespaces of the recording.
        found: String,
    },
}

/// Puts `signals` onto ticks.
///
/// # Errors
/// [`MirrorError`] if the signals contain no pose, or span an implausible time.
pub fn on_ticks(signals: &Signals, facts: &VehicleFacts) -> Result<RecordedFlight, MirrorError> {
    let spans = [
        signals.position.as_ref().and_then(super::series::Series::span),
        signals.attitude.as_ref().and_then(super::series::Attitudes::span),
    ];
    let spans = || spans.iter().flatten();
    let start_s = spans().map(|span| span.0).reduce(f64::min).ok_or(MirrorError::NoPose)?;
    let end_s = spans().map(|span| span.1).fold(start_s, f64::max);
    let ticks = tick_count(start_s, end_s)?;
    let times_s: Vec<f64> = (0..ticks).map(|i| start_s + i as f64 * TICK_S).collect();
    Ok(on_times(signals, facts, times_s, Reading::Whole))
}

/// Number of ticks from `start_s` to `end_s`.
pub(super) fn tick_count(start_s: f64, end_s: f64) -> Result<usize, MirrorError> {
    let ticks = ((end_s - start_s) / TICK_S).floor() + 1.0;
    if ticks <= MOST_TICKS {
        Ok(ticks as usize)
    } else {
        Err(MirrorError::TooLong(end_s - start_s))
    }
}

/// The part of a flight that is put onto ticks.
#[derive(Clone, Copy)]
pub(super) enum Reading<'a> {
    /// The whole flight.
    Whole,
    /// Stretches of the flight, with an unknown tick after each.
    Stretches,
    /// A part of the flight, with the results for the whole flight.
    Part(&'a Settled),
}

/// Puts `signals` onto the ticks at `times_s`, which are one tick period apart wherever values are known.
pub(super) fn on_times(
    signals: &Signals,
    facts: &VehicleFacts,
    times_s: Vec<f64>,
    reading: Reading<'_>,
) -> RecordedFlight {
    let settled = if let Reading::Part(settled) = reading { Some(settled) } else { None };
    let parts = !matches!(reading, Reading::Whole);
    let mut instants = vec![RecordedTick::default(); times_s.len()];
    let eta = attitude(signals, &times_s);
    let (acceleration, of_translation) = translation(signals, &times_s, &eta, &mut instants, parts);
    let of_rotation = rotation(signals, &times_s, &eta, &mut instants);
    arm(signals, &times_s, &mut instants);
    let mass_kg = settled.map_or_else(|| facts.mass_kg.unwrap_or(1.0), |settled| settled.mass_kg);
    let passes = of_translation.passes();
    let phases = phases(signals, &times_s, &eta, &instants, (mass_kg, settled));
    let airborne = phases.airborne;
    let moved = Moved { eta: &eta, acceleration: &acceleration, passes, airborne: &airborne };
    let found = effort(signals, &times_s, &moved, mass_kg, settled);
    let mut effort = found.effort;
    // If the force is a wrench in N and no mass is given, the mass is fitted to the flight.
    let mass_kg = match (&effort, facts.mass_kg) {
        (Effort::Wrench { fit: Some(fit) }, None) if fit.explains() => 1.0 / fit.gain,
        _ => mass_kg,
    };
    let torque: Ticks<3> = match (&mut effort, &signals.torque) {
        (Effort::Wrench { .. }, Some(torque)) => {
            times_s.iter().map(|t| torque.linear(*t)).collect()
        }
        (Effort::Fitted { torque, .. }, _) => {
            let flown = (times_s.as_slice(), &eta, airborne.as_slice());
            let (gains, moments) =
                super::torque::torque(signals, flown, of_rotation, facts.inertia_kg_m2, settled);
            **torque = gains;
            moments
        }
        _ => vec![None; times_s.len()],
    };
    let force = per_attitude(&found.body_force, &eta, |eta, force| world_from_body(eta) * force);
    let moment =
        per_attitude(&torque, &eta, |eta, m| body_rate_from_euler_rate(eta).transpose() * m);
    store(&mut instants, 0, &filtered_times(&force, of_translation.passes()), |i| &mut i.tau);
    store(&mut instants, 3, &filtered_times(&moment, of_rotation.passes()), |i| &mut i.tau);
    if let Effort::Fitted { torque, .. } = &effort {
        for row in (0..3).filter(|axis| !torque.known()[*axis]).map(|axis| 3 + axis) {
            for instant in &mut instants {
                instant.tau[row] = None;
            }
        }
    }
    let acceleration = [of_translation, of_rotation];
    let joints = signals.joints.iter().flat_map(|(names, _)| names);
    RecordedFlight {
        times_s,
        instants,
        effort,
        mass_kg,
        airborne,
        spans: phases.spans,
        yardsticks: phases.yardsticks,
        nominal_inertia: None,
        acceleration,
        joint_names: joints.take(ARM_ROWS).cloned().collect(),
    }
}

/// The phases of a flight.
struct Phases {
    airborne: Vec<bool>,
    spans: Vec<Span>,
    yardsticks: Yardsticks,
}

fn phases(
    signals: &Signals,
    times_s: &[f64],
    eta: &Ticks<3>,
    instants: &[RecordedTick],
    (mass_kg, settled): (f64, Option<&Settled>),
) -> Phases {
    let thrust = along_z(signals, times_s);
    let evidence = Evidence {
        times_s,
        thrust: thrust.as_ref(),
        position: &positions(instants),
        eta,
        landed: signals.landed.as_ref(),
        armed: signals.armed.as_ref(),
    };
    let least = least_thrust(signals, mass_kg);
    let yardsticks = settled.map_or_else(|| evidence.yardsticks(least), |s| s.yardsticks);
    let judged = evidence.judge(&yardsticks);
    let airborne = judged.iter().map(|(phase, _)| *phase == Phase::Air).collect();
    Phases { airborne, spans: spans(times_s, &judged), yardsticks }
}

/// The position of each tick; unknown if one of its coordinates is.
fn positions(instants: &[RecordedTick]) -> Ticks<3> {
    let place = |i: &RecordedTick| Some(Vector3::new(i.chi[0]?, i.chi[1]?, i.chi[2]?));
    instants.iter().map(place).collect()
}

/// Applies `f` to attitude and value at each tick where both are known.
fn per_attitude(
    values: &Ticks<3>,
    eta: &Ticks<3>,
    f: impl Fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>,
) -> Ticks<3> {
    values.iter().zip(eta).map(|(value, eta)| Some(f(eta.as_ref()?, value.as_ref()?))).collect()
}

fn store<const D: usize>(
    instants: &mut [RecordedTick],
    first_row: usize,
    values: &Ticks<D>,
    of: impl Fn(&mut RecordedTick) -> &mut [Option<f64>; N],
) {
    for (instant, value) in instants.iter_mut().zip(values) {
        for row in 0..D {
            of(instant)[first_row + row] = value.map(|v| v[row]);
        }
    }
}

/// `[phi theta psi]` per tick, rad, with `psi` unwrapped.
fn attitude(signals: &Signals, times_s: &[f64]) -> Ticks<3> {
    let Some(attitudes) = &signals.attitude else { return vec![None; times_s.len()] };
    let mut last_psi: Option<f64> = None;
    let unwrapped = |t_s: &f64| {
        let q = attitudes.slerp(*t_s)?;
        let mut eta = euler_from_rotation(q.to_rotation_matrix().matrix());
        if let Some(last) = last_psi {
            eta.z = last + wrap_angle(eta.z - last);
        }
        last_psi = Some(eta.z);
        Some(eta)
    };
    times_s.iter().map(unwrapped).collect()
}

/// Fills the coordinates x y z; returns the acceleration and its source.
fn translation(
    signals: &Signals,
    times_s: &[f64],
    eta: &Ticks<3>,
    instants: &mut [RecordedTick],
    parts: bool,
) -> (Ticks<3>, Derivation) {
    let Some(position) = &signals.position else {
        return (vec![None; times_s.len()], Derivation::Unknown);
    };
    let chi: Ticks<3> = times_s.iter().map(|t_s| position.cubic(*t_s)).collect();
    let measured: Option<Ticks<3>> = match (&signals.velocity, &signals.body_velocity) {
        (Some(velocity), _) => Some(times_s.iter().map(|t_s| velocity.cubic(*t_s)).collect()),
        (None, Some(velocity)) => {
            let one = |(t_s, eta): (&f64, &Option<Vector3<f64>>)| {
                Some(world_from_body(eta.as_ref()?) * velocity.cubic(*t_s)?)
            };
            Some(times_s.iter().zip(eta).map(one).collect())
        }
        (None, None) => None,
    };
    let (raw, derivation) = match (&measured, &signals.specific_force) {
        (Some(velocity), _) => (slope(velocity), Derivation::MeasuredRate),
        (None, Some(specific_force)) => {
            let raw = inertial::acceleration(specific_force, times_s, eta, &chi, parts);
            (raw, Derivation::Accelerometer)
        }
        (None, None) => (curvature(&chi), Derivation::Pose),
    };
    let acceleration = filtered_times(&raw, derivation.passes());
    let velocity = measured.unwrap_or_else(|| filtered(&slope(&chi), false));
    store(instants, 0, &chi, |i| &mut i.chi);
    store(instants, 0, &velocity, |i| &mut i.chi_dot);
    store(instants, 0, &acceleration, |i| &mut i.chi_ddot);
    (acceleration, derivation)
}

/// Fills the coordinates phi theta psi; returns the source of the acceleration.
fn rotation(
    signals: &Signals,
    times_s: &[f64],
    eta: &Ticks<3>,
    instants: &mut [RecordedTick],
) -> Derivation {
    let measured: Option<Ticks<3>> = signals.body_rate.as_ref().map(|rate| {
        let one = |(t_s, eta): (&f64, &Option<Vector3<f64>>)| {
            Some(euler_rate_from_body_rate(eta.as_ref()?) * rate.cubic(*t_s)?)
        };
        times_s.iter().zip(eta).map(one).collect()
    });
    let (raw, derivation) = match &measured {
        Some(rate) => (slope(rate), Derivation::MeasuredRate),
        None => (curvature(eta), Derivation::Pose),
    };
    let acceleration = filtered_times(&raw, derivation.passes());
    let rate = measured.unwrap_or_else(|| filtered(&slope(eta), false));
    store(instants, 3, eta, |i| &mut i.chi);
    store(instants, 3, &rate, |i| &mut i.chi_dot);
    store(instants, 3, &acceleration, |i| &mut i.chi_ddot);
    derivation
}

/// Fills the coordinates q1 q2 for as many joints as there are; their torques are unknown.
fn arm(signals: &Signals, times_s: &[f64], instants: &mut [RecordedTick]) {
    let Some((names, series)) = &signals.joints else { return };
    let joints: Ticks<2> = times_s.iter().map(|t_s| series.cubic(*t_s)).collect();
    let (rate, acceleration) =
        (filtered(&slope(&joints), false), filtered(&curvature(&joints), true));
    let only = |values: &Ticks<2>,
                instants: &mut [RecordedTick],
                of: fn(&mut RecordedTick) -> &mut [Option<f64>; N]| {
        for (instant, value) in instants.iter_mut().zip(values) {
            for row in 0..names.len().min(ARM_ROWS) {
                of(instant)[6 + row] = value.map(|v: Vector2<f64>| v[row]);
            }
        }
    };
    only(&joints, instants, |i| &mut i.chi);
    only(&rate, instants, |i| &mut i.chi_dot);
    only(&acceleration, instants, |i| &mut i.chi_ddot);
}

impl RecordedFlight {
    /// The flight restricted to `ticks`.
    pub(super) fn only(mut self, ticks: Range<usize>) -> Self {
        self.times_s = self.times_s[ticks.clone()].to_vec();
        self.instants = self.instants[ticks.clone()].to_vec();
        self.airborne = self.airborne[ticks].to_vec();
        self
    }

    /// True if the mass is neither given nor found by a fit; forces are then per kilogram.
    pub fn per_kilogram(&self, facts: &VehicleFacts) -> bool {
        let known = match &self.effort {
            Effort::Wrench { fit: Some(fit) } => fit.explains(),
            effort => *effort == Effort::Recorded,
        };
        facts.mass_kg.is_none() && !known
    }

    /// Inertia about the body axes that converts the fitted torques, kg m²; `None` if no torque was fitted.
    pub fn fitted_inertia(&self) -> Option<[f64; 3]> {
        match &self.effort {
            Effort::Fitted { torque, .. } if torque.known().contains(&true) => {
                Some(torque.inertia_kg_m2)
            }
            _ => None,
        }
    }

    /// Whether the residual of coordinate `row` is known at a tick in the air. On the ground the residual would include the force
    /// of the floor.
    pub fn residual_counts(&self, tick: usize, row: usize) -> bool {
        self.airborne.get(tick).copied().unwrap_or(false) && self.residual_known(tick, row)
    }

    /// Whether the residual of coordinate `row` is known at a tick.
    pub fn residual_known(&self, tick: usize, row: usize) -> bool {
        self.instants.get(tick).is_some_and(|i| i.tau[row].is_some() && i.chi_ddot[row].is_some())
    }
}
