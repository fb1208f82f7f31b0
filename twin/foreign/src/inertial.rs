//! Acceleration from an accelerometer whose bias the position corrects slowly. The second derivative of the position alone would
//! be mostly noise.

use nalgebra::Vector3;

use super::grid::{Ticks, curvature, filtered};
use super::series::Series;
use twin_core::elementary::exp;
use twin_core::notation::{GRAVITY_M_S2, TICK_S, world_from_body};

/// Rate at which the bias follows the position, 1/s.
const BIAS_RATE_RAD_S: f64 = 0.5;

/// Ticks over which the first bias of a part of a flight is averaged: 2 s.
const START_TICKS: usize = 200;

/// Acceleration of the base in the world frame per tick, m/s², before the filter `H`. It is unknown where attitude or
/// accelerometer is.
///
/// `specific_force` is in the body frame, m/s²; `eta` is `[phi theta psi]`, rad; `position` is in the world frame, m. The bias
/// starts at zero. With `parts` it restarts after every unknown tick, at its mean over the next 2 s.
pub(super) fn acceleration(
    specific_force: &Series<3>,
    times_s: &[f64],
    eta: &Ticks<3>,
    position: &Ticks<3>,
    parts: bool,
) -> Ticks<3> {
    let from_position = filtered(&curvature(position), true);
    let blend = 1.0 - exp(-BIAS_RATE_RAD_S * TICK_S);
    let raw: Ticks<3> = (0..times_s.len())
        .map(|tick| {
            let body = specific_force.linear(times_s[tick])?;
            let gravity = Vector3::z() * GRAVITY_M_S2;
            Some(world_from_body(eta[tick].as_ref()?) * body - gravity)
        })
        .collect();
    let mut bias: Option<Vector3<f64>> = (!parts).then(Vector3::zeros);
    (0..times_s.len())
        .map(|tick| {
            let Some(here) = raw[tick] else {
                bias = bias.filter(|_| !parts);
                return None;
            };
            let bias = bias.get_or_insert_with(|| mean_bias(&raw[tick..], &from_position[tick..]));
            if let Some(slow) = from_position[tick] {
                *bias += (here - slow - *bias) * blend;
            }
            Some(here - *bias)
        })
        .collect()
}

/// Mean difference between accelerometer and position over the first 2 s of a run of known ticks, m/s².
fn mean_bias(raw: &[Option<Vector3<f64>>], from_position: &[Option<Vector3<f64>>]) -> Vector3<f64> {
    let run = raw.iter().zip(from_position).take(START_TICKS).take_while(|(raw, _)| raw.is_some());
    let (sum, n) = run
        .filter_map(|(raw, slow)| Some((*raw)? - (*slow)?))
        .fold((Vector3::zeros(), 0.0), |(sum, n), bias| (sum + bias, n + 1.0));
    sum / f64::max(n, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::elementary::sin;

    #[test]
    fn a_constant_bias_and_a_wrong_tilt_are_gone_after_some_seconds_and_the_motion_stays() {
        let (frequency, ticks) = (6.0_f64, 3000);
        let times: Vec<f64> = (0..ticks).map(|i| f64::from(i) * TICK_S).collect();
        let accelerate = |t: f64| 2.0 * sin(frequency * t);
        let bias = Vector3::new(0.3, -0.2, 0.5);
        let eta: Ticks<3> = times.iter().map(|_| Some(Vector3::zeros())).collect();
        let position: Ticks<3> = times
            .iter()
            .map(|t| Some(Vector3::x() * (-accelerate(*t) / (frequency * frequency))))
            .collect();
        let specific = Series::new(
            times.iter().map(|t| (*t, Vector3::new(accelerate(*t), 0.0, GRAVITY_M_S2) + bias)),
        );
        let found = acceleration(&specific, &times, &eta, &position, false);
        for tick in 2000..ticks as usize - 1 {
            let error = found[tick].unwrap() - Vector3::x() * accelerate(times[tick]);
            // The bias decays by exp(-0.5 * 20 s). The delay of `H` for a motion at 6 rad/s remains, seen through 0.5 rad/s.
            assert!(error.norm() < 0.06, "{tick} {error:?}");
        }
    }

    #[test]
    fn a_part_of_a_flight_starts_with_the_bias_that_it_has() {
        let times: Vec<f64> = (0..300).map(|i| f64::from(i) * TICK_S).collect();
        let bias = Vector3::new(0.3, -0.2, 0.5);
        let still: Ticks<3> = vec![Some(Vector3::zeros()); 300];
        let specific = Series::new(times.iter().map(|t| (*t, Vector3::z() * GRAVITY_M_S2 + bias)));
        let found = acceleration(&specific, &times, &still, &still, true);
        let whole = acceleration(&specific, &times, &still, &still, false);
        // At rest the position says zero exactly, so the first tick is already right. A whole flight needs seconds to get there.
        assert!(found[0].unwrap().norm() < 1e-12, "{:?}", found[0]);
        assert!(whole[100].unwrap().norm() > 0.3 * bias.norm(), "{:?}", whole[100]);
    }

    #[test]
    fn without_attitude_nothing_is_known() {
        let times = [0.0, 0.01, 0.02];
        let specific = Series::new(times.iter().map(|t| (*t, Vector3::z() * GRAVITY_M_S2)));
        let still: Ticks<3> = vec![Some(Vector3::zeros()); 3];
        assert_eq!(acceleration(&specific, &times, &vec![None; 3], &still, false), vec![None; 3]);
    }
}
