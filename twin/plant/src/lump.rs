//! Mass, centre of mass and tensor of links that move together, as Rapier takes them.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use rapier3d_f64::prelude::*;

use super::convert::{to_rotation, to_vector};
use crate::model::{Inertial, Robot};

/// Mass, centre of mass and inertia tensor of several links together, in the frame of their body.
pub(super) fn lumped_inertial(
    robot: &Robot,
    links: &[usize],
    places: &[(usize, Isometry3<f64>)],
) -> Inertial {
    let parts = links.iter().map(|&link| (&robot.links[link].inertial, places[link].1));
    let mass_kg: f64 = parts.clone().map(|(inertial, _)| inertial.mass_kg).sum();
    let moment = parts.clone().fold(Vector3::zeros(), |sum, (inertial, place)| {
        sum + (place * nalgebra::Point3::from(inertial.com_in_link)).coords * inertial.mass_kg
    });
    let com_in_link = if mass_kg > 0.0 { moment / mass_kg } else { Vector3::zeros() };
    let inertia_in_link = parts.fold(Matrix3::zeros(), |sum, (inertial, place)| {
        let r = place.rotation.to_rotation_matrix();
        let d = (place * nalgebra::Point3::from(inertial.com_in_link)).coords - com_in_link;
        let steiner =
            (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * inertial.mass_kg;
        sum + r.matrix() * inertial.inertia_in_link * r.matrix().transpose() + steiner
    });
    Inertial { mass_kg, com_in_link, inertia_in_link }
}

/// `inertial` as Rapier takes it: along the principal axes. Rapier's own way from a tensor to its axes calls the system's `acos` and
/// `cos`, which differ between platforms.
pub(super) fn mass_properties(inertial: &Inertial) -> MassProperties {
    let eigen = inertial.inertia_in_link.symmetric_eigen();
    let (mut moments, mut axes) = (eigen.eigenvalues, eigen.eigenvectors);
    if axes.determinant() < 0.0 {
        axes.swap_columns(1, 2);
        moments.swap_rows(1, 2);
    }
    let link_from_axes =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    MassProperties::with_principal_inertia_frame(
        to_vector(&inertial.com_in_link),
        inertial.mass_kg,
        to_vector(&moments.map(|moment| moment.max(0.0))),
        to_rotation(&link_from_axes),
    )
}
