//! The safe set around nominal gravity in which the compensated residual and the commanded force stay.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::elementary::hypot;
use crate::notation::{Coords, GRAVITY_M_S2, N};

/// Limits on the terms that the control law adds to nominal gravity; `controller.limits` of a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SafeSet {
    /// Largest distance of `r_hat` from nominal gravity, N and N m.
    pub residual_clip: [f64; N],
    /// Largest distance of `r_hat` from its value at the first contact while adaptation is bounded, N and N m.
    pub residual_window: [f64; N],
    /// Largest horizontal force per mass, m/s².
    pub lateral_m_s2: f64,
    /// Largest desired roll and pitch, rad.
    pub tilt_rad: f64,
    /// Smallest vertical force as a share of the weight; it keeps the thrust axis defined.
    pub vertical_share: f64,
}

impl Default for SafeSet {
    /// Values for the 3 kg vehicle in `urdf/`: a 500 g payload adds 5 N, and 2 N m at an arm joint; a finger on the box pushes with 2 to 6
    /// N (grasping study); 6 m/s² correspond to about 31° of tilt.
    fn default() -> Self {
        Self {
            residual_clip: [8.0, 8.0, 8.0, 2.0, 2.0, 0.6, 2.0, 2.0],
            residual_window: [3.0, 3.0, 6.0, 0.4, 0.5, 0.2, 0.8, 0.8],
            lateral_m_s2: 6.0,
            tilt_rad: 1.0,
            vertical_share: 0.3,
        }
    }
}

impl SafeSet {
    /// `r_hat` within [`SafeSet::residual_clip`] of `nominal_gravity`, N and N m.
    pub fn clip_residual(&self, r_hat: &Coords, nominal_gravity: &Coords) -> Coords {
        around(r_hat, nominal_gravity, &self.residual_clip)
    }

    /// `r_hat` within [`SafeSet::residual_window`] of its value `at_touch`, N and N m.
    pub fn bound_residual(&self, r_hat: &Coords, at_touch: &Coords) -> Coords {
        around(r_hat, at_touch, &self.residual_window)
    }

    /// `force_in_world_n` with its horizontal part within [`SafeSet::lateral_m_s2`] and its vertical part above
    /// [`SafeSet::vertical_share`] of the weight, N.
    pub fn clip_force(&self, force_in_world_n: Vector3<f64>, weight_n: f64) -> Vector3<f64> {
        let force = force_in_world_n;
        let lateral_limit = self.lateral_m_s2 * weight_n / GRAVITY_M_S2;
        let lateral = hypot(force.x, force.y);
        let scale = if lateral > lateral_limit { lateral_limit / lateral } else { 1.0 };
        let vertical = force.z.max(self.vertical_share * weight_n);
        Vector3::new(force.x * scale, force.y * scale, vertical)
    }
}

fn around(value: &Coords, centre: &Coords, half_width: &[f64; N]) -> Coords {
    let half_width = Coords::from(*half_width);
    value.zip_zip_map(&(centre - half_width), &(centre + half_width), f64::clamp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipped_force_keeps_its_direction_and_points_up() {
        let safe_set = SafeSet::default();
        let f = safe_set.clip_force(Vector3::new(300.0, 400.0, -5.0), 30.0);
        assert!((f.y / f.x - 4.0 / 3.0).abs() < 1e-12);
        let limit = safe_set.lateral_m_s2 * 30.0 / GRAVITY_M_S2;
        assert!(hypot(f.x, f.y) <= limit + 1e-9 && f.z > 0.0);
    }

    #[test]
    fn each_row_of_a_residual_has_its_own_limit() {
        let safe_set = SafeSet::default();
        let gravity = Coords::from_fn(|row, _| row as f64);
        for far in [-1e3, 1e3] {
            let sign = Coords::repeat(f64::signum(far));
            let clipped = safe_set.clip_residual(&Coords::repeat(far), &gravity);
            let expected = sign.component_mul(&Coords::from(safe_set.residual_clip));
            assert_eq!(clipped, gravity + expected);
            let bounded = safe_set.bound_residual(&Coords::repeat(far), &gravity);
            let expected = sign.component_mul(&Coords::from(safe_set.residual_window));
            assert_eq!(bounded, gravity + expected);
        }
    }
}
