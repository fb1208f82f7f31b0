//! Attitudes from the numbers of a message: the measured one, the commanded one, and the tilt of a vehicle at rest.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::frames;
use super::gather::Track;
use super::series::Attitudes;
use super::topics::Quantity;
use twin_core::notation::{TICK_S, euler_from_rotation, wrap_angle};

/// Length of the first second in ticks, and the largest angle in rad by which a vehicle at rest turns during it.
const REST_SAMPLES: u32 = 100;
const REST_RANGE_RAD: f64 = 0.02;

/// Rotation `enu_from_flu` of a sample of `track`, whose values are a quaternion w x y z, or roll, pitch, yaw in rad.
pub(super) fn attitude_of(track: &Track, values: &[f64]) -> UnitQuaternion<f64> {
    let q = if let (false, [w, x, y, z]) = (track.quantity == Quantity::Euler, values) {
        let q = Quaternion::new(*w, *x, *y, *z);
        // A zero quaternion describes no attitude. It becomes NaN, and the series counts it as not finite.
        if (q.norm() - 1.0).abs() < 0.1 {
            UnitQuaternion::new_normalize(q)
        } else {
            UnitQuaternion::new_unchecked(q * f64::NAN)
        }
    } else {
        let v = vector(values);
        UnitQuaternion::from_euler_angles(v.x, v.y, v.z)
    };
    frames::attitude(&q, track.rule.world, track.rule.body)
}

/// Roll, pitch and unwrapped yaw of each attitude, rad; the attitudes are in order of time.
pub(super) fn unwrapped(
    attitudes: impl Iterator<Item = (f64, UnitQuaternion<f64>)>,
) -> impl Iterator<Item = (f64, Vector3<f64>)> {
    let mut last: Option<f64> = None;
    attitudes.map(move |(t_s, q)| {
        let mut eta = euler_from_rotation(q.to_rotation_matrix().matrix());
        if let Some(last) = last {
            eta.z = last + wrap_angle(eta.z - last);
        }
        // A NaN does not interrupt the unwrapping of yaw.
        last = if eta.z.is_finite() { Some(eta.z) } else { last };
        (t_s, eta)
    })
}

/// Roll and pitch of the measured frame during the first second, if the vehicle stands still and level then; `None` if it moves.
pub(super) fn tilt_at_rest(attitudes: &Attitudes) -> Option<UnitQuaternion<f64>> {
    let start_s = attitudes.span()?.0;
    let at: Vec<UnitQuaternion<f64>> = (0..REST_SAMPLES)
        .filter_map(|i| attitudes.slerp(start_s + f64::from(i) * TICK_S))
        .collect();
    let first = at.first()?;
    let still = at.iter().all(|q| q.angle_to(first) < REST_RANGE_RAD);
    (still && at.len() * 2 > REST_SAMPLES as usize).then(|| {
        let mean = at.iter().fold(nalgebra::Vector4::zeros(), |sum, q| sum + q.into_inner().coords);
        let mean = UnitQuaternion::from_quaternion(Quaternion::from(mean));
        let (roll, pitch, _) = mean.euler_angles();
        UnitQuaternion::from_euler_angles(roll, pitch, 0.0)
    })
}

/// The first three values as a vector.
pub(super) fn vector(values: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|row, _| values.get(row).copied().unwrap_or(f64::NAN))
}

/// The first value.
pub(super) fn first(values: &[f64]) -> f64 {
    values.first().copied().unwrap_or(f64::NAN)
}
