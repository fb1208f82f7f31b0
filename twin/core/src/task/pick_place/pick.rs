//! The picking half of the task, from the start to the weighed payload.

use nalgebra::Vector3;

use super::{Phase, PickPlace};
use crate::elementary::hypot;
use crate::notation::GRAVITY_M_S2;
use crate::task::View;
use crate::task::motion::Posture;
use crate::tick::{Event, EventKind};

/// Height of the tip above the cube's centre while gripping, m; lower, a finger could touch the box.
const GRIP_ABOVE_CENTRE_M: f64 = 0.006;
/// Heights of the tip above its grip height for aligning and for the start of the plunge, m.
const ALIGN_ABOVE_M: f64 = 0.150;
const PLUNGE_FROM_M: f64 = 0.060;

const SETTLE_S: f64 = 3.0;
const APPROACH_S: f64 = 3.0;
const DESCEND_M_S: f64 = 0.06;
const PLUNGE_M_S: f64 = 0.15;
/// Height of the lift, m. The cube is weighed where the empty hand was aligned, so that both are in the same ground effect.
const LIFT_M: f64 = ALIGN_ABOVE_M;
const LIFT_S: f64 = 2.0;
const LIFT_HOLD_S: f64 = 1.0;
const WEIGH_S: f64 = 1.0;
const RETRY_CLIMB_S: f64 = 1.5;

/// Windows for position (m), speed (m/s) and time (s), from the table of the grasping study.
const ALIGN_WINDOW_M: f64 = 0.015;
const ALIGN_SPEED_M_S: f64 = 0.06;
const DESCEND_PAUSE_M: f64 = 0.030;
const DESCEND_WINDOW_M: f64 = 0.008;
const DWELL_WINDOW_M: [f64; 3] = [0.012, 0.015, 0.012];
/// Clearance below which a finger is about to lean on the cube, m. A leaning finger makes the residual grow.
const LEAN_M: f64 = 0.006;
const CLOSED_SPEED_M_S: f64 = 0.002;

const ALIGN_TIMEOUT_S: f64 = 25.0;
const DESCEND_TIMEOUT_S: f64 = 30.0;
const DWELL_TIMEOUT_S: f64 = 4.0;
const CLOSE_TIMEOUT_S: f64 = 3.0;

/// Change of the residual that means contact of the hand, N: horizontal and vertical.
const CONTACT_N: [f64; 2] = [2.0, 4.0];

impl PickPlace {
    pub(super) fn pick(&mut self, view: &View<'_>, dt_s: f64) {
        match self.phase {
            Phase::Settle => self.settle(),
            Phase::Approach if self.motion.arrived() => self.enter_align(),
            Phase::Align => self.align(dt_s),
            Phase::Descend => self.descend(dt_s),
            Phase::Plunge => self.plunge(),
            Phase::Dwell => self.dwell(dt_s),
            Phase::Close => self.close(view, dt_s),
            Phase::Lift => self.lift(view),
            Phase::Weigh => self.weigh(),
            _ => {}
        }
    }

    fn grip_point(&self) -> Vector3<f64> {
        self.cube + Vector3::new(0.0, 0.0, GRIP_ABOVE_CENTRE_M)
    }

    fn settle(&mut self) {
        if self.phase_s < SETTLE_S {
            return;
        }
        if let Some(cube) = self.signals.cube {
            self.cube = cube;
            self.go_above(APPROACH_S);
            self.enter(Phase::Approach);
        } else if self.phase_s > ALIGN_TIMEOUT_S {
            self.give_up("motion capture never saw the cube");
        }
    }

    /// Flies the hand to the align height above the cube.
    fn go_above(&mut self, duration_s: f64) {
        let tip = self.grip_point() + Vector3::new(0.0, 0.0, ALIGN_ABOVE_M);
        let posture = self.posture_for_tip(&tip, &self.mission.grasp_joints);
        self.motion.go(posture, duration_s);
    }

    fn enter_align(&mut self) {
        if let Some(cube) = self.signals.cube {
            self.cube = cube;
        }
        self.go_above(0.5);
        self.enter(Phase::Align);
    }

    fn align(&mut self, dt_s: f64) {
        let (e, _) = self.signals.errors(&self.tip_reference());
        self.mean.add(&Vector3::zeros(), &self.signals.r);
        let centred = e.xy().norm() < ALIGN_WINDOW_M && self.signals.speed() < ALIGN_SPEED_M_S;
        if self.held(centred, 0.5, dt_s) || self.phase_s > ALIGN_TIMEOUT_S {
            self.r_empty = self.mean.residual;
            self.enter(Phase::Descend);
        }
    }

    fn descend(&mut self, dt_s: f64) {
        let target = self.grip_point() + Vector3::new(0.0, 0.0, PLUNGE_FROM_M);
        let (e, ahead) = self.signals.errors(&target);
        let speed = if e.xy().norm() > DESCEND_PAUSE_M { 0.0 } else { DESCEND_M_S };
        self.motion.ramp(self.base_z(target.z), speed);
        let w = DESCEND_WINDOW_M;
        let inside =
            e.x.abs() < w && e.y.abs() < w && ahead.x.abs() < 1.5 * w && ahead.y.abs() < 1.5 * w;
        let centred = self.motion.arrived() && inside && self.signals.speed() < 0.05;
        if self.held(centred, 0.05, dt_s) {
            self.motion.ramp(self.base_z(self.grip_point().z), PLUNGE_M_S);
            self.enter(Phase::Plunge);
        } else if self.phase_s > DESCEND_TIMEOUT_S {
            self.retry("the tip never stayed centred above the cube");
        }
    }

    /// Clearance of the cube between the open pads on each side, m.
    fn clearance(&self) -> f64 {
        0.5 * (self.mission.opening_m - self.mission.cube_size_m)
    }

    fn plunge(&mut self) {
        let (e, _) = self.signals.errors(&self.grip_point());
        if e.y.abs() > self.clearance() - 0.003 && e.z > 0.020 {
            self.retry("the hand drifted off the cube while plunging");
        } else if self.motion.arrived() {
            self.enter(Phase::Dwell);
        } else if self.phase_s > DWELL_TIMEOUT_S {
            self.retry("the hand did not reach the cube");
        }
    }

    fn dwell(&mut self, dt_s: f64) {
        let (e, ahead) = self.signals.errors(&self.grip_point());
        let inside =
            (0..3).all(|i| e[i].abs() < DWELL_WINDOW_M[i] && ahead[i].abs() < DWELL_WINDOW_M[i]);
        let push = self.signals.r - self.r_empty;
        let leaning = e.y.abs() > self.clearance() - LEAN_M;
        let contact = hypot(push[0], push[1]) > CONTACT_N[0]
            || (self.signals.r[2] - self.signals.r_slow[2]).abs() > CONTACT_N[1];
        if self.held(inside && self.signals.speed() < ALIGN_SPEED_M_S, 0.1, dt_s) {
            self.enter(Phase::Close);
        } else if contact || leaning {
            self.retry("the hand touched box or cube");
        } else if self.phase_s > DWELL_TIMEOUT_S {
            self.retry("no centred moment around the cube");
        }
    }

    fn close(&mut self, view: &View<'_>, dt_s: f64) {
        let gripper = view.measurement.gripper;
        let still = gripper.speed_m_s.abs() < 2.0 * CLOSED_SPEED_M_S && self.phase_s > 0.1;
        if self.held(still, 0.15, dt_s) {
            if gripper.opening_m > 0.3 * self.mission.cube_size_m
                && gripper.opening_m < 0.95 * self.mission.opening_m
            {
                let mut up = self.motion.posture();
                up.z += LIFT_M;
                self.motion.go(up, LIFT_S);
                self.events.push(Event::new(
                    EventKind::Grasp,
                    format!("fingers closed on {:.0} mm", gripper.opening_m * 1e3),
                ));
                self.enter(Phase::Lift);
            } else {
                self.retry("the fingers closed on nothing");
            }
        } else if self.phase_s > CLOSE_TIMEOUT_S {
            self.retry("the fingers did not come to rest");
        }
    }

    fn lift(&mut self, view: &View<'_>) {
        if self.phase_s < LIFT_S + LIFT_HOLD_S {
            return;
        }
        let heavier_n = self.signals.r_slow[2] - self.r_empty[2];
        let holds = heavier_n > 0.6 * self.mission.least_payload_kg * GRAVITY_M_S2
            && view.measurement.gripper.opening_m > 0.3 * self.mission.cube_size_m;
        if holds { self.enter(Phase::Weigh) } else { self.retry("the hand came up empty") }
    }

    fn weigh(&mut self) {
        if let Some(cube) = self.signals.cube {
            self.mean.add(&(cube - self.signals.tip), &self.signals.r);
        }
        if self.phase_s < WEIGH_S {
            return;
        }
        if self.mean.count < 1.0 {
            self.give_up("motion capture lost the cube while it was weighed");
            return;
        }
        self.cube_from_tip = self.mean.offset;
        self.r_loaded = self.mean.residual;
        let grams = (self.r_loaded[2] - self.r_empty[2]) / GRAVITY_M_S2 * 1e3;
        self.events.push(Event::new(EventKind::Grasp, format!("payload feels like {grams:.0} g")));
        let start = self.path.start();
        let q = self.mission.transit_joints;
        self.motion
            .go(Posture::new(start.x, start.y, start.z, 0.0, q.x, q.y), super::place::FOLD_S);
        self.enter(Phase::Fold);
    }

    /// Opens the gripper, climbs and tries again, or gives up after too many attempts.
    fn retry(&mut self, why: &str) {
        self.retries += 1;
        if self.retries > self.mission.retry_limit {
            self.give_up(format!("no grasp after {} attempts: {why}", self.retries));
            return;
        }
        self.events.push(Event::new(
            EventKind::Retry,
            format!("attempt {} given up: {why}", self.retries),
        ));
        if let Some(cube) = self.signals.cube {
            self.cube = cube;
        }
        self.go_above(RETRY_CLIMB_S);
        self.enter(Phase::Approach);
    }
}
