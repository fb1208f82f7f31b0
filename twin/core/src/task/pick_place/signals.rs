//! Filtered signals of the supervisor, all from measurements: tip position, tip velocity, residual and cube position.

use nalgebra::{Vector2, Vector3};

use crate::filter::LowPass;
use crate::notation::{Coords, attitude, body_rate_from_euler_rate, position, world_from_body};
use crate::task::{ToolKinematics, View};

/// Corners of first-order filters with time constants of 50 ms, 100 ms and 1 s, Hz.
const TIP_HZ: f64 = 3.2;
const TIP_VELOCITY_HZ: f64 = 1.6;
const SLOW_HZ: f64 = 0.16;

/// Time over which the supervisor extrapolates the tip's velocity, s: the fingers need 0.12 s and the plunge about as long.
const LOOK_AHEAD_S: f64 = 0.2;

/// The supervisor's view of hand and cube.
#[derive(Clone, Debug, Default)]
pub(super) struct Signals {
    tip_filter: LowPass<3>,
    velocity_filter: LowPass<3>,
    cube_filter: LowPass<3>,
    residual_filter: LowPass<8>,
    /// Tip in the world, m.
    pub(super) tip: Vector3<f64>,
    /// Tip velocity in the world, m/s.
    pub(super) velocity: Vector3<f64>,
    /// Cube centre by motion capture, m; the last one seen while the cameras do not see the cube.
    pub(super) cube: Option<Vector3<f64>>,
    /// Measured residual.
    pub(super) r: Coords,
    /// Mean of the measured residual over 1 s.
    pub(super) r_slow: Coords,
}

impl Signals {
    pub(super) fn update(&mut self, view: &View<'_>, arm: &dyn ToolKinematics, dt_s: f64) {
        let m = view.measurement;
        let q = Vector2::new(m.chi[6], m.chi[7]);
        let q_dot = Vector2::new(m.chi_dot[6], m.chi_dot[7]);
        let eta = attitude(&m.chi);
        let r = world_from_body(&eta);
        let omega = body_rate_from_euler_rate(&eta) * attitude(&m.chi_dot);
        let tool = arm.tool_in_body(&q).translation.vector;
        let tip = position(&m.chi) + r * tool;
        let velocity =
            position(&m.chi_dot) + r * (omega.cross(&tool) + arm.tool_velocity_in_body(&q, &q_dot));
        self.tip = self.tip_filter.step(&tip, TIP_HZ, dt_s);
        self.velocity = self.velocity_filter.step(&velocity, TIP_VELOCITY_HZ, dt_s);
        if let Some(payload) = &m.payload {
            self.cube = Some(self.cube_filter.step(&payload.position_in_world, TIP_HZ, dt_s));
        }
        // The last known residual stands for an unknown one.
        self.r = view.residual.or(&self.r);
        self.r_slow = self.residual_filter.step(&self.r, SLOW_HZ, dt_s);
    }

    /// Tip error against `target` now and [`LOOK_AHEAD_S`] later, m.
    pub(super) fn errors(&self, target: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let e = self.tip - target;
        (e, e + self.velocity * LOOK_AHEAD_S)
    }

    pub(super) fn speed(&self) -> f64 {
        self.velocity.norm()
    }
}
