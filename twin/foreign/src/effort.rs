//! The applied force from the best source that a recording has, and the ticks at which the vehicle is airborne.

use nalgebra::{Vector1, Vector3};
use serde::Serialize;

use super::grid::Ticks;
use super::series::Series;
use super::signals::Signals;
use super::thrust_fit::{AIRBORNE_SHARE, ThrustFit, delayed, fit, high};
use super::topics::Quantity;
use super::torque_gains::Torque;
use twin_core::notation::{GRAVITY_M_S2, world_from_body};

/// Least thrust of an airborne vehicle, as a share of the largest thrust.
const LEAST_THRUST: f64 = 0.05;

/// Shortest flight and shortest landing, ticks (0.5 s): a shorter time above the threshold is a spike, a shorter time below it is
/// a dip.
const SHORT_TICKS: usize = 50;

/// The source of the applied force.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Effort {
    /// Force and torque in N and N m as logged.
    Wrench {
        /// Fit of the logged force to the motion, in m/s² per N; `1 / gain` is the mass in kg that explains the motion.
        fit: Option<ThrustFit>,
    },
    /// Normalised thrust, multiplied by the fitted gain and the mass.
    Fitted {
        /// The quantity that gives the thrust.
        input: Quantity,
        /// The fit of its gain.
        fit: ThrustFit,
        /// Gains of the normalised torques.
        torque: Box<Torque>,
    },
    /// The force that the simulated vehicle of a recording of this program measured.
    Recorded,
    /// The force is unknown.
    Unknown {
        /// The reason.
        why: String,
    },
}

/// The force, its source, and the ticks at which the vehicle is airborne.
pub(super) struct Found {
    /// Force in the body frame per tick, N, before the filter `H`.
    pub body_force: Ticks<3>,
    /// Source of the force.
    pub effort: Effort,
    /// Whether the vehicle is airborne, per tick.
    pub airborne: Vec<bool>,
    /// Thrust above which the vehicle counts as airborne, in the unit of the thrust.
    pub threshold: f64,
}

/// Results for a whole flight, which a part of that flight reuses.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    /// Source of the force.
    pub effort: Effort,
    /// Mass in use, kg.
    pub mass_kg: f64,
    /// Threshold as in [`Found::threshold`].
    pub threshold: f64,
}

/// Force in the body frame, N, from the best source in `signals`. `acceleration` has passed `H` `passes` times. With `settled`
/// nothing is fitted anew.
pub(super) fn effort(
    signals: &Signals,
    times_s: &[f64],
    eta: &Ticks<3>,
    acceleration: &Ticks<3>,
    passes: usize,
    mass_kg: f64,
    settled: Option<&Settled>,
) -> Found {
    let specific_force: Vec<Option<f64>> = acceleration
        .iter()
        .zip(eta)
        .map(|(a, eta)| {
            let axis = world_from_body(eta.as_ref()?) * Vector3::z();
            Some(axis.dot(&(a.as_ref()? + Vector3::z() * GRAVITY_M_S2)))
        })
        .collect();
    if let Some(force) = &signals.force {
        let body_force: Ticks<3> = times_s.iter().map(|t_s| force.linear(*t_s)).collect();
        let along_z = Series::new(
            times_s.iter().filter_map(|t_s| Some((*t_s, Vector1::new(force.linear(*t_s)?.z)))),
        );
        let least = LEAST_THRUST * mass_kg * GRAVITY_M_S2;
        let fitted = || fit(&along_z, times_s, &specific_force, passes, least).ok();
        let effort = match settled {
            Some(settled) => settled.effort.clone(),
            None => Effort::Wrench { fit: fitted() },
        };
        let threshold = settled.map_or_else(|| threshold(&along_z, least), |s| s.threshold);
        let airborne = airborne(&along_z, times_s, threshold);
        return Found { body_force, effort, airborne, threshold };
    }
    let unknown = |why: String| Found {
        body_force: vec![None; times_s.len()],
        effort: Effort::Unknown { why },
        airborne: vec![false; times_s.len()],
        threshold: f64::INFINITY,
    };
    let Some((input, thrust)) = &signals.thrust else {
        return unknown(
            "no wrench, thrust set-point, motor output or collective thrust".to_owned(),
        );
    };
    let fitted = match settled.map(|settled| &settled.effort) {
        None => fit(thrust, times_s, &specific_force, passes, LEAST_THRUST),
        Some(Effort::Fitted { fit, .. }) => Ok(*fit),
        Some(Effort::Unknown { why }) => Err(why.clone()),
        Some(_) => Err("the flight has a wrench, but this part of the flight has none".to_owned()),
    };
    match fitted {
        Err(why) => unknown(why),
        Ok(fit) => {
            let newtons =
                |u: &Option<Vector1<f64>>| u.map(|u| Vector3::z() * (u.x * fit.gain * mass_kg));
            let threshold =
                settled.map_or_else(|| threshold(thrust, LEAST_THRUST), |s| s.threshold);
            Found {
                body_force: delayed(thrust, times_s, fit.lag_s).iter().map(newtons).collect(),
                effort: Effort::Fitted {
                    input: *input,
                    fit,
                    torque: Box::new(Torque::unknown(None, "the torque was not estimated")),
                },
                airborne: airborne(thrust, times_s, threshold),
                threshold,
            }
        }
    }
}

/// Half of the 90 % quantile of the thrust, but at least `least`.
fn threshold(thrust: &Series<1>, least: f64) -> f64 {
    (high(thrust) * AIRBORNE_SHARE).max(least)
}

/// Whether the thrust exceeds `threshold` at each tick, without short spikes and short dips.
fn airborne(thrust: &Series<1>, times_s: &[f64], threshold: f64) -> Vec<bool> {
    let mut flies: Vec<bool> =
        times_s.iter().map(|t_s| thrust.linear(*t_s).is_some_and(|u| u.x > threshold)).collect();
    for short in [false, true] {
        let mut start = 0;
        while start < flies.len() {
            let end = (start..flies.len()).find(|i| flies[*i] != flies[start]);
            let (end, inside) = (end.unwrap_or(flies.len()), start > 0 && end.is_some());
            if flies[start] == short && end - start < SHORT_TICKS && (inside || short) {
                flies[start..end].fill(!short);
            }
            start = end;
        }
    }
    flies
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::notation::TICK_S;

    #[test]
    fn a_dip_is_no_landing_and_a_spike_is_no_flight() {
        let times: Vec<f64> = (0..1000).map(|i| f64::from(i) * TICK_S).collect();
        let thrust = |i: usize| match i {
            100..110 | 300..500 | 520..900 => 0.5,
            500..520 => 0.1,
            _ => 0.0,
        };
        let samples = times.iter().enumerate().map(|(i, t)| (*t, Vector1::new(thrust(i))));
        let thrust = Series::new(samples);
        let flies = airborne(&thrust, &times, threshold(&thrust, LEAST_THRUST));
        let expected: Vec<bool> = (0..1000).map(|i| (300..900).contains(&i)).collect();
        assert_eq!(flies, expected);
    }
}
