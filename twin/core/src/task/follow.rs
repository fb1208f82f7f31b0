//! Flies the transport path, with or without a payload in the hand: the task of payload-free flights and of tracking studies.

use nalgebra::{Vector2, Vector3};

use super::motion::{Motion, Posture};
use super::path::{Curve, TimedPath};
use super::quintic::Knot;
use super::{Step, Task, View};
use crate::tick::{Event, EventKind, GripperCommand, Reference};

const SETTLE_S: f64 = 3.0;
const APPROACH_S: f64 = 3.0;
const REST_S: f64 = 2.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Settle,
    Approach,
    Path,
    Rest,
}

/// Settles, flies to the start of the path, follows it, and rests.
#[derive(Clone, Debug)]
pub struct FollowPath {
    motion: Motion,
    path: TimedPath,
    joints: Vector2<f64>,
    gripper: GripperCommand,
    phase: Phase,
    phase_s: f64,
}

impl FollowPath {
    /// A task that flies from `start` (m) along `curve` at `speed_m_s` with the arm at `joints` (rad).
    pub fn new(
        start: Vector3<f64>,
        curve: Curve,
        speed_m_s: f64,
        joints: Vector2<f64>,
        gripper: GripperCommand,
    ) -> Self {
        Self {
            motion: Motion::new(posture(&start, &joints)),
            path: TimedPath::new(curve, speed_m_s),
            joints,
            gripper,
            phase: Phase::Settle,
            phase_s: 0.0,
        }
    }

    fn next_phase(&mut self) -> Option<Event> {
        let (next, sentence) = match self.phase {
            Phase::Settle if self.phase_s >= SETTLE_S => {
                self.motion.go(posture(&self.path.start(), &self.joints), APPROACH_S);
                (Phase::Approach, "flying to the start of the path")
            }
            Phase::Approach if self.motion.arrived() => (Phase::Path, "following the path"),
            Phase::Path if self.phase_s >= self.path.duration_s() => {
                (Phase::Rest, "hovering at the end of the path")
            }
            _ => return None,
        };
        self.phase = next;
        self.phase_s = 0.0;
        Some(Event::new(EventKind::Phase, sentence))
    }
}

fn posture(position: &Vector3<f64>, joints: &Vector2<f64>) -> Posture {
    Posture::new(position.x, position.y, position.z, 0.0, joints.x, joints.y)
}

impl Task for FollowPath {
    fn update(&mut self, _view: &View<'_>, dt_s: f64) -> Step {
        self.phase_s += dt_s;
        let events = self.next_phase().into_iter().collect();
        if self.phase == Phase::Path {
            let knot = self.path.with_lead(self.phase_s);
            let none = Vector2::zeros();
            self.motion.follow(Knot {
                value: posture(&knot.value, &self.joints),
                rate: posture(&knot.rate, &none),
                acceleration: posture(&knot.acceleration, &none),
            });
        }
        self.motion.step(dt_s);
        Step {
            reference: Reference {
                transporting: self.phase == Phase::Path,
                cruising: self.phase == Phase::Path && self.path.cruising(self.phase_s),
                ..self.motion.reference(self.gripper)
            },
            phase: match self.phase {
                Phase::Settle => "settle",
                Phase::Approach => "approach",
                Phase::Path => "carry",
                Phase::Rest => "rest",
            },
            events,
            finished: self.phase == Phase::Rest && self.phase_s >= REST_S,
            gave_up: None,
        }
    }
}
