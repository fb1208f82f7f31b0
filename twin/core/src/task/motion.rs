//! The moving reference `[x y z psi q1 q2]`: segments to a goal, and vertical ramps that may pause.

use nalgebra::SVector;

use super::quintic::{Knot, Quintic};
use crate::notation::Coords;
use crate::tick::{Adaptation, GripperCommand, Reference};

/// `[x y z psi q1 q2]`, m and rad.
pub type Posture = SVector<f64, 6>;

/// Acceleration of a vertical ramp, m/s².
const RAMP_ACCELERATION_M_S2: f64 = 1.0;

#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one of it, and it is copied")]
enum Mode {
    Hold,
    Segment { quintic: Quintic<6>, t_s: f64 },
    Ramp { goal_z_m: f64, speed_m_s: f64 },
}

/// The moving reference; always continuous in position and rate.
#[derive(Clone, Debug)]
pub struct Motion {
    knot: Knot<6>,
    mode: Mode,
}

impl Motion {
    /// A reference at rest at `posture`.
    pub fn new(posture: Posture) -> Self {
        Self { knot: Knot::rest(posture), mode: Mode::Hold }
    }

    /// The present reference.
    pub fn posture(&self) -> Posture {
        self.knot.value
    }

    /// Moves to rest at `to` within `duration_s`, starting from the present position and rate.
    pub fn go(&mut self, to: Posture, duration_s: f64) {
        self.mode =
            Mode::Segment { quintic: Quintic::to_rest(&self.knot, &to, duration_s), t_s: 0.0 };
    }

    /// Moves vertically towards `goal_z_m` with at most `speed_m_s`; a speed of 0 pauses the ramp.
    pub fn ramp(&mut self, goal_z_m: f64, speed_m_s: f64) {
        self.mode = Mode::Ramp { goal_z_m, speed_m_s };
    }

    /// Jumps to rest at `posture`. Allowed in contact only, where the reference may follow the measured pose.
    pub fn hold_at(&mut self, posture: Posture) {
        *self = Self::new(posture);
    }

    /// Follows a given knot of a timed path.
    pub fn follow(&mut self, knot: Knot<6>) {
        self.knot = knot;
        self.mode = Mode::Hold;
    }

    /// True if the goal is reached and the reference is at rest.
    pub fn arrived(&self) -> bool {
        match self.mode {
            Mode::Hold => true,
            Mode::Segment { quintic, t_s } => t_s >= quintic.duration_s(),
            Mode::Ramp { goal_z_m, .. } => {
                (self.knot.value.z - goal_z_m).abs() < 1e-4 && self.knot.rate.z.abs() < 1e-3
            }
        }
    }

    /// Advances the reference by one tick.
    pub fn step(&mut self, dt_s: f64) {
        match &mut self.mode {
            Mode::Hold => {}
            Mode::Segment { quintic, t_s } => {
                *t_s += dt_s;
                self.knot = quintic.at(*t_s);
            }
            Mode::Ramp { goal_z_m, speed_m_s } => {
                let a = RAMP_ACCELERATION_M_S2;
                let to_go = *goal_z_m - self.knot.value.z;
                // Largest rate from which deceleration `a` still stops at the goal, computed one tick ahead.
                let braking =
                    (2.0 * a * (to_go.abs() - self.knot.rate.z.abs() * dt_s).max(0.0)).sqrt();
                let wanted = to_go.signum() * braking.min(*speed_m_s).min(to_go.abs() / dt_s);
                let change = (wanted - self.knot.rate.z).clamp(-a * dt_s, a * dt_s);
                let rate = self.knot.rate.z + change;
                self.knot.rate.fill(0.0);
                self.knot.acceleration.fill(0.0);
                self.knot.rate.z = rate;
                self.knot.acceleration.z = change / dt_s;
                self.knot.value.z += self.knot.rate.z * dt_s;
            }
        }
    }

    /// The reference of this tick with free adaptation and no payload. Roll and pitch are zero; the command filter fills them.
    pub fn reference(&self, gripper: GripperCommand) -> Reference {
        let expand = |p: &Posture| Coords::from([p[0], p[1], p[2], 0.0, 0.0, p[3], p[4], p[5]]);
        Reference {
            chi_des: expand(&self.knot.value).into(),
            chi_des_dot: expand(&self.knot.rate).into(),
            chi_des_ddot: expand(&self.knot.acceleration),
            gripper,
            adaptation: Adaptation::Free,
            follows_measurement: false,
            transporting: false,
            cruising: false,
            release: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT_S: f64 = 0.01;

    #[test]
    fn a_ramp_respects_its_speed_and_stops_at_its_goal() {
        let mut motion = Motion::new(Posture::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.0));
        motion.ramp(0.94, 0.15);
        let mut lowest: f64 = 1.0;
        let mut fastest: f64 = 0.0;
        for _ in 0..200 {
            motion.step(DT_S);
            lowest = lowest.min(motion.posture().z);
            fastest = fastest.max(motion.reference(GripperCommand::Open).chi_des_dot[2].abs());
        }
        assert!(motion.arrived());
        assert!((motion.posture().z - 0.94).abs() < 1e-4, "{}", motion.posture().z);
        assert!(lowest > 0.94 - 2e-3 && fastest <= 0.15 + 1e-12, "{lowest} {fastest}");
    }

    #[test]
    fn a_paused_ramp_stands_still_and_goes_on() {
        let mut motion = Motion::new(Posture::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.0));
        motion.ramp(0.0, 0.06);
        (0..100).for_each(|_| motion.step(DT_S));
        motion.ramp(0.0, 0.0);
        (0..20).for_each(|_| motion.step(DT_S));
        let paused = motion.posture().z;
        (0..20).for_each(|_| motion.step(DT_S));
        assert!((motion.posture().z - paused).abs() < 1e-12 && paused < 0.95);
    }

    #[test]
    fn a_segment_started_in_motion_is_continuous() {
        let mut motion = Motion::new(Posture::zeros());
        motion.ramp(-1.0, 0.15);
        (0..50).for_each(|_| motion.step(DT_S));
        let (before, rate) =
            (motion.posture().z, motion.reference(GripperCommand::Open).chi_des_dot[2]);
        motion.go(Posture::new(0.0, 0.0, 0.5, 0.0, 0.0, 0.0), 1.5);
        motion.step(DT_S);
        assert!((motion.posture().z - before - rate * DT_S).abs() < 1e-3);
    }
}
