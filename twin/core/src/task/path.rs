//! The transport paths of the paper's scenarios, timed by arc length: constant cruise speed between quintic ramps.

use nalgebra::{Vector1, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::quintic::{Knot, Quintic};
use crate::elementary::{powi, sin_cos};

/// Duration of the ramps at both ends of a path, s.
const RAMP_S: f64 = 1.0;

/// Delay with which a desired lateral force takes effect, s: command filter 2 zeta / omega = 0.12, rotors 0.045, low-pass on
/// `r_hat` 0.03. On a known path the force can be demanded that much earlier.
const LATERAL_LAG_S: f64 = 0.2;

/// Number of intervals of the arc-length table.
const TABLE: usize = 4000;

/// Shape of a path of the vehicle's base, with parameter `u` in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "shape")]
pub enum Curve {
    /// Scenario A: a path from `from` over `length_m` along x that sways by `sway_m` along y and rises by `rise_m` with a swing
    /// of `bob_m`.
    S {
        /// Start, m.
        from: [f64; 3],
        /// Extent along x, m.
        length_m: f64,
        /// Amplitude along y, m.
        sway_m: f64,
        /// Rise over the path, m.
        rise_m: f64,
        /// Amplitude of the vertical swing, m.
        bob_m: f64,
    },
    /// Scenario B: figure-8 `(a sin w, b sin 2w)` around `centre`.
    FigureEight {
        /// Crossing point, m.
        centre: [f64; 3],
        /// Half extent along x, m.
        a_m: f64,
        /// Half extent along y, m.
        b_m: f64,
        /// Number of laps.
        laps: f64,
    },
}

impl Curve {
    /// Point at `u` with its first and second derivative with respect to `u`, m.
    pub fn at(&self, u: f64) -> [Vector3<f64>; 3] {
        match *self {
            Self::S { from, length_m, sway_m, rise_m, bob_m } => {
                let (s, c) = sin_cos(TAU * u);
                [
                    Vector3::from(from)
                        + Vector3::new(length_m * u, sway_m * s, rise_m * u + bob_m * s),
                    Vector3::new(length_m, sway_m * TAU * c, rise_m + bob_m * TAU * c),
                    Vector3::new(0.0, sway_m, bob_m) * (-TAU * TAU * s),
                ]
            }
            Self::FigureEight { centre, a_m, b_m, laps } => {
                let k = TAU * laps;
                let (s1, c1) = sin_cos(k * u);
                let (s2, c2) = sin_cos(2.0 * k * u);
                [
                    Vector3::from(centre) + Vector3::new(a_m * s1, b_m * s2, 0.0),
                    Vector3::new(a_m * c1, 2.0 * b_m * c2, 0.0) * k,
                    Vector3::new(-a_m * s1, -4.0 * b_m * s2, 0.0) * (k * k),
                ]
            }
        }
    }
}

/// A curve flown at a speed.
#[derive(Clone, Debug)]
pub struct TimedPath {
    curve: Curve,
    /// Arc length at `u = i / TABLE`, m.
    arc_m: Vec<f64>,
    speed_m_s: f64,
    ramp_s: f64,
}

impl TimedPath {
    /// A path along `curve` at cruise speed `speed_m_s`. A path that is too short for its ramps gets shorter ramps.
    pub fn new(curve: Curve, speed_m_s: f64) -> Self {
        let mut arc_m = Vec::with_capacity(TABLE + 1);
        let mut total = 0.0;
        arc_m.push(0.0);
        for i in 0..TABLE {
            // Midpoint rule: error O(1/TABLE^2).
            total += curve.at((i as f64 + 0.5) / TABLE as f64)[1].norm() / TABLE as f64;
            arc_m.push(total);
        }
        let ramp_s = RAMP_S.min(total / speed_m_s);
        Self { curve, arc_m, speed_m_s, ramp_s }
    }

    /// Length of the path, m.
    pub fn length_m(&self) -> f64 {
        self.arc_m.last().copied().unwrap_or(0.0)
    }

    /// Duration including the ramps, s. A ramp covers half of the distance of cruising for the same time.
    pub fn duration_s(&self) -> f64 {
        self.length_m() / self.speed_m_s + self.ramp_s
    }

    /// Whether the path is at cruise speed at `t_s`.
    pub fn cruising(&self, t_s: f64) -> bool {
        t_s > self.ramp_s && t_s < self.duration_s() - self.ramp_s
    }

    /// Start of the path, m.
    pub fn start(&self) -> Vector3<f64> {
        self.curve.at(0.0)[0]
    }

    /// Position, velocity and acceleration at `t_s`; at rest before the start and after the end.
    pub fn at(&self, t_s: f64) -> Knot<3> {
        let (s, s_dot, s_ddot) = self.arc_at(t_s.clamp(0.0, self.duration_s()));
        let u = self.parameter_at(s);
        let [p, p_u, p_uu] = self.curve.at(u);
        let n = p_u.norm().max(1e-9);
        let u_dot = s_dot / n;
        let u_ddot = (s_ddot - u_dot * u_dot * p_u.dot(&p_uu) / n) / n;
        Knot { value: p, rate: p_u * u_dot, acceleration: p_u * u_ddot + p_uu * (u_dot * u_dot) }
    }

    /// Position and velocity at `t_s`, but the lateral acceleration at `t_s` + `LATERAL_LAG_S`.
    pub fn with_lead(&self, t_s: f64) -> Knot<3> {
        let mut knot = self.at(t_s);
        let ahead = self.at(t_s + LATERAL_LAG_S).acceleration;
        (knot.acceleration.x, knot.acceleration.y) = (ahead.x, ahead.y);
        knot
    }

    /// Arc length (m), speed (m/s) and tangential acceleration (m/s²) at `t_s`; the speed of a ramp is a quintic from 0 to cruise
    /// speed.
    fn arc_at(&self, t_s: f64) -> (f64, f64, f64) {
        let (v, ramp, total) = (self.speed_m_s, self.ramp_s, self.duration_s());
        let rise = |t: f64| {
            let q = Quintic::to_rest(&Knot::rest(Vector1::zeros()), &Vector1::new(v), ramp).at(t);
            let x = t / ramp;
            // Integral of v (10 x^3 - 15 x^4 + 6 x^5).
            (v * ramp * (2.5 * powi(x, 4) - 3.0 * powi(x, 5) + powi(x, 6)), q.value.x, q.rate.x)
        };
        if t_s < ramp {
            rise(t_s)
        } else if t_s > total - ramp {
            let (s, s_dot, s_ddot) = rise(total - t_s);
            (self.length_m() - s, s_dot, -s_ddot)
        } else {
            (v * (t_s - 0.5 * ramp), v, 0.0)
        }
    }

    fn parameter_at(&self, s: f64) -> f64 {
        let i = self.arc_m.partition_point(|a| *a <= s).clamp(1, TABLE);
        let (low, high) = (self.arc_m[i - 1], self.arc_m[i]);
        let fraction = if high > low { ((s - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
        (i as f64 - 1.0 + fraction) / TABLE as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curves() -> [Curve; 2] {
        [
            Curve::S {
                from: [-1.5, 0.0, 1.0],
                length_m: 3.0,
                sway_m: 0.5,
                rise_m: 0.3,
                bob_m: 0.2,
            },
            Curve::FigureEight { centre: [0.0, 0.0, 1.25], a_m: 1.2, b_m: 0.6, laps: 2.0 },
        ]
    }

    #[test]
    fn cruise_speed_is_the_speed_asked_for() {
        for curve in curves() {
            for speed in [0.5, 1.0] {
                let path = TimedPath::new(curve, speed);
                let mut t = 0.0;
                while t < path.duration_s() {
                    let v = path.at(t).rate.norm();
                    assert!(v <= speed * (1.0 + 1e-9));
                    if path.cruising(t) {
                        assert!((v - speed).abs() < 1e-9, "{v} at {t}");
                    }
                    t += 0.01;
                }
            }
        }
    }

    #[test]
    fn velocity_and_acceleration_are_derivatives_of_position() {
        // The arc-length table is linear between its points, so u jumps in slope by 1/TABLE.
        const TABLE_TOLERANCE: f64 = 5e-3;
        for curve in curves() {
            let path = TimedPath::new(curve, 1.0);
            let h = 1e-3;
            for i in 1..100 {
                let t = path.duration_s() * f64::from(i) / 100.0;
                let (a, b, c) = (path.at(t - h), path.at(t), path.at(t + h));
                assert!(((c.value - a.value) / (2.0 * h) - b.rate).norm() < TABLE_TOLERANCE);
                assert!(
                    ((c.rate - a.rate) / (2.0 * h) - b.acceleration).norm()
                        < 10.0 * TABLE_TOLERANCE,
                    "at {t}"
                );
            }
        }
    }

    #[test]
    fn a_path_begins_and_ends_at_rest_at_its_ends() {
        for curve in curves() {
            let path = TimedPath::new(curve, 0.5);
            for (t, u) in [(0.0, 0.0), (path.duration_s(), 1.0)] {
                let knot = path.at(t);
                assert!(knot.rate.norm() < 1e-9 && (knot.value - curve.at(u)[0]).norm() < 1e-6);
            }
        }
    }
}
