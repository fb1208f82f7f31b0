//! Interpolation against known functions, gaps, and unusable samples.

use super::*;
use nalgebra::{Vector1, Vector3};

fn series(times: impl Iterator<Item = f64>, f: impl Fn(f64) -> f64) -> Series<1> {
    Series::new(times.map(|t| (t, Vector1::new(f(t)))))
}

#[test]
fn cubic_interpolation_is_exact_for_parabolas_at_uneven_times() {
    let f = |t: f64| 2.0 - t + 3.0 * t * t;
    let times = (0..50).map(|i| f64::from(i) * 0.01 + 0.002 * f64::from(i % 3));
    let series = series(times, f);
    for i in 2..45 {
        let t = f64::from(i) * 0.01 + 0.0047;
        // The slopes are exact for parabolas inside the series, so only rounding remains.
        assert!((series.cubic(t).unwrap().x - f(t)).abs() < 1e-12, "{t}");
    }
}

#[test]
fn inside_a_gap_and_outside_the_series_nothing_is_known() {
    let times = (0..100).chain(1300..1400).map(|i| f64::from(i) * 0.01);
    let series = series(times, |t| t);
    let timing = series.timing();
    assert_eq!((timing.gaps, timing.samples), (1, 200));
    assert!((timing.longest_gap_s - 12.01).abs() < 1e-9);
    assert!((timing.rate_hz - 100.0).abs() < 1e-6);
    for t in [-0.01, 1.0, 5.0, 12.9, 14.0] {
        assert_eq!(series.linear(t), None, "{t}");
        assert_eq!(series.cubic(t), None, "{t}");
    }
    assert!((series.linear(0.555).unwrap().x - 0.555).abs() < 1e-12);
}

#[test]
fn samples_back_in_time_twice_at_one_time_or_not_finite_are_left_out_and_counted() {
    let samples = [(0.0, 1.0), (0.1, 2.0), (0.1, 9.0), (0.05, 9.0), (0.2, f64::NAN), (0.3, 3.0)];
    let series = Series::new(samples.iter().map(|(t, v)| (*t, Vector1::new(*v))));
    let timing = series.timing();
    assert_eq!(
        (timing.samples, timing.duplicate, timing.backwards, timing.not_finite),
        (3, 1, 1, 1)
    );
}

#[test]
fn attitude_turns_at_constant_rate_between_samples_whatever_their_sign() {
    let at = |t: f64| UnitQuaternion::new(Vector3::z() * t);
    let samples = (0..40).map(|i| {
        let q = at(f64::from(i) * 0.05);
        let flipped = UnitQuaternion::new_unchecked(-q.into_inner());
        (f64::from(i) * 0.05, if i % 2 == 0 { q } else { flipped })
    });
    let attitudes = Attitudes::new(samples);
    assert!(attitudes.sign_flips > 15);
    for i in 0..190 {
        let t = f64::from(i) * 0.01 + 0.003;
        assert!(attitudes.slerp(t).unwrap().angle_to(&at(t)) < 1e-9, "{t}");
    }
}

#[test]
fn samples_that_came_in_one_burst_are_one_sample_between_them() {
    // A source of 120 Hz behind a poll of 100 Hz: every fifth poll brings two samples at once.
    let arrival = |i: u32| f64::from(i * 10 / 12) * 0.01 + f64::from(i % 6) * 1e-5;
    let series = Series::new((0..600).map(|i| (arrival(i), Vector1::new(f64::from(i) / 120.0))));
    let timing = series.timing();
    assert_eq!((timing.samples, timing.merged), (500, 100));
    for tick in 10..480 {
        let t = f64::from(tick) * 0.01;
        let speed = (series.cubic(t + 0.01).unwrap().x - series.cubic(t).unwrap().x) / 0.01;
        // The true speed is 1. Between the arrival times of a burst, two samples would give a speed of 800.
        assert!((0.2..2.0).contains(&speed), "{t}: {speed}");
    }
}

#[test]
fn a_measurement_that_is_repeated_is_not_new_and_a_frozen_stream_is_a_gap() {
    let value = |i: i32| if (40..80).contains(&i) { 0.4 } else { f64::from(i / 2 * 2) * 0.01 };
    let samples = (0..120).map(|i| (f64::from(i) * 0.01, Vector1::new(value(i))));
    let series = Series::measured(samples);
    assert_eq!((series.timing().gaps, series.timing().samples), (1, 41));
    assert_eq!(series.linear(0.6), None);
    // Between two new samples the interpolation follows their line, not the logged step.
    assert!((series.linear(0.11).unwrap().x - 0.11).abs() < 1e-12);
}
