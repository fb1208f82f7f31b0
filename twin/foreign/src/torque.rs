//! Torque about the body axes from normalised set-points, by the gains fitted to the flight.
//!
//! Per axis `m = J k u(t - lag)`. If the inertia is unknown, `J` is 1 kg m² and the torques are per kg m².

use nalgebra::Vector3;

use super::derivation::Derivation;
use super::effort::{Effort, Settled};
use super::grid::{Ticks, curvature, filtered_times, slope};
use super::signals::Signals;
use super::torque_blocks::Known;
use super::torque_fit::{TorqueAxis, fit};
use super::torque_gains::Torque;
use twin_core::notation::body_rate_from_euler_rate;

/// Angular acceleration of the body by torque per tick, rad/s², before `H`. It includes the gyroscopic part if the inertia is
/// known.
fn turning(
    signals: &Signals,
    times_s: &[f64],
    eta: &Ticks<3>,
    inertia_kg_m2: Option<[f64; 3]>,
) -> Ticks<3> {
    let Some(body_rate) = &signals.body_rate else {
        let raw = curvature(eta);
        let one = |(raw, eta): (&Option<Vector3<f64>>, &Option<Vector3<f64>>)| {
            Some(body_rate_from_euler_rate(eta.as_ref()?) * raw.as_ref()?)
        };
        return raw.iter().zip(eta).map(one).collect();
    };
    let rate: Ticks<3> = times_s.iter().map(|t_s| body_rate.cubic(*t_s)).collect();
    let inertia = inertia_kg_m2.map(Vector3::from);
    let one = |(turning, rate): (Option<Vector3<f64>>, &Option<Vector3<f64>>)| {
        let (turning, rate) = (turning?, rate.as_ref()?);
        let gyroscopic = inertia.map(|j| rate.cross(&j.component_mul(rate)).component_div(&j));
        Some(turning + gyroscopic.unwrap_or_default())
    };
    slope(&rate).into_iter().zip(&rate).map(one).collect()
}

/// The torque in `signals`: its gains, and per tick the moment in the body frame before `H`, N m. An axis without a gain gets the
/// moment that turned it, because that moment contributes to the other coordinates. With `settled` nothing is fitted anew.
pub(super) fn torque(
    signals: &Signals,
    (times_s, eta, airborne): (&[f64], &Ticks<3>, &[bool]),
    derivation: Derivation,
    inertia_kg_m2: Option<[f64; 3]>,
    settled: Option<&Settled>,
) -> (Torque, Ticks<3>) {
    let unknown = |why: &str| (Torque::unknown(inertia_kg_m2, why), vec![None; times_s.len()]);
    let Some(input) = &signals.torque_setpoint else {
        return unknown("no torque set-point in the log");
    };
    let raw = turning(signals, times_s, eta, inertia_kg_m2);
    let found = match (settled.map(|settled| &settled.effort), &signals.attitude_setpoint) {
        (Some(Effort::Fitted { torque, .. }), _) => (**torque).clone(),
        (Some(_), _) => return unknown("no torque of the flight was fitted"),
        (None, None) => {
            return unknown(
                "no attitude set-point in the log: without it a gain cannot be identified in closed loop",
            );
        }
        (None, Some(setpoint)) => {
            let passes = derivation.passes();
            let acceleration = &filtered_times(&raw, passes);
            let known = Known { times_s, torque: input, setpoint, acceleration, passes, airborne };
            Torque { axes: fit(&known), ..Torque::unknown(inertia_kg_m2, "") }
        }
    };
    if found.known() == [false; 3] {
        return (found, vec![None; times_s.len()]);
    }
    let moment = |tick: usize| {
        let mut moment = raw[tick]?;
        for (axis, gain) in found.axes.iter().enumerate() {
            if let TorqueAxis::Fitted(fit) = gain {
                moment[axis] = fit.gain * input.linear(times_s[tick] - fit.lag_s)?[axis];
            }
            moment[axis] *= found.inertia_kg_m2[axis];
        }
        Some(moment)
    };
    let moments = (0..times_s.len()).map(moment).collect();
    (found, moments)
}
