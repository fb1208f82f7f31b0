//! An axis in closed loop with a known gain. Disturbances and the noise of the log hide the gain from ordinary least squares.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::grid::{Ticks, filtered_times, slope};
use crate::series::Series;
use twin_core::elementary::sin;

const GAIN: f64 = 200.0;
const LAG_S: f64 = 0.03;
const SECONDS: usize = 60;

/// Gain of the rate loop, per rad/s, and of the attitude loop, 1/s.
const RATE_GAIN: f64 = 0.05;
const ATTITUDE_GAIN: f64 = 5.0;

/// Constant angular acceleration without torque, rad/s².
const TRIM: f64 = -3.0;

/// How an axis flies and is logged.
#[derive(Clone, Copy)]
struct Axis {
    /// Size of the set-point's steps, rad; they occur about every 2 s, unsynchronised with the log.
    step_rad: f64,
    /// Factor on the logged torque.
    sign: f64,
    /// First and last time at which the axis touches something and does not turn, s.
    stuck_s: (f64, f64),
}

const FREE: Axis = Axis { step_rad: 0.15, sign: 1.0, stuck_s: (0.0, 0.0) };

/// Set-point, logged torque and rate per ms. All axes use the same random numbers.
fn flown(axis: Axis) -> Vec<[f64; 3]> {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut noise = move |size: f64| size * random.random_range(-1.0..1.0_f64);
    let (mut angle, mut rate, mut gust) = (0.0, 0.0, 0.0);
    let mut sent: Vec<f64> = Vec::new();
    let mut wanted = 0.0;
    (0..SECONDS * 1000)
        .map(|ms| {
            let t_s = ms as f64 * 1e-3;
            if ms % 1987 == 0 {
                wanted = noise(axis.step_rad);
            }
            // Gusts below about 2 Hz, some 2 rad/s²: as fast as the loop itself.
            gust += -gust * 0.012 + noise(0.5);
            let gyroscope = rate + noise(0.02);
            let stuck = t_s > axis.stuck_s.0 && t_s < axis.stuck_s.1;
            // The torque pushes and pulls against the obstacle.
            let struggle = if stuck { 0.3 * sin(6.0 * t_s) } else { 0.0 };
            let torque = RATE_GAIN * (ATTITUDE_GAIN * (wanted - angle) - gyroscope) + struggle;
            sent.push(torque);
            let acts = sent[ms.saturating_sub((LAG_S * 1e3) as usize)];
            rate += (GAIN * acts + TRIM + gust) * 1e-3;
            if stuck {
                rate = 0.0;
            }
            angle += rate * 1e-3;
            // The log samples a faster loop at 50 Hz, so the changes between two samples alias.
            [wanted, axis.sign * (torque + noise(0.012)), rate + noise(0.02)]
        })
        .collect()
}

/// Fits and blocks of three axes.
fn fitted(axes: [Axis; 3]) -> ([TorqueAxis; 3], [Vec<Block>; 3]) {
    let flown = axes.map(flown);
    let logged = |of: usize, every_ms: usize| {
        Series::new(
            (0..SECONDS * 1000)
                .step_by(every_ms)
                .map(|ms| (ms as f64 * 1e-3, Vector3::from_fn(|axis, _| flown[axis][ms][of]))),
        )
    };
    let (setpoint, torque, rate) = (logged(0, 50), logged(1, 20), logged(2, 8));
    let times_s: Vec<f64> = (0..SECONDS * 100).map(|tick| tick as f64 * TICK_S).collect();
    let turning: Ticks<3> = times_s.iter().map(|t_s| rate.cubic(*t_s)).collect();
    let known = Known {
        times_s: &times_s,
        torque: &torque,
        setpoint: &setpoint,
        acceleration: &filtered_times(&slope(&turning), 1),
        passes: 1,
        airborne: &vec![true; times_s.len()],
    };
    (fit(&known), blocks(&known))
}

fn gain(axis: &TorqueAxis) -> TorqueFit {
    match axis {
        TorqueAxis::Fitted(fit) => *fit,
        TorqueAxis::Unknown { why } => panic!("{why}"),
    }
}

fn why(axis: &TorqueAxis) -> &str {
    match axis {
        TorqueAxis::Fitted(fit) => panic!("{fit:?}"),
        TorqueAxis::Unknown { why } => why,
    }
}

#[test]
fn a_known_gain_in_closed_loop_is_found_within_its_uncertainty_where_least_squares_finds_another() {
    let stuck = Axis { stuck_s: (40.5, 43.0), ..FREE };
    let (axes, blocks) = fitted([FREE, stuck, FREE]);
    for (axis, left_out) in [(0, 0), (1, 1)] {
        let fit = gain(&axes[axis]);
        // Three standard errors; one flight in four hundred is farther off.
        assert!((fit.gain - GAIN).abs() < 3.0 * fit.standard_error, "{fit:?}");
        assert!(fit.standard_error < 0.1 * fit.gain, "{fit:?}");
        // Ticks resolve one tick of delay, and the hold of 1 ms adds half a step.
        assert!((fit.lag_s - LAG_S).abs() < 1.01 * TICK_S, "{fit:?}");
        assert!(fit.blocks_left_out >= left_out, "{fit:?}");
    }
    let fit = gain(&axes[0]);
    // The mean of the gusts over a minute is about 0.3 rad/s².
    assert!((fit.trim - TRIM).abs() < 0.6, "{fit:?}");
    let lag = (fit.lag_s / TICK_S).round() as usize;
    let sums = blocks[0].iter().map(|block| block.lags[lag]);
    let (uy, uu) = sums.fold((0.0, 0.0), |(uy, uu), sum| (uy + sum.uy, uu + sum.uu));
    assert!(uy / uu < 0.8 * GAIN, "{} {fit:?}", uy / uu);
}

#[test]
fn a_hover_without_excitation_and_a_wrong_sign_are_refused_with_the_reason() {
    let still = Axis { step_rad: 0.0, ..FREE };
    let restless = Axis { step_rad: 0.002, ..FREE };
    let reversed = Axis { sign: -1.0, ..FREE };
    let (axes, _) = fitted([still, restless, reversed]);
    assert!(why(&axes[0]).contains("does not move"), "{}", why(&axes[0]));
    assert!(why(&axes[1]).contains("too little excitation"), "{}", why(&axes[1]));
    assert!(why(&axes[2]).contains("sign"), "{}", why(&axes[2]));
}

#[test]
fn a_short_flight_is_refused() {
    let (axes, mut blocks) = fitted([FREE; 3]);
    gain(&axes[0]);
    blocks[0].truncate(FEWEST_BLOCKS - 1);
    let why = judge(&blocks[0]).unwrap_err();
    assert!(why.contains("9 blocks"), "{why}");
}
