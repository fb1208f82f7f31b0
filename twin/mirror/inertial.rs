//! Acceleration from an accelerometer, its bias corrected slowly by the position: what the position alone gives is noise twice
//! differentiated.

use nalgebra::Vector3;

use super::grid::{Ticks, curvature, filtered};
use super::series::Series;
use crate::notation::{GRAVITY_M_S2, TICK_S, world_from_body};

/// How fast the bias follows the position, rad/s.
const BIAS_RATE_RAD_S: f64 = 0.5;

/// Acceleration of the base in the world per tick, m/s², before `H`. Unknown where attitude or accelerometer is.
///
/// `specific_force` is in the body, `eta` is `[phi theta psi]`, `position` in the world, m.
pub(super) fn acceleration(
    specific_force: &Series<3>,
    times_s: &[f64],
    eta: &Ticks<3>,
    position: &Ticks<3>,
) -> Ticks<3> {
    let from_position = filtered(&curvature(position), true);
    let blend = 1.0 - (-BIAS_RATE_RAD_S * TICK_S).exp();
    let mut bias = Vector3::zeros();
    (0..times_s.len())
        .map(|tick| {
            let body = specific_force.linear(times_s[tick])?;
            let gravity = Vector3::z() * GRAVITY_M_S2;
            let raw = world_from_body(eta[tick].as_ref()?) * body - gravity;
            if let Some(slow) = from_position[tick] {
                bias += (raw - slow - bias) * blend;
            }
            Some(raw - bias)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_bias_and_a_wrong_tilt_are_gone_after_some_seconds_and_the_motion_stays() {
        let (frequency, ticks) = (6.0_f64, 3000);
        let times: Vec<f64> = (0..ticks).map(|i| f64::from(i) * TICK_S).collect();
        let accelerate = |t: f64| 2.0 * (frequency * t).sin();
        let bias = Vector3::new(0.3, -0.2, 0.5);
        let eta: Ticks<3> = times.iter().map(|_| Some(Vector3::zeros())).collect();
        let position: Ticks<3> = times
            .iter()
            .map(|t| Some(Vector3::x() * (-accelerate(*t) / (frequency * frequency))))
            .collect();
        let specific = Series::new(
            times.iter().map(|t| (*t, Vector3::new(accelerate(*t), 0.0, GRAVITY_M_S2) + bias)),
        );
        let found = acceleration(&specific, &times, &eta, &position);
        for tick in 2000..ticks as usize - 1 {
            let error = found[tick].unwrap() - Vector3::x() * accelerate(times[tick]);
            // exp(-0.5 * 20 s) of the bias, and what `H` delays a motion of 6 rad/s by, seen through 0.5 rad/s.
            assert!(error.norm() < 0.06, "{tick} {error:?}");
        }
    }

    #[test]
    fn without_attitude_nothing_is_known() {
        let times = [0.0, 0.01, 0.02];
        let specific = Series::new(times.iter().map(|t| (*t, Vector3::z() * GRAVITY_M_S2)));
        let still: Ticks<3> = vec![Some(Vector3::zeros()); 3];
        assert_eq!(acceleration(&specific, &times, &vec![None; 3], &still), vec![None; 3]);
    }
}
