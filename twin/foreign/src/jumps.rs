//! Jumps of a pose that no vehicle can fly: an estimator that set its state anew, or motion capture that lost and found its markers.
//!
//! In: positions and attitudes. Out: the times of the first samples after each jump. The vehicle did not move, so a jump is no force.

use nalgebra::Vector3;

use super::series::{Attitudes, Series};

/// Largest step of a position beyond that of its neighbours, m, and its growth with the squared time, m/s²: ten times gravity.
const STEP_M: f64 = 0.2;
const STEP_M_S2: f64 = 100.0;

/// Largest turn between two attitudes beyond that of their neighbours, rad.
const TURN_RAD: f64 = 0.3;

/// Longest time between two samples that are compared, s.
const LONGEST_S: f64 = 0.2;

/// Time within which two jumps are one, s: position and attitude of one reset come in two messages.
const SAME_JUMP_S: f64 = 0.05;

/// Largest number of jumps whose times a note lists.
const SHOWN_JUMPS: usize = 5;

/// Times of the first samples after a jump, s, by the size of each step; `excess` is how much a step of a duration may exceed the larger
/// of its neighbours.
fn jumps(steps: &[(f64, f64, f64)], excess: impl Fn(f64) -> f64) -> Vec<f64> {
    let size = |at: Option<usize>| at.and_then(|at| steps.get(at)).map(|step| step.2);
    // At an end of the recording, the one neighbour that exists decides.
    let smaller = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => a.min(b),
        (one, other) => one.or(other).unwrap_or(0.0),
    };
    let is_jump = |at: &usize| {
        let (_, dt_s, own) = steps[*at];
        let near = smaller(size(at.checked_sub(1)), size(Some(at + 1)));
        // A glitch of one sample steps twice, there and back; its neighbours but one are small.
        let calm = near.max(smaller(size(at.checked_sub(2)), size(Some(at + 2))));
        dt_s < LONGEST_S && own - calm > excess(dt_s)
    };
    (0..steps.len()).filter(is_jump).map(|at| steps[at].0).collect()
}

/// Times of the first samples after a jump of the position, s.
fn of_position(times_s: &[f64], values: &[Vector3<f64>]) -> Vec<f64> {
    let pairs = times_s.windows(2).zip(values.windows(2));
    let steps: Vec<(f64, f64, f64)> =
        pairs.map(|(t, v)| (t[1], t[1] - t[0], (v[1] - v[0]).norm())).collect();
    jumps(&steps, |dt_s| STEP_M + STEP_M_S2 * dt_s * dt_s)
}

/// Times of the first samples after a jump of the attitude, s.
fn of_attitude(samples: impl Iterator<Item = (f64, nalgebra::UnitQuaternion<f64>)>) -> Vec<f64> {
    let samples: Vec<_> = samples.collect();
    let step = |pair: &[(f64, nalgebra::UnitQuaternion<f64>)]| {
        (pair[1].0, pair[1].0 - pair[0].0, pair[0].1.angle_to(&pair[1].1))
    };
    let steps: Vec<(f64, f64, f64)> = samples.windows(2).map(step).collect();
    jumps(&steps, |_| TURN_RAD)
}

/// Times of the first samples after a jump of position or attitude, s, in ascending order.
pub(super) fn of_pose(position: Option<&Series<3>>, attitude: Option<&Attitudes>) -> Vec<f64> {
    let mut found = position.map_or_else(Vec::new, |p| of_position(p.times_s(), p.values()));
    found.extend(attitude.into_iter().flat_map(|a| of_attitude(a.samples())));
    found.sort_by(f64::total_cmp);
    found.dedup_by(|a, b| *a - *b < SAME_JUMP_S);
    found
}

/// A sentence about jumps at these times, s; `resets` is how often the estimator says that it set its state anew.
pub(super) fn note(found: &[f64], resets: Option<usize>) -> String {
    let shown: Vec<String> =
        found.iter().take(SHOWN_JUMPS).map(|t_s| format!("{t_s:.2} s")).collect();
    let resets = resets.map_or_else(String::new, |count| {
        format!("; the estimator says that it set its state anew {count} times")
    });
    format!(
        "the pose jumps {} times (at {}) without a motion: no force follows from a jump{resets}",
        found.len(),
        shown.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::elementary::sin;

    #[test]
    fn a_step_of_the_estimate_is_a_jump_and_a_fast_flight_is_none() {
        let times: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.01).collect();
        // 40 m/s with 60 m/s² is faster than any vehicle of this kind.
        let fast = |t: f64| Vector3::new(40.0 * t, 26.0 * sin(1.5 * t), 0.0);
        let flown: Vec<Vector3<f64>> = times.iter().map(|t| fast(*t)).collect();
        assert!(of_position(&times, &flown).is_empty());
        let reset = |t: f64| if t > 5.0 { Vector3::new(0.9, -0.7, 0.4) } else { Vector3::zeros() };
        let stepped: Vec<Vector3<f64>> = times.iter().map(|t| fast(*t) + reset(*t)).collect();
        let found = of_position(&times, &stepped);
        assert!(found.len() == 1 && (found[0] - 5.01).abs() < 0.005, "{found:?}");
    }

    #[test]
    fn a_yaw_that_the_estimator_sets_anew_is_a_jump_and_a_flip_is_none() {
        let yaw = |t: f64| if t > 5.0 { 0.7 } else { 0.0 };
        let turned =
            |yaw: f64, roll: f64| nalgebra::UnitQuaternion::from_euler_angles(roll, 0.0, yaw);
        let times = || (0..1000).map(|i| f64::from(i) * 0.01);
        assert_eq!(of_attitude(times().map(|t| (t, turned(yaw(t), 0.0)))).len(), 1);
        // A flip at 20 rad/s, which begins and ends within 0.1 s.
        let roll = |t: f64| (20.0 * (t - 5.0)).clamp(0.0, std::f64::consts::TAU);
        assert!(of_attitude(times().map(|t| (t, turned(0.0, roll(t))))).is_empty());
    }
}
