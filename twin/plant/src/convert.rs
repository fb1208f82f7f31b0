//! Conversions between glam, which Rapier uses, and nalgebra. No other file has them.

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d_f64::prelude::{Pose, Rotation, Vector};

pub(super) fn to_vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(super) fn from_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(super) fn to_rotation(q: &UnitQuaternion<f64>) -> Rotation {
    Rotation::from_xyzw(q.i, q.j, q.k, q.w)
}

pub(super) fn from_rotation(q: Rotation) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(q.w, q.x, q.y, q.z))
}

pub(super) fn to_pose(iso: &Isometry3<f64>) -> Pose {
    Pose { translation: to_vector(&iso.translation.vector), rotation: to_rotation(&iso.rotation) }
}

pub(super) fn from_pose(pose: &Pose) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::from(from_vector(pose.translation)),
        from_rotation(pose.rotation),
    )
}

pub(super) fn rotation_matrix(q: Rotation) -> Matrix3<f64> {
    *from_rotation(q).to_rotation_matrix().matrix()
}

/// An isometry as the pose that a tick and the viewers use.
pub(super) fn view_pose(iso: &Isometry3<f64>) -> twin_core::tick::Pose {
    let q = iso.rotation;
    twin_core::tick::Pose {
        position: iso.translation.vector.into(),
        quaternion_wxyz: [q.w, q.i, q.j, q.k],
    }
}
