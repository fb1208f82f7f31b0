//! The placing half of the task, from the weighed payload to the cube at rest on the surface.

use nalgebra::Vector3;

use super::{Phase, PickPlace};
use crate::notation::Coords;
use crate::task::View;
use crate::task::motion::Posture;
use crate::task::quintic::Knot;
use crate::tick::{Event, EventKind};

pub(super) const FOLD_S: f64 = 2.5;
const FOLD_HOLD_S: f64 = 0.5;
const CARRY_HOLD_S: f64 = 0.5;
const EXTEND_S: f64 = 3.5;
const PLACE_ALIGN_ABOVE_M: f64 = 0.120;
/// Gap between cube and surface at which the last plunge starts, m; a small gap and a quick plunge give the smallest placing
/// error.
const GAP_M: f64 = 0.012;
const PLACE_DESCEND_M_S: f64 = 0.06;
const PLACE_PLUNGE_M_S: f64 = 0.12;
/// Depth below the expected contact to which the reference descends until touchdown is detected, m.
const BELOW_CONTACT_M: f64 = 0.030;
/// Share of the payload's weight that the surface must carry for touchdown, and the time for which it must carry it, s.
const UNLOADED_SHARE: f64 = 0.4;
const UNLOADED_S: f64 = 0.03;
const SETTLE_IN_CONTACT_S: f64 = 0.15;
pub(super) const OPEN_S: f64 = 0.15;
pub(super) const HOLD_AFTER_OPENING_S: f64 = 0.6;
const RETREAT_M: f64 = 0.25;
const RETREAT_S: f64 = 1.6;
const LEAVE_M: f64 = 0.35;
const LEAVE_S: f64 = 2.0;
const REST_S: f64 = 1.0;

const ALIGN_WINDOW_M: f64 = 0.020;
const ALIGN_SPEED_M_S: f64 = 0.06;
const PAUSE_M: f64 = 0.030;
const WAIT_WINDOW_M: f64 = 0.012;
const WAIT_AHEAD_M: f64 = 0.014;
const WAIT_SPEED_M_S: f64 = 0.05;
const ALIGN_TIMEOUT_S: f64 = 25.0;
const WAIT_TIMEOUT_S: f64 = 40.0;
const PLUNGE_TIMEOUT_S: f64 = 4.0;

impl PickPlace {
    pub(super) fn place(&mut self, view: &View<'_>, dt_s: f64) {
        match self.phase {
            Phase::Fold if self.phase_s >= FOLD_S + FOLD_HOLD_S => self.enter(Phase::Carry),
            Phase::Carry => self.carry(),
            Phase::Extend if self.phase_s >= EXTEND_S => self.enter(Phase::PlaceAlign),
            Phase::PlaceAlign => self.place_align(dt_s),
            Phase::PlaceDescend => self.place_descend(),
            Phase::PlaceWait => self.place_wait(dt_s),
            Phase::PlacePlunge => self.place_plunge(view, dt_s),
            Phase::Touchdown if self.phase_s >= SETTLE_IN_CONTACT_S => {
                self.events.push(Event::new(EventKind::Release, "payload put down"));
                self.enter(Phase::Open);
            }
            Phase::Open if self.phase_s >= OPEN_S => {
                self.climb(Phase::Retreat, RETREAT_M, RETREAT_S);
            }
            Phase::Retreat if self.motion.arrived() => self.climb(Phase::Leave, LEAVE_M, LEAVE_S),
            Phase::Leave if self.motion.arrived() => self.enter(Phase::Rest),
            Phase::Rest if self.phase_s >= REST_S => self.finished = true,
            _ => {}
        }
    }

    /// Position of the tip that puts the cube `gap_m` above its place, m.
    fn tip_above_place(&self, gap_m: f64) -> Vector3<f64> {
        self.mission.place - self.cube_from_tip + Vector3::new(0.0, 0.0, gap_m)
    }

    fn carry(&mut self) {
        let knot = self.path.with_lead(self.phase_s);
        let q = self.mission.transit_joints;
        let lift = |v: &Vector3<f64>| Posture::new(v.x, v.y, v.z, 0.0, 0.0, 0.0);
        let posture = Posture::new(0.0, 0.0, 0.0, 0.0, q.x, q.y);
        self.motion.follow(Knot {
            value: lift(&knot.value) + posture,
            rate: lift(&knot.rate),
            acceleration: lift(&knot.acceleration),
        });
        if self.phase_s >= self.path.duration_s() + CARRY_HOLD_S {
            let tip = self.tip_above_place(PLACE_ALIGN_ABOVE_M);
            self.motion.go(self.posture_for_tip(&tip, &self.mission.grasp_joints), EXTEND_S);
            self.enter(Phase::Extend);
        }
    }

    fn place_align(&mut self, dt_s: f64) {
        let (e, _) = self.signals.errors(&self.tip_reference());
        let centred = e.xy().norm() < ALIGN_WINDOW_M && self.signals.speed() < ALIGN_SPEED_M_S;
        if self.held(centred, 0.5, dt_s) || self.phase_s > ALIGN_TIMEOUT_S {
            self.enter(Phase::PlaceDescend);
        }
    }

    fn place_descend(&mut self) {
        let target = self.tip_above_place(GAP_M);
        let (e, _) = self.signals.errors(&target);
        let speed = if e.xy().norm() > PAUSE_M { 0.0 } else { PLACE_DESCEND_M_S };
        self.motion.ramp(self.base_z(target.z), speed);
        if self.motion.arrived() {
            self.enter(Phase::PlaceWait);
        } else if self.phase_s > WAIT_TIMEOUT_S {
            self.back_above_place("never centred on the way down");
        }
    }

    fn place_wait(&mut self, dt_s: f64) {
        let (e, ahead) = self.signals.errors(&self.tip_above_place(GAP_M));
        let inside = (0..2).all(|i| e[i].abs() < WAIT_WINDOW_M && ahead[i].abs() < WAIT_AHEAD_M);
        if self.held(inside && self.signals.speed() < WAIT_SPEED_M_S, 0.05, dt_s) {
            self.r_before_plunge = self.signals.r;
            self.r_above_place = self.signals.r_slow;
            self.motion
                .ramp(self.base_z(self.tip_above_place(-BELOW_CONTACT_M).z), PLACE_PLUNGE_M_S);
            self.enter(Phase::PlacePlunge);
        } else if self.phase_s > WAIT_TIMEOUT_S {
            self.back_above_place("no centred moment above the place");
        }
    }

    fn place_plunge(&mut self, view: &View<'_>, dt_s: f64) {
        let payload_n = (self.r_loaded[2] - self.r_empty[2]).max(0.0);
        let unloaded = self.signals.r[2] < self.r_before_plunge[2] - UNLOADED_SHARE * payload_n;
        if self.held(unloaded, UNLOADED_S, dt_s) {
            let chi = &view.measurement.chi;
            let joints = self.motion.posture();
            // In contact the reference takes over the measured pose, because a position error against the surface would make the
            // estimates grow.
            self.motion.hold_at(Posture::new(chi[0], chi[1], chi[2], 0.0, joints[4], joints[5]));
            self.enter(Phase::Touchdown);
        } else if self.phase_s > PLUNGE_TIMEOUT_S {
            self.back_above_place("no surface felt");
        }
    }

    fn back_above_place(&mut self, why: &str) {
        self.retries += 1;
        if self.retries > self.mission.retry_limit {
            self.give_up(format!(
                "the cube could not be placed after {} attempts: {why}",
                self.retries
            ));
            return;
        }
        self.events.push(Event::new(EventKind::Retry, format!("placing tried again: {why}")));
        let tip = self.tip_above_place(PLACE_ALIGN_ABOVE_M);
        self.motion.go(self.posture_for_tip(&tip, &self.mission.grasp_joints), EXTEND_S);
        self.enter(Phase::Extend);
    }

    fn climb(&mut self, phase: Phase, height_m: f64, duration_s: f64) {
        let mut up = self.motion.posture();
        up.z += height_m;
        self.motion.go(up, duration_s);
        self.enter(phase);
    }

    /// Residual of the hover above the place, minus the payload's contribution (measured at the pick) on the coordinates that
    /// carry weight, N and N m.
    pub(super) fn residual_without_payload(&self) -> Coords {
        let mut step = self.r_empty - self.r_loaded;
        for row in [0, 1, 5] {
            step[row] = 0.0;
        }
        self.r_above_place + step
    }
}
