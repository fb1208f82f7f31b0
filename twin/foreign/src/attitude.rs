//! Attitudes out of the numbers of a message: measured, wanted, and that of a vehicle at rest.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::frames;
use super::gather::Track;
use super::series::Attitudes;
use super::topics::Quantity;
use twin_core::notation::{TICK_S, euler_from_rotation, wrap_angle};

/// The first second, in ticks, and how far a vehicle at rest turns in it.
const REST_SAMPLES: u32 = 100;
const REST_RANGE_RAD: f64 = 0.02;

/// `enu_from_flu` of a sample of `track`: a quaternion w x y z, or roll, pitch, yaw in rad.
pub(super) fn attitude_of(track: &Track, values: &[f64]) -> UnitQuaternion<f64> {
    let q = if let (false, [w, x, y, z]) = (track.quantity == Quantity::Euler, values) {
        let q = Quaternion::new(*w, *x, *y, *z);
        // A quaternion of zero is no attitude: it becomes NaN and is counted as not finite.
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

/// Roll, pitch and unwrapped yaw of attitudes in order of time, rad.
pub(super) fn unwrapped(
    attitudes: impl Iterator<Item = (f64, UnitQuaternion<f64>)>,
) -> impl Iterator<Item = (f64, Vector3<f64>)> {
    let mut last: Option<f64> = None;
    attitudes.map(move |(t_s, q)| {
        let mut eta = euler_from_rotation(q.to_rotation_matrix().matrix());
        if let Some(last) = last {
            eta.z = last + wrap_angle(eta.z - last);
        }
        // What is no number does not end the yaw.
        last = if eta.z.is_finite() { Some(eta.z) } else { last };
        (t_s, eta)
    })
}

/// Roll and pitch of the measured frame while the vehicle stands level and still in the first second; `None` if it moves.
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

/// The first three numbers.
pub(super) fn vector(values: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|row, _| values.get(row).copied().unwrap_or(f64::NAN))
}
