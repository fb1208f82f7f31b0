//! Symbols, coordinate order, frames and units: read this before any formula.
//!
//! **Coordinates.** `chi = [x y z phi theta psi q1 q2]`. `x y z` in m in the world frame (ENU, z up);
//! `phi theta psi` are ZYX Euler angles in rad of the body frame (FLU: forward, left, up); `q1 q2` joint angles
//! in rad. `psi` is unwrapped in `chi` and in every history; errors in `psi` are wrapped.
//!
//! **Generalised force.** `tau = [F_x F_y F_z | tau_phi tau_theta tau_psi | tau_q1 tau_q2]` is dual to `chi`: world
//! force in N, `E(eta)^T` times the body moment in N m, joint torque in N m.
//!
//! **Known and unknown.** A value that a source does not provide is unknown: [`KnownCoords`] carries this per coordinate, from the
//! measurement to telemetry and files. An unknown value reads as NaN in code and as `null` in files, never as zero and never as the
//! last value.
//!
//! **Names.** A public field is a word with its unit (`payload_kg`); a local in a formula is the paper's letter.
//! Rotations and poses read right to left: `world_from_body * vector_in_body = vector_in_world`.
//!
//! Traps settled here, once:
//! - Features use `tau` of the previous tick, the label uses the `tau` in force while `chi_ddot` was measured:
//!   [`crate::tick::Measurement::tau_applied`] is that one field with that one meaning.
//! - `s / |s|` at `s = 0`: the boundary layer is a named setting ([`crate::control::Gains::boundary_layer`]).
//! - The innovation of the RLS step is a priori (it uses `W_{t-1}`).
//! - Reset and adapted forecast follow the order of Algorithm 1, lines 6 to 8.

mod known;

use crate::elementary::{asin, atan2, sin_cos};
use nalgebra::{Matrix3, SVector, Vector3};

pub use known::{KnownCoords, KnownMask, known_in_both};

/// Number of generalised coordinates, `n = 6 + n_arm`.
pub const N: usize = 8;

/// One value per generalised coordinate, `[x y z phi theta psi q1 q2]`; m and rad, or N and N m.
pub type Coords = SVector<f64, N>;

/// Names of the coordinates, in their order.
pub const COORDINATE_NAMES: [&str; N] = ["x", "y", "z", "phi", "theta", "psi", "q1", "q2"];

/// Standard gravity used by plant and models, m/s².
pub const GRAVITY_M_S2: f64 = 9.81;

/// Period of the outer loop (residual, adapter, control of x y z, task), s.
pub const TICK_S: f64 = 0.01;

/// Largest number of rotors a vehicle may have.
pub const MAX_ROTORS: usize = 8;

/// One value per rotor; the entries of rotors that the vehicle does not have are zero.
pub type PerRotor = [f64; MAX_ROTORS];

/// `world_from_body` for ZYX Euler angles `eta = [phi theta psi]`, rad.
pub fn world_from_body(eta: &Vector3<f64>) -> Matrix3<f64> {
    let (sp, cp) = sin_cos(eta.x);
    let (st, ct) = sin_cos(eta.y);
    let (sy, cy) = sin_cos(eta.z);
    Matrix3::new(
        cy * ct,
        cy * st * sp - sy * cp,
        cy * st * cp + sy * sp,
        sy * ct,
        sy * st * sp + cy * cp,
        sy * st * cp - cy * sp,
        -st,
        ct * sp,
        ct * cp,
    )
}

/// `E(eta)`: angular velocity in the body frame is `E * eta_dot`.
pub fn body_rate_from_euler_rate(eta: &Vector3<f64>) -> Matrix3<f64> {
    let (sp, cp) = sin_cos(eta.x);
    let (st, ct) = sin_cos(eta.y);
    Matrix3::new(1.0, 0.0, -st, 0.0, cp, ct * sp, 0.0, -sp, ct * cp)
}

/// `E(eta)^-1`: `eta_dot = E^-1 * omega_in_body`. `cos(theta)` is kept away from zero, so the result is finite;
/// `|theta| > 80°` is a [`crate::tick::Fault`] long before that matters.
pub fn euler_rate_from_body_rate(eta: &Vector3<f64>) -> Matrix3<f64> {
    let (sp, cp) = sin_cos(eta.x);
    let (st, ct) = sin_cos(eta.y);
    let ct = if ct.abs() < 1e-3 { 1e-3_f64.copysign(ct) } else { ct };
    let tt = st / ct;
    Matrix3::new(1.0, sp * tt, cp * tt, 0.0, cp, -sp, 0.0, sp / ct, cp / ct)
}

/// ZYX Euler angles of `world_from_body`, rad, `psi` in (-pi, pi].
pub fn euler_from_rotation(world_from_body: &Matrix3<f64>) -> Vector3<f64> {
    let r = world_from_body;
    Vector3::new(
        atan2(r[(2, 1)], r[(2, 2)]),
        asin((-r[(2, 0)]).clamp(-1.0, 1.0)),
        atan2(r[(1, 0)], r[(0, 0)]),
    )
}

/// The angle equivalent to `angle` in (-pi, pi].
pub fn wrap_angle(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let wrapped = angle.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// Tracking error `e = chi - chi_des` with the yaw wrapped.
pub fn tracking_error(chi: &Coords, chi_des: &Coords) -> Coords {
    let mut e = chi - chi_des;
    e[5] = wrap_angle(e[5]);
    e
}

/// Position `[x y z]` of a coordinate vector, m.
pub fn position(c: &Coords) -> Vector3<f64> {
    c.fixed_rows::<3>(0).into_owned()
}

/// Attitude `[phi theta psi]` of a coordinate vector, rad.
pub fn attitude(c: &Coords) -> Vector3<f64> {
    c.fixed_rows::<3>(3).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elementary::{cos, sin};
    use proptest::prelude::*;

    /// Both sides are a handful of f64 products; 1e-12 is a thousand roundings.
    const ROUNDING: f64 = 1e-12;

    proptest! {
        #[test]
        fn rotation_and_euler_angles_are_inverse(p in -1.5..1.5f64, t in -1.3..1.3f64, y in -3.1..3.1f64) {
            let eta = Vector3::new(p, t, y);
            let r = world_from_body(&eta);
            prop_assert!((r * r.transpose() - Matrix3::identity()).norm() < ROUNDING);
            prop_assert!((euler_from_rotation(&r) - eta).norm() < ROUNDING);
        }

        #[test]
        fn rotation_equals_nalgebras(p in -1.5..1.5f64, t in -1.3..1.3f64, y in -3.1..3.1f64) {
            let oracle = nalgebra::Rotation3::from_euler_angles(p, t, y);
            prop_assert!((world_from_body(&Vector3::new(p, t, y)) - oracle.matrix()).norm() < ROUNDING);
        }

        #[test]
        fn euler_rate_matrices_are_inverse(p in -1.5..1.5f64, t in -1.3..1.3f64) {
            let eta = Vector3::new(p, t, 0.3);
            let product = body_rate_from_euler_rate(&eta) * euler_rate_from_body_rate(&eta);
            prop_assert!((product - Matrix3::identity()).norm() < ROUNDING);
        }

        #[test]
        fn wrapped_angles_stay_in_range_and_keep_direction(a in -100.0..100.0f64) {
            let w = wrap_angle(a);
            prop_assert!(w > -std::f64::consts::PI - ROUNDING && w <= std::f64::consts::PI + ROUNDING);
            prop_assert!((sin(w) - sin(a)).abs() < 1e-9 && (cos(w) - cos(a)).abs() < 1e-9);
        }
    }
}
