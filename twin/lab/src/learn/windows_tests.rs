//! The content of windows, compared with the series that they were cut from.

use super::config::TrainConfig;
use super::made::{dataset, tiny};
use super::windows::{WindowEnd, Windows, generator};
use twin_core::elementary::squared;

/// Rounding of one z-score.
const ROUNDING: f32 = 1e-5;

#[test]
fn a_window_holds_its_history_oldest_first_and_the_residual_from_its_newest_tick_on() {
    let (data, config) = (dataset(2, 300), tiny());
    let windows = Windows::new(&data, &config).unwrap();
    let batch = windows.batch(&[WindowEnd { flight: 1, tick: 50 }], None);
    let (flight, z) = (&data.flights[1], &windows.normalisation);
    for channel in 1..4 {
        for t in 0..config.t_long {
            let value = flight.inputs[channel][50 + 1 - config.t_long + t];
            let wanted = (value - z.input_mean[channel]) / z.input_std[channel];
            assert!((batch.x[channel * config.t_long + t] - wanted).abs() < ROUNDING);
        }
    }
    for ahead in 0..=config.horizon {
        let wanted = (flight.outputs[1][50 + ahead] - z.output_mean[1]) / z.output_std[1];
        assert!((batch.y[ahead * 2 + 1] - wanted).abs() < ROUNDING);
    }
    assert!(batch.x[..config.t_long].iter().all(|v| *v == 0.0), "chi.x is masked");
}

#[test]
fn before_the_first_tick_the_oldest_value_is_held_as_in_flight() {
    let windows = Windows::new(&dataset(1, 300), &tiny()).unwrap();
    let row = |tick| windows.batch(&[WindowEnd { flight: 0, tick }], None).x[20..40].to_vec();
    let (early, first) = (row(3), row(19)[0]);
    assert!(early[..17].iter().all(|v| (*v - first).abs() < f32::EPSILON), "{early:?}");
    assert!((early[17] - early[16]).abs() > f32::EPSILON);
}

#[test]
fn training_and_validation_never_share_a_tick_of_history_or_forecast() {
    let (mut data, config) = (dataset(2, 400), tiny());
    data.flights[0].usable[100..110].fill(false);
    let windows = Windows::new(&data, &config).unwrap();
    let split = 320;
    let stride_one = windows.epoch(1, 0, 1);
    assert_eq!(stride_one.len(), windows.training_windows());
    assert!(stride_one.iter().all(|place| place.tick + config.horizon < split));
    assert!(windows.validation().iter().all(|place| place.tick >= split + config.t_long));
    // A window that ends at tick 98 or later has tick 98 + 2 = 100, which is not usable, in its horizon.
    let of_first = stride_one.iter().filter(|place| place.flight == 0);
    assert!(of_first.clone().all(|place| !(98..110).contains(&place.tick)));
    assert!(
        of_first.clone().any(|place| place.tick == 97) && of_first.clone().any(|p| p.tick == 110)
    );
}

#[test]
fn an_epoch_is_a_function_of_seed_and_number_and_every_offset_comes_up() {
    let windows = Windows::new(&dataset(1, 400), &tiny()).unwrap();
    assert_eq!(windows.epoch(5, 3, 4), windows.epoch(5, 3, 4));
    assert_ne!(windows.epoch(5, 3, 4), windows.epoch(6, 3, 4));
    let offsets: std::collections::BTreeSet<usize> =
        (0..40).map(|epoch| windows.epoch(5, epoch, 4)[0].tick % 4).collect();
    assert_eq!(offsets.len(), 4);
}

#[test]
fn noise_falls_on_the_applied_forces_alone_with_its_deviation() {
    let config = TrainConfig { tau_noise: 0.3, ..tiny() };
    let windows = Windows::new(&dataset(1, 2000), &config).unwrap();
    let places = windows.epoch(1, 0, 4);
    let quiet = windows.batch(&places, None).x;
    let noisy = windows.batch(&places, Some(&mut generator(1, 0, 2))).x;
    let (mut squares, mut count) = (0.0, 0.0);
    for (index, (a, b)) in quiet.iter().zip(&noisy).enumerate() {
        let channel = index / config.t_long % 4;
        if channel < 2 {
            assert_eq!(a.to_bits(), b.to_bits());
        } else {
            squares += squared(f64::from(b - a));
            count += 1.0;
        }
    }
    // Some 16,000 draws give the deviation with a standard error of 0.3 / sqrt(2 n); the bound is ten times that.
    assert!(((squares / count).sqrt() - 0.3).abs() < 0.02, "{}", (squares / count).sqrt());
}

#[test]
fn flights_that_are_too_short_say_how_long_they_must_be() {
    let error = Windows::new(&dataset(1, 60), &tiny()).unwrap_err().to_string();
    assert!(error.contains("0 for validation") && error.contains("longer than 1.1 s"), "{error}");
}
