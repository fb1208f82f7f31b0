//! The applied force from the best source that a recording has.

use nalgebra::{Vector1, Vector3};
use serde::Serialize;

use super::grid::Ticks;
use super::phases::{LEAST_THRUST, Yardsticks};
use super::series::Series;
use super::signals::Signals;
use super::thrust_fit::{ThrustFit, delayed, fit};
use super::topics::Quantity;
use super::torque_gains::Torque;
use twin_core::notation::{GRAVITY_M_S2, world_from_body};

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

/// The force and its source.
pub(super) struct Found {
    /// Force in the body frame per tick, N, before the filter `H`.
    pub body_force: Ticks<3>,
    /// Source of the force.
    pub effort: Effort,
}

/// How the vehicle moved.
pub(super) struct Moved<'a> {
    /// Roll, pitch and yaw, rad.
    pub eta: &'a Ticks<3>,
    /// Acceleration in the world, m/s², which has passed `H` `passes` times.
    pub acceleration: &'a Ticks<3>,
    pub passes: usize,
    /// Whether it is in the air.
    pub airborne: &'a [bool],
}

/// Results for a whole flight, which a part of that flight reuses.
#[derive(Clone, Debug)]
pub(super) struct Settled {
    /// Source of the force.
    pub effort: Effort,
    /// Mass in use, kg.
    pub mass_kg: f64,
    /// What the flight says about its phases.
    pub yardsticks: Yardsticks,
}

/// Thrust along the body's z axis, in N or in the unit of a set-point; `None` if the recording has none.
pub(super) fn along_z(signals: &Signals, times_s: &[f64]) -> Option<Series<1>> {
    let Some(force) = &signals.force else {
        return signals.thrust.as_ref().map(|(_, thrust)| thrust.clone());
    };
    let z = |t_s: &f64| Some((*t_s, Vector1::new(force.linear(*t_s)?.z)));
    Some(Series::new(times_s.iter().filter_map(z)))
}

/// Least thrust of a vehicle of `mass_kg` that flies, in the unit of its thrust.
pub(super) fn least_thrust(signals: &Signals, mass_kg: f64) -> f64 {
    let unit = if signals.force.is_some() { mass_kg * GRAVITY_M_S2 } else { 1.0 };
    LEAST_THRUST * unit
}

/// Force in the body frame, N, from the best source in `signals`. With `settled` nothing is fitted anew.
pub(super) fn effort(
    signals: &Signals,
    times_s: &[f64],
    moved: &Moved<'_>,
    mass_kg: f64,
    settled: Option<&Settled>,
) -> Found {
    let Moved { eta, acceleration, passes, airborne } = *moved;
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
        let fitted = || {
            let along_z = along_z(signals, times_s)?;
            let least = least_thrust(signals, mass_kg);
            fit(&along_z, times_s, &specific_force, passes, (least, airborne)).ok()
        };
        let effort = match settled {
            Some(settled) => settled.effort.clone(),
            None => Effort::Wrench { fit: fitted() },
        };
        return Found { body_force, effort };
    }
    let unknown = |why: String| Found {
        body_force: vec![None; times_s.len()],
        effort: Effort::Unknown { why },
    };
    let Some((input, thrust)) = &signals.thrust else {
        return unknown(
            "no wrench, thrust set-point, motor output or collective thrust".to_owned(),
        );
    };
    let fitted = match settled.map(|settled| &settled.effort) {
        None => fit(thrust, times_s, &specific_force, passes, (LEAST_THRUST, airborne)),
        Some(Effort::Fitted { fit, .. }) => Ok(*fit),
        Some(Effort::Unknown { why }) => Err(why.clone()),
        Some(_) => Err("the flight has a wrench, but this part of the flight has none".to_owned()),
    };
    match fitted {
        Err(why) => unknown(why),
        Ok(fit) => {
            let newtons =
                |u: &Option<Vector1<f64>>| u.map(|u| Vector3::z() * (u.x * fit.gain * mass_kg));
            Found {
                body_force: delayed(thrust, times_s, fit.lag_s).iter().map(newtons).collect(),
                effort: Effort::Fitted {
                    input: *input,
                    fit,
                    torque: Box::new(Torque::unknown(None, "the torque was not estimated")),
                },
            }
        }
    }
}
