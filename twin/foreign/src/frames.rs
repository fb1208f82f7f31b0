//! Converts NED and FRD to ENU and FLU. No other module does.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::topics::{Body, World};

/// The rotation `enu_from_world`.
fn enu_from(world: World) -> Matrix3<f64> {
    match world {
        World::Enu => Matrix3::identity(),
        World::Ned => Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0),
    }
}

/// The rotation `flu_from_body`, which is its own inverse.
fn flu_from(body: Body) -> Matrix3<f64> {
    match body {
        Body::Flu => Matrix3::identity(),
        Body::Frd => Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
    }
}

/// Converts a vector in the world frame to ENU, in its own unit (m, m/s …).
pub fn world_vector(vector: &Vector3<f64>, world: World) -> Vector3<f64> {
    enu_from(world) * vector
}

/// Converts a vector in the body frame to FLU, in its own unit (rad/s, N, N m …).
pub fn body_vector(vector: &Vector3<f64>, body: Body) -> Vector3<f64> {
    flu_from(body) * vector
}

/// The rotation `enu_from_flu`, from the world-from-body rotation in the given axes.
pub fn attitude(
    world_from_body: &UnitQuaternion<f64>,
    world: World,
    body: Body,
) -> UnitQuaternion<f64> {
    let rotation = |matrix| {
        UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(matrix))
    };
    rotation(enu_from(world)) * world_from_body * rotation(flu_from(body).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;
    use twin_core::notation::euler_from_rotation;

    /// Rounding error of a few products.
    const ROUNDING: f64 = 1e-12;

    fn euler(q: &UnitQuaternion<f64>) -> Vector3<f64> {
        euler_from_rotation(q.to_rotation_matrix().matrix())
    }

    #[test]
    fn a_vehicle_that_faces_north_has_a_yaw_of_90_degrees_east_of_which_is_zero() {
        let north = attitude(&UnitQuaternion::identity(), World::Ned, Body::Frd);
        assert!((euler(&north) - Vector3::new(0.0, 0.0, FRAC_PI_2)).norm() < ROUNDING);
        let east = UnitQuaternion::from_euler_angles(0.0, 0.0, FRAC_PI_2);
        assert!(euler(&attitude(&east, World::Ned, Body::Frd)).norm() < ROUNDING);
    }

    #[test]
    fn north_east_down_becomes_east_north_up_and_right_and_down_change_sign() {
        let v = Vector3::new(1.0, 2.0, 3.0);
        assert_eq!(world_vector(&v, World::Ned), Vector3::new(2.0, 1.0, -3.0));
        assert_eq!(body_vector(&v, Body::Frd), Vector3::new(1.0, -2.0, -3.0));
        assert_eq!(world_vector(&v, World::Enu), v);
        assert_eq!(body_vector(&v, Body::Flu), v);
    }

    proptest! {
        #[test]
        fn roll_keeps_its_sign_pitch_turns_and_yaw_is_counted_from_east(
            p in -1.5..1.5f64, t in -1.5..1.5f64, y in -1.5..1.5f64,
        ) {
            let ned = UnitQuaternion::from_euler_angles(p, t, y);
            let found = euler(&attitude(&ned, World::Ned, Body::Frd));
            prop_assert!((found - Vector3::new(p, -t, FRAC_PI_2 - y)).norm() < 1e-9);
        }

        #[test]
        fn a_vector_turned_before_and_after_conversion_is_the_same(
            p in -3.0..3.0f64, t in -1.5..1.5f64, y in -3.0..3.0f64, v in -9.0..9.0f64,
        ) {
            let ned = UnitQuaternion::from_euler_angles(p, t, y);
            let body = Vector3::new(v, 1.0, -2.0);
            let first = world_vector(&(ned * body), World::Ned);
            let then = attitude(&ned, World::Ned, Body::Frd) * body_vector(&body, Body::Frd);
            prop_assert!((first - then).norm() < 1e-9);
        }
    }
}
