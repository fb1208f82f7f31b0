//! Compares the twin with a recorded flight: the twin starts where the vehicle was, flies under the recorded commands, and its path is
//! compared with the path of the vehicle.
//!
//! The twin is one rigid body in Rapier. Its mass and inertia are the known ones or those of a URDF; its joints are locked at their
//! recorded angles. The recorded force was delayed by the filter `H`, so the twin reads it later by that delay. Where the torque in N m is
//! unknown, the twin keeps the recorded attitude and only the position is compared. The twin flies twice from each start: without a
//! residual, and with the mean residual of the half second before the start.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

pub use super::divergence_report::{AXES, HORIZONS, PredictionError, TwinFlight};
use super::divergence_report::{Axis, Report, report};
use crate::OpenedFlight;
use crate::playback::{Cursor, Playback};
use twin_core::notation::{
    Coords, GRAVITY_M_S2, TICK_S, attitude, body_rate_from_euler_rate, euler_from_rotation,
    euler_rate_from_body_rate, position, world_from_body, wrap_angle,
};
use twin_core::tick::Measurement;
use twin_plant::model::{Inertial, ModelError, Packages, Robot};
use twin_plant::{FreeBody, Motion, Wrench, locked};

/// Number of ticks of the twin's longest flight.
const LAST: usize = HORIZONS[2];

/// Number of ticks before the start over which the residual is averaged.
const BEFORE: usize = 50;

/// Number of ticks on either side of the start whose poses give the rates at the start. The rates are the slope of these poses, so no
/// filter delays them.
const SLOPE: usize = 4;

/// Group delay of one pass of `H` (`sqrt 2 / (2 pi 8 Hz)`), ticks.
const PASS_TICKS: f64 = 2.813_5;

/// Largest number of flights of the twin along one recording.
const MOST_STARTS: usize = 100;

/// Inertia per mass that stands for an unknown inertia, m². Only a known torque would use it, and a vehicle of unknown inertia has no known
/// torque.
const GUESSED_INERTIA_M2: f64 = 0.01;

/// Vehicle that the twin flies.
#[derive(Clone, Debug)]
pub struct Twin {
    form: Form,
    /// Description of the vehicle for people.
    pub says: String,
}

#[derive(Clone, Debug)]
enum Form {
    Body(Inertial),
    /// A URDF model with the indices of the joints that have the coordinates q1 and q2.
    Robot(Box<Robot>, Vec<usize>),
}

impl Twin {
    /// One rigid body with the known mass and inertia of the recorded vehicle.
    pub fn of(opened: &OpenedFlight) -> Self {
        let (facts, recorded) = (&opened.map.vehicle, &opened.recorded);
        let nominal = recorded.nominal_inertia.map(|m| [m[3], m[4], m[5]]);
        let known = facts.inertia_kg_m2.or(nominal);
        let moments = known.unwrap_or([GUESSED_INERTIA_M2 * recorded.mass_kg; 3]);
        let mass = if opened.per_kilogram() {
            "of 1 kg, because the mass is unknown".to_owned()
        } else {
            format!("of {:.3} kg", recorded.mass_kg)
        };
        let inertia = known.map_or_else(
            || "inertia unknown".to_owned(),
            |[x, y, z]| format!("inertia {x:.4}, {y:.4}, {z:.4} kg m2"),
        );
        let inertial = Inertial {
            mass_kg: recorded.mass_kg,
            com_in_link: Vector3::zeros(),
            inertia_in_link: Matrix3::from_diagonal(&Vector3::from(moments)),
        };
        let says = format!("a stand-in: one rigid body {mass}, {inertia}");
        Self { form: Form::Body(inertial), says }
    }

    /// The vehicle that the URDF describes; `joint_names` are the joints that have the coordinates q1 and q2.
    ///
    /// # Errors
    /// [`ModelError`] if the URDF cannot be read.
    pub fn urdf(file: &Path, joint_names: &[String]) -> Result<Self, ModelError> {
        let robot = Robot::load(file, &Packages::default())?;
        let joints: Vec<usize> = joint_names.iter().filter_map(|name| robot.joint(name)).collect();
        let name = PathBuf::from(file.file_name().unwrap_or_default()).display().to_string();
        let says = format!(
            "{name}: {:.3} kg, {} joints locked where the recording has them, any other at zero",
            robot.total_mass_kg(),
            joints.len()
        );
        Ok(Self { form: Form::Robot(Box::new(robot), joints), says })
    }

    fn inertial(&self, chi: &Coords) -> Inertial {
        match &self.form {
            Form::Body(inertial) => *inertial,
            Form::Robot(robot, joints) => {
                let mut angles = vec![0.0; robot.joints.len()];
                for (row, joint) in joints.iter().enumerate().take(2) {
                    angles[*joint] = chi[AXES + row];
                }
                locked(robot, &angles)
            }
        }
    }
}

/// Flies the twin from any tick of a recorded flight.
#[derive(Clone, Debug)]
pub struct Flyer {
    playback: Arc<Playback>,
    twin: Twin,
    delay_ticks: f64,
    /// False if the torque is only fitted: it predicts the attitude worse than coasting, so the twin keeps the recorded attitude.
    own_attitude: bool,
    /// Mass in kg that the recorded forces belong to, if it is not the mass of the twin.
    of_kg: Option<f64>,
}

impl Flyer {
    /// A flyer of `twin` beside `playback`, the flight of `opened`.
    pub fn new(playback: &Arc<Playback>, opened: &OpenedFlight, twin: Twin) -> Self {
        let delay_ticks = PASS_TICKS * opened.recorded.acceleration[0].passes() as f64;
        let own_attitude = opened.recorded.fitted_inertia().is_none();
        let of_kg = opened.per_kilogram().then_some(opened.recorded.mass_kg);
        Self { playback: Arc::clone(playback), twin, delay_ticks, own_attitude, of_kg }
    }

    /// Description of the twin for people.
    pub fn says(&self) -> &str {
        &self.twin.says
    }

    /// Number of ticks after the start that a flight of `ticks` ticks reads from the recording.
    pub fn reach(&self, ticks: usize) -> usize {
        ticks + (self.delay_ticks.ceil() as usize + 1).max(SLOPE)
    }

    /// Flies the twin from tick `start` over all horizons; `None` if force or motion is unknown at one of the ticks it reads.
    pub fn from(&self, start: usize) -> Option<TwinFlight> {
        let clip = self.clip(start, LAST)?;
        let after = self.misses(&clip)?;
        let after = std::array::from_fn(|i| after[i]);
        Some(TwinFlight { t_s: clip.frame(0).t_s, free: clip.free, after })
    }

    /// Error of the twin at the second horizon (0.5 s) after the start `start`, m and rad.
    pub fn half_second(&self, start: usize) -> Option<[PredictionError; AXES]> {
        self.misses(&self.clip(start, HORIZONS[1])?)?.get(1).copied()
    }

    /// Flies the twin from evenly spaced starts along the recording.
    pub fn along(&self) -> Report {
        let every = (self.playback.ticks() / MOST_STARTS).max(HORIZONS[1]);
        let starts = (0..self.playback.ticks()).step_by(every);
        let shots: Vec<TwinFlight> = starts.filter_map(|start| self.from(start)).collect();
        let held = if self.own_attitude {
            "recorded force; the attitude is as recorded, because no torque is known"
        } else {
            "recorded force; the attitude is as recorded, because a torque that is only fitted says it worse than coasting"
        };
        report(&self.twin.says, held, &shots)
    }

    /// The recorded ticks around a start; `None` if force or motion is unknown at one of them.
    fn clip(&self, start: usize, ticks: usize) -> Option<Clip> {
        let first = start.checked_sub(BEFORE)?;
        let mut cursor = Cursor::new(&self.playback);
        let mut frames = (first..=start + self.reach(ticks))
            .map(|tick| cursor.frame(tick).filter(|frame| known(frame, 0..3)).cloned())
            .collect::<Option<Vec<Measurement>>>()?;
        if let Some(of_kg) = self.of_kg {
            let share = self.twin.inertial(&frames[BEFORE].chi).mass_kg / of_kg;
            for frame in &mut frames {
                for row in 0..3 {
                    frame.tau_applied[row] *= share;
                }
            }
        }
        let free = self.own_attitude && frames.iter().all(|frame| known(frame, 3..AXES));
        let attitude = frames.iter().all(|frame| frame.chi.known()[3..AXES] == [true; 3]);
        attitude.then_some(Clip { frames, free, ticks })
    }

    /// Errors at each horizon within the clip.
    fn misses(&self, clip: &Clip) -> Option<Vec<[PredictionError; AXES]>> {
        let inertial = self.twin.inertial(&clip.frame(0).chi);
        let rates = clip.rates()?;
        let chi = clip.frame(0).chi;
        let twin = self.flown(clip, &inertial, &rates, None)?;
        let residual = clip.residual(&inertial);
        let with_residual = self.flown(clip, &inertial, &rates, Some(&residual))?;
        let horizons = HORIZONS.iter().filter(|ticks| **ticks <= clip.ticks);
        let miss = |(i, ticks): (usize, &usize)| {
            let there = clip.frame(*ticks).chi;
            let coasted: Axis =
                std::array::from_fn(|row| chi[row] + rates[row] * (*ticks as f64 * TICK_S));
            std::array::from_fn(|row| {
                let off = |from: &Axis| {
                    let off = from[row] - there[row];
                    (row < 3 || clip.free).then(|| if row < 3 { off } else { wrap_angle(off) })
                };
                PredictionError {
                    twin: off(&twin[i]),
                    with_residual: off(&with_residual[i]),
                    coasting: off(&coasted),
                }
            })
        };
        Some(horizons.enumerate().map(miss).collect())
    }

    /// Pose of the twin at each horizon: m and ZYX Euler angles in rad.
    fn flown(
        &self,
        clip: &Clip,
        inertial: &Inertial,
        rates: &SVector<f64, AXES>,
        residual: Option<&SVector<f64, AXES>>,
    ) -> Option<Vec<Axis>> {
        let start = &clip.frame(0).chi;
        let (eta, eta_dot) = (attitude(start), rates.fixed_rows::<3>(3).into_owned());
        // A body that keeps the recorded attitude moves as a point: nobody knows how an eccentric centre of mass would turn it.
        let com = if clip.free { inertial.com_in_link } else { Vector3::zeros() };
        let mut body = FreeBody::new(&Inertial { com_in_link: com, ..*inertial });
        let body_rate =
            if clip.free { body_rate_from_euler_rate(&eta) * eta_dot } else { Vector3::zeros() };
        body.put(&Motion {
            position: position(start),
            rotation: world_from_body(&eta),
            velocity: rates.fixed_rows::<3>(0).into_owned(),
            body_rate,
        });
        let mut places = Vec::new();
        for tick in 1..=clip.ticks {
            body.tick(&clip.wrench(tick - 1, self.delay_ticks, residual));
            if HORIZONS.contains(&tick) {
                let motion = body.motion();
                let eta = euler_from_rotation(&motion.rotation);
                places.push(std::array::from_fn(|row| {
                    if row < 3 { motion.position[row] } else { eta[row - 3] }
                }));
            }
        }
        places.iter().flatten().all(|v: &f64| v.is_finite()).then_some(places)
    }
}

/// True if the motion is known in these coordinates, and also the force while the vehicle flies.
fn known(frame: &Measurement, rows: std::ops::Range<usize>) -> bool {
    let (moved, pushed) = (frame.chi.known(), frame.residual_known());
    rows.into_iter().all(|row| moved[row] && pushed[row])
}

/// The recorded ticks around a start: the half second before it, the flight, and the later ticks that the delayed commands need.
struct Clip {
    frames: Vec<Measurement>,
    free: bool,
    ticks: usize,
}

impl Clip {
    /// The recorded tick `after` ticks after the start.
    fn frame(&self, after: usize) -> &Measurement {
        &self.frames[(BEFORE + after).min(self.frames.len() - 1)]
    }

    /// Slope of the pose at the start, by least squares.
    fn rates(&self) -> Option<SVector<f64, AXES>> {
        let around = self.frames.get(BEFORE - SLOPE..=BEFORE + SLOPE)?;
        let mut sums = SMatrix::<f64, AXES, 1>::zeros();
        let mut squares = 0.0;
        for (i, frame) in around.iter().enumerate() {
            let t_s = (i as f64 - SLOPE as f64) * TICK_S;
            sums += frame.chi.fixed_rows::<AXES>(0) * t_s;
            squares += t_s * t_s;
        }
        Some(sums / squares)
    }

    /// Mean residual before the start, N and N m: the applied force minus the force that explains the motion. Its negative acts on the
    /// twin.
    fn residual(&self, inertial: &Inertial) -> SVector<f64, AXES> {
        let before = &self.frames[..BEFORE];
        let mut mean = SVector::<f64, AXES>::zeros();
        for m in before {
            for row in 0..AXES {
                let inertia = match row {
                    0..3 => inertial.mass_kg,
                    _ => inertial.inertia_in_link[(row - 3, row - 3)],
                };
                mean[row] += (m.tau_applied[row] - inertia * m.chi_ddot[row]) / BEFORE as f64;
            }
        }
        mean[2] -= inertial.mass_kg * GRAVITY_M_S2;
        mean
    }

    /// Force and torque on the twin from tick `after` to the next tick.
    fn wrench(
        &self,
        after: usize,
        delay_ticks: f64,
        residual: Option<&SVector<f64, AXES>>,
    ) -> Wrench {
        let at = after as f64 + 0.5 + delay_ticks;
        let (tick, share) = (at.floor() as usize, at.fract());
        let tau = *self.frame(tick).tau_applied * (1.0 - share)
            + *self.frame(tick + 1).tau_applied * share;
        let lacking = residual.copied().unwrap_or_else(SVector::zeros);
        let force = position(&tau);
        let in_world = -lacking.fixed_rows::<3>(0).into_owned();
        if !self.free {
            return Wrench::Held(force + in_world);
        }
        let (here, next) = (attitude(&self.frame(after).chi), &self.frame(after + 1).chi);
        let eta = (here + attitude(next)) * 0.5;
        let moment = attitude(&tau) - lacking.fixed_rows::<3>(3);
        let torque = euler_rate_from_body_rate(&eta).transpose() * moment;
        Wrench::Free { in_body: [world_from_body(&eta).transpose() * force, torque], in_world }
    }
}

#[cfg(test)]
#[path = "divergence_tests.rs"]
mod tests;
