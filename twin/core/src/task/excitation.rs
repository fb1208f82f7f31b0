//! Random way-points one after the other: the task of the flights that give training data, and of the flight on which predictors are
//! tested.
//!
//! Each way-point is reached at rest on one quintic. Positions, heading and arm are drawn uniformly from a box, the speed uniformly from a
//! range. All draws follow from a seed. State: the moving reference and the random generator.

use nalgebra::{Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::motion::{Motion, Posture};
use super::{Step, Task, View};
use crate::tick::{GripperCommand, Reference};

/// Number that keeps these draws independent of other draws with the same seed.
const STREAM: u64 = 0x3a7b_0175;

/// Time for the vehicle to settle before the first way-point, s.
const SETTLE_S: f64 = 1.0;

/// Peak rate and peak acceleration of a quintic from rest to rest, of unit length in unit time.
const PEAK_RATE: f64 = 1.875;
const PEAK_ACCELERATION: f64 = 5.7735;

/// Largest rate of the arm and of the heading, rad/s.
const TURN_RAD_S: f64 = 1.5;

/// Where way-points may lie and how they are flown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Smallest and largest base position, m.
    pub position_m: [Vector3<f64>; 2],
    /// Smallest and largest joint angles, rad.
    pub joints_rad: [Vector2<f64>; 2],
    /// Largest heading to either side, rad.
    pub yaw_rad: f64,
    /// Smallest and largest mean speed between two way-points, m/s.
    pub mean_speed_m_s: [f64; 2],
    /// Largest acceleration of the reference, m/s².
    pub acceleration_m_s2: f64,
}

/// Flies from way-point to way-point for a time.
#[derive(Clone, Debug)]
pub struct Excitation {
    motion: Motion,
    region: Region,
    rng: Pcg64,
    duration_s: f64,
    gripper: GripperCommand,
    time_s: f64,
}

impl Excitation {
    /// A task from `start` (m) with the arm at `joints` (rad), for `duration_s`.
    pub fn new(
        (start, joints): (Vector3<f64>, Vector2<f64>),
        region: Region,
        duration_s: f64,
        gripper: GripperCommand,
        seed: u64,
    ) -> Self {
        let posture = Posture::new(start.x, start.y, start.z, 0.0, joints.x, joints.y);
        Self {
            motion: Motion::new(posture),
            region,
            rng: Pcg64::seed_from_u64(seed ^ STREAM),
            duration_s,
            gripper,
            time_s: 0.0,
        }
    }

    fn next(&mut self) {
        let Region { position_m, joints_rad, yaw_rad, mean_speed_m_s, acceleration_m_s2 } =
            self.region;
        let mut between = |low: f64, high: f64| low + (high - low) * self.rng.random::<f64>();
        let position = position_m[0].zip_map(&position_m[1], &mut between);
        let yaw = between(-yaw_rad, yaw_rad);
        let joints = joints_rad[0].zip_map(&joints_rad[1], &mut between);
        let speed_m_s = between(mean_speed_m_s[0], mean_speed_m_s[1]);
        let to = Posture::new(position.x, position.y, position.z, yaw, joints.x, joints.y);
        let way = to - self.motion.posture();
        let distance_m = way.fixed_rows::<3>(0).norm();
        let turn_rad = way.fixed_rows::<3>(3).amax();
        let duration_s = (distance_m / speed_m_s)
            .max((PEAK_ACCELERATION * distance_m / acceleration_m_s2).sqrt())
            .max(PEAK_RATE * turn_rad / TURN_RAD_S);
        self.motion.go(to, duration_s);
    }
}

impl Task for Excitation {
    fn update(&mut self, view: &View<'_>, dt_s: f64) -> Step {
        self.time_s += dt_s;
        if self.motion.arrived() && self.time_s > SETTLE_S {
            self.next();
        }
        self.motion.step(dt_s);
        Step {
            reference: Reference {
                transporting: self.gripper == GripperCommand::Close,
                ..self.motion.reference(self.gripper)
            },
            phase: "excitation",
            events: Vec::new(),
            finished: view.measurement.t_s >= self.duration_s,
            gave_up: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notation::Coords;
    use crate::tick::{GripperReading, Measurement};

    const DT_S: f64 = 0.01;

    fn region() -> Region {
        Region {
            position_m: [Vector3::new(-1.2, -1.2, 0.5), Vector3::new(1.2, 1.2, 1.6)],
            joints_rad: [Vector2::new(-0.43, 1.05), Vector2::new(0.73, 1.43)],
            yaw_rad: 0.3,
            mean_speed_m_s: [0.3, 1.2],
            acceleration_m_s2: 2.0,
        }
    }

    /// The references of a flight of five minutes.
    fn flown(seed: u64) -> Vec<Reference> {
        let start = (Vector3::new(0.0, 0.0, 1.2), Vector2::new(0.3, 1.2));
        let mut task = Excitation::new(start, region(), 300.0, GripperCommand::Open, seed);
        let zero = Coords::zeros();
        (1..=30_000)
            .map(|tick| {
                let measurement = Measurement {
                    t_s: f64::from(tick) * DT_S,
                    chi: zero.into(),
                    chi_dot: zero.into(),
                    chi_ddot: zero.into(),
                    tau_applied: zero.into(),
                    gripper: GripperReading::default(),
                    payload: None,
                    saturated: false,
                    airborne: true,
                };
                let view = View { measurement: &measurement, residual: &zero.into() };
                let step = task.update(&view, DT_S);
                assert_eq!(step.finished, tick == 30_000);
                step.reference
            })
            .collect()
    }

    #[test]
    fn way_points_fill_the_box_and_stay_in_it_within_the_limits() {
        let references = flown(1);
        let (mut low, mut high) = (*references[0].chi_des, *references[0].chi_des);
        for reference in &references {
            low = low.zip_map(&reference.chi_des, f64::min);
            high = high.zip_map(&reference.chi_des, f64::max);
            let acceleration = reference.chi_des_ddot.fixed_rows::<3>(0).norm();
            assert!(acceleration <= 2.0 * 1.001, "{acceleration}");
            let turn = reference.chi_des_dot.fixed_rows::<3>(5).amax();
            assert!(turn <= TURN_RAD_S * 1.001, "{turn}");
        }
        let bounds = region();
        for axis in 0..3 {
            let (from, to) = (bounds.position_m[0][axis], bounds.position_m[1][axis]);
            assert!(low[axis] >= from && high[axis] <= to);
            // Some hundred draws leave less than a tenth of the range at either end unvisited.
            assert!(high[axis] - low[axis] > 0.8 * (to - from), "axis {axis}");
        }
        assert!(low[5] >= -0.3 && high[5] <= 0.3 && high[5] - low[5] > 0.48);
        assert!(high[6] - low[6] > 0.9 && high[7] - low[7] > 0.3);
    }

    #[test]
    fn the_seed_decides_the_way_points() {
        assert!(flown(1) == flown(1));
        assert!(flown(1) != flown(2));
    }
}
