//! Force that the actuators apply, from the best source a recording has, and whether the vehicle flies at all.

use nalgebra::{Vector1, Vector3};
use serde::Serialize;

use super::grid::Ticks;
use super::series::Series;
use super::signals::Signals;
use super::thrust_fit::{AIRBORNE_SHARE, ThrustFit, delayed, fit, high};
use super::topics::Quantity;
use super::torque_gains::Torque;
use twin_core::notation::{GRAVITY_M_S2, world_from_body};

/// Least thrust of a vehicle in the air, as a share of the largest.
const LEAST_THRUST: f64 = 0.05;

/// Thrust above the threshold for fewer ticks is no flight, below it for fewer ticks no landing: 0.5 s.
const SHORT_TICKS: usize = 50;

/// Where the applied force comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Effort {
    /// Force and torque in N and N m as logged. The fit says how much of it moved the mass.
    Wrench {
        /// `1 / gain` is the mass that fits, kg; in the unit m/s² per N.
        fit: Option<ThrustFit>,
    },
    /// Normalised thrust times the fitted gain and the mass.
    Fitted {
        /// What the input is.
        input: Quantity,
        /// The fit.
        fit: ThrustFit,
        /// What the normalised torques beside it are.
        torque: Box<Torque>,
    },
    /// As the simulated vehicle that was recorded measured it.
    Recorded,
    /// No force is known.
    Unknown {
        /// Why.
        why: String,
    },
}

/// Force, its source, and where the vehicle flies.
pub(super) struct Found {
    /// Force in the body per tick, N, before `H`.
    pub body_force: Ticks<3>,
    /// Its source.
    pub effort: Effort,
    /// Per tick.
    pub airborne: Vec<bool>,
    /// Thrust above which it flies, in the thrust's unit.
    pub threshold: f64,
}

/// What was found for the whole of a flight of which a part is read.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    /// Where the force comes from.
    pub effort: Effort,
    /// Mass in use, kg.
    pub mass_kg: f64,
    /// As [`Found::threshold`].
    pub threshold: f64,
}

/// Force in the body, N, from the best source there is. `acceleration` passed `H` `passes` times. What is `settled` is not fitted.
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
        Some(_) => Err("the flight has a wrench, and this part of it none".to_owned()),
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
                    torque: Box::new(Torque::unknown(None, "not looked for")),
                },
                airborne: airborne(thrust, times_s, threshold),
                threshold,
            }
        }
    }
}

/// Half of the 90 % quantile of the thrust.
fn threshold(thrust: &Series<1>, least: f64) -> f64 {
    (high(thrust) * AIRBORNE_SHARE).max(least)
}

/// Where the thrust is above `threshold`, short spikes and short dips left out.
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
