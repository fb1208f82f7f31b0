//! The wakes of the rotors on arm and payload. Each wake is a jet that travels: a point below the vehicle meets the air that a rotor
//! accelerated some time ago, at the place where the rotor was, and the wind carries it.
//!
//! In: pose, induced velocities, wind. Out: velocity of the wake at points. State: the last 0.4 s of poses and jets.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Vector3};

use super::settings::RotorPlace;
use twin_core::elementary::{exp, squared};
use twin_core::notation::{MAX_ROTORS, PerRotor};

/// Radius of a jet per rotor radius: it contracts from the disc to 1/sqrt(2), and friction widens it to 0.78 (Leishman 2006, section 2.2).
const CONTRACTION: f64 = 0.78;

/// Growth of a jet's radius per distance, as of a round turbulent jet (Pope, "Turbulent Flows", 2000, section 5.1).
const SPREAD: f64 = 0.1;

/// Velocity of the far wake per velocity at the disc (momentum theory).
const FAR: f64 = 2.0;

/// Velocity with which a change travels down a jet, per velocity at the disc: between disc and far wake, and half of it at the edge.
const TRAVEL: f64 = 1.0;

/// Slowest travel, m/s. A rotor at rest has no wake.
const SLOWEST_M_S: f64 = 0.5;

/// Steps that are kept: 0.4 s, in which a jet of 5 m/s travels 2 m.
const KEPT: usize = 400;

/// The vehicle when its rotors accelerated a piece of air.
#[derive(Clone, Copy, Debug)]
struct Emission {
    position: Vector3<f64>,
    rotation: Matrix3<f64>,
    jet_m_s: PerRotor,
}

/// The wakes of all rotors.
#[derive(Clone, Debug)]
pub(super) struct Wake {
    hubs: Vec<Vector3<f64>>,
    radius_m: f64,
    jet_m_s: PerRotor,
    past: VecDeque<Emission>,
    dt_s: f64,
}

impl Wake {
    /// Wakes of rotors that have hovered long enough with the induced velocities `induced_m_s`.
    pub(super) fn new(
        places: &[RotorPlace],
        radius_m: f64,
        induced_m_s: &PerRotor,
        dt_s: f64,
    ) -> Self {
        Self {
            hubs: places.iter().map(|place| Vector3::from(place.position_m)).collect(),
            radius_m,
            jet_m_s: induced_m_s.map(|v| FAR * v),
            past: VecDeque::with_capacity(KEPT),
            dt_s,
        }
    }

    /// Advances by a step: the jets follow the induced velocities with the time constant `build_s`.
    pub(super) fn step(
        &mut self,
        position: &Vector3<f64>,
        rotation: &Matrix3<f64>,
        induced_m_s: &PerRotor,
        build_s: f64,
    ) {
        let blend = 1.0 - exp(-self.dt_s / build_s);
        for (jet, induced) in self.jet_m_s.iter_mut().zip(induced_m_s) {
            *jet += (FAR * induced - *jet) * blend;
        }
        if self.past.len() == KEPT {
            self.past.pop_front();
        }
        self.past.push_back(Emission {
            position: *position,
            rotation: *rotation,
            jet_m_s: self.jet_m_s,
        });
    }

    /// Velocity of the wakes in the world at `point`, m/s, in the wind `wind`; zero above the rotors.
    pub(super) fn at(&self, point: &Vector3<f64>, wind: &Vector3<f64>) -> Vector3<f64> {
        let Some(now) = self.past.back() else { return Vector3::zeros() };
        let axis = now.rotation.column(2).into_owned();
        let mut sum = Vector3::zeros();
        for (i, hub) in self.hubs.iter().enumerate().take(MAX_ROTORS) {
            let depth = axis.dot(&(now.position + now.rotation * hub - point));
            if depth > 0.0 {
                sum += self.jet_at(i, hub, point, wind, depth);
            }
        }
        sum
    }

    /// Velocity of one jet at `point`, which lies `depth` below the rotor.
    fn jet_at(
        &self,
        i: usize,
        hub: &Vector3<f64>,
        point: &Vector3<f64>,
        wind: &Vector3<f64>,
        depth: f64,
    ) -> Vector3<f64> {
        let travel_m_s = (TRAVEL / FAR * self.jet_m_s[i]).max(SLOWEST_M_S);
        let age_s = depth / travel_m_s;
        let steps = ((age_s / self.dt_s).round() as usize).min(self.past.len() - 1);
        let emission = &self.past[self.past.len() - 1 - steps];
        let axis = emission.rotation.column(2).into_owned();
        // The centre of the jet is where the rotor was, moved along its axis and with the wind.
        let centre = emission.position + emission.rotation * hub - axis * depth + wind * age_s;
        let off = point - centre;
        let across = off - axis * axis.dot(&off);
        let start_m = CONTRACTION * self.radius_m;
        let radius_m = start_m + SPREAD * depth;
        // A jet keeps its momentum: its velocity falls as its radius grows.
        let speed = emission.jet_m_s[i] * start_m / radius_m
            * exp(-across.norm_squared() / squared(radius_m));
        axis * -speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::quad;

    const STEP_S: f64 = 1e-3;
    const RADIUS_M: f64 = 0.178;
    const INDUCED_M_S: f64 = 5.0;

    /// The wake of one rotor at the origin of a vehicle that moves with `velocity`, at the end of its flight at the origin.
    fn flown(velocity: Vector3<f64>) -> Wake {
        let mut place = quad()[..1].to_vec();
        place[0].position_m = [0.0; 3];
        let mut wake = Wake::new(&place, RADIUS_M, &[INDUCED_M_S; MAX_ROTORS], STEP_S);
        for step in 0..KEPT {
            let before_s = (KEPT - 1 - step) as f64 * STEP_S;
            let position = velocity * -before_s;
            wake.step(&position, &Matrix3::identity(), &[INDUCED_M_S; MAX_ROTORS], 0.3);
        }
        wake
    }

    /// Place across the jet, along x, where the wake is fastest at `depth`, m.
    fn fastest_x_m(wake: &Wake, depth: f64, wind: &Vector3<f64>) -> f64 {
        let speed = |x: f64| wake.at(&Vector3::new(x, 0.0, -depth), wind).norm();
        let places = (-400..=400).map(|i| f64::from(i) * 1e-3);
        places.max_by(|a, b| speed(*a).total_cmp(&speed(*b))).expect("places")
    }

    #[test]
    fn in_hover_the_jet_is_straight_and_keeps_its_momentum() {
        let wake = flown(Vector3::zeros());
        let calm = Vector3::zeros();
        assert_eq!(wake.at(&Vector3::new(0.0, 0.0, 0.1), &calm), calm);
        for depth in [0.2, 0.5, 1.0] {
            assert!(fastest_x_m(&wake, depth, &calm).abs() < 1e-9);
            // The momentum flux is the integral of v² over the cross section: 2 pi sum v² x dx.
            let flux = |depth: f64| -> f64 {
                (0..2000)
                    .map(|i| f64::from(i) * 1e-3)
                    .map(|x| wake.at(&Vector3::new(x, 0.0, -depth), &calm).norm_squared() * x)
                    .sum()
            };
            assert!((flux(depth) / flux(0.01) - 1.0).abs() < 1e-3, "{depth}");
        }
    }

    #[test]
    fn forward_flight_and_wind_skew_the_jet_by_its_time_of_travel() {
        let depth = 0.4;
        let travel_s = depth / INDUCED_M_S;
        let forward = flown(Vector3::new(1.5, 0.0, 0.0));
        // Two millimetres are one step of travel at this speed.
        let skew = fastest_x_m(&forward, depth, &Vector3::zeros());
        assert!((skew + 1.5 * travel_s).abs() < 2.1e-3, "{skew}");
        let windy = fastest_x_m(&flown(Vector3::zeros()), depth, &Vector3::new(2.0, 0.0, 0.0));
        assert!((windy - 2.0 * travel_s).abs() < 2.1e-3, "{windy}");
    }

    #[test]
    fn a_change_of_thrust_reaches_a_point_below_when_it_has_travelled_there() {
        let mut wake = flown(Vector3::zeros());
        let point = Vector3::new(0.0, 0.0, -0.4);
        let calm = Vector3::zeros();
        let before = wake.at(&point, &calm).norm();
        let mut arrived = None;
        for step in 0..200 {
            // The jets follow at once, so that only the travel is late.
            wake.step(&calm, &Matrix3::identity(), &[1.1 * INDUCED_M_S; MAX_ROTORS], 1e-6);
            if wake.at(&point, &calm).norm() > 1.05 * before {
                arrived = Some(step);
                break;
            }
        }
        // 0.4 m at 5.5 m/s are 73 steps.
        assert!(arrived.is_some_and(|step| (71..=74).contains(&step)), "{arrived:?}");
    }
}
