//! The adapter against batch least squares, and its rules.

use super::*;
use crate::elementary::powi;
use proptest::prelude::*;

/// RLS and the normal equations differ by rounding amplified by the conditioning of 4 random features.
const BATCH_TOLERANCE: f64 = 1e-6;

fn forecast(g: &[f64]) -> Forecast {
    Forecast { base: vec![Coords::zeros().into()], regime: g.to_vec(), attention: Vec::new() }
}

/// One step of 10 ms with the features `g` and a base forecast of zero.
fn step(
    adapter: &mut Adapter,
    g: &[f64],
    residual: &KnownCoords,
    frozen: bool,
    settings: &Settings,
) -> Adapted {
    adapter.step(&forecast(g), &History::new(1), residual, 0.01, frozen, settings)
}

#[test]
fn the_spectrum_of_a_known_covariance_is_known_and_ordered() {
    // Householder reflection H = I - 2 v v' / v'v of diag(5, 2, 0.5): eigenvalues stay.
    let v = DVector::from_column_slice(&[1.0, -2.0, 0.5]);
    let h = DMatrix::identity(3, 3) - &v * v.transpose() * (2.0 / v.norm_squared());
    let d = DMatrix::from_diagonal(&DVector::from_column_slice(&[0.5, 5.0, 2.0]));
    let mut adapter = Adapter::new(3, Coords::repeat(1.0), &Settings::default());
    adapter.covariance = &h * d * &h;
    let spectrum = adapter.spectrum();
    for (found, wanted) in spectrum.iter().zip([5.0, 2.0, 0.5]) {
        // A few roundings of numbers below 10.
        assert!((found - wanted).abs() < 1e-12, "{spectrum:?}");
    }
    adapter.covariance[(0, 0)] = f64::NAN;
    assert!(adapter.spectrum().len() <= 3, "ends for what is not a number too");
}

proptest! {
    #[test]
    fn weights_equal_batch_weighted_least_squares(
        data in proptest::collection::vec((proptest::array::uniform4(-1.0..1.0f64), -1.0..1.0f64), 30..60)
    ) {
        let settings = Settings { trace_cap_per_feature: f64::INFINITY, reset_threshold: 1e9, ..Settings::default() };
        let mut adapter = Adapter::new(4, Coords::repeat(1.0), &settings);
        let lambda: f64 = settings.forgetting;
        // Oracle: argmin sum lambda^(T-t) (y - w'g)^2 + lambda^T |w|^2 / sigma_0 by the normal equations.
        let total = i32::try_from(data.len()).unwrap();
        let mut a = DMatrix::identity(4, 4) * powi(lambda, total);
        let mut b = DVector::zeros(4);
        for (t, (g, y)) in data.iter().enumerate() {
            step(&mut adapter, g, &Coords::repeat(*y).into(), false, &settings);
            let g = DVector::from_column_slice(g);
            let weight = powi(lambda, total - 1 - i32::try_from(t).unwrap());
            a += &g * g.transpose() * weight;
            b += &g * (*y * weight);
        }
        let w = a.lu().solve(&b).unwrap();
        let error = (adapter.weights().column(0) - w).norm();
        prop_assert!(error < BATCH_TOLERANCE, "{error}");
    }

    #[test]
    fn trace_never_exceeds_its_cap_and_covariance_stays_symmetric(
        data in proptest::collection::vec(proptest::array::uniform4(-1.0..1.0f64), 200..400)
    ) {
        let settings = Settings::default();
        let mut adapter = Adapter::new(4, Coords::repeat(1.0), &settings);
        for g in &data {
            let adapted = step(&mut adapter, g, &Coords::repeat(0.1).into(), false, &settings);
            prop_assert!(adapted.covariance_trace <= settings.trace_cap_per_feature * 4.0 * (1.0 + 1e-12));
        }
        prop_assert_eq!(adapter.covariance().transpose(), adapter.covariance().clone());
    }
}

#[test]
fn a_step_of_the_residual_resets_once_per_refractory_time() {
    let settings = Settings { forgetting: 1.0, ..Settings::default() };
    let mut adapter = Adapter::new(1, Coords::repeat(1.0), &settings);
    for _ in 0..2000 {
        step(&mut adapter, &[1.0], &Coords::zeros().into(), false, &settings);
    }
    let resets: Vec<usize> = (0..100)
        .filter(|_| step(&mut adapter, &[1.0], &Coords::repeat(5.0).into(), false, &settings).reset)
        .collect();
    assert_eq!(resets.len(), 1, "a collapsed covariance reopens once: {resets:?}");
}

#[test]
fn a_constant_force_is_learned_by_the_bias_alone_and_a_jump_moves_it() {
    let settings = Settings { bias_s: 0.5, ..Settings::default() };
    let mut adapter = Adapter::new(1, Coords::repeat(2.0), &settings);
    let force = Coords::repeat(3.0);
    let mut before = 0.0;
    for _ in 0..50 {
        before = step(&mut adapter, &[0.0], &force.into(), false, &settings).r_hat[0];
    }
    // First order: 1 - exp(-t / 0.5 s) after 0.5 s.
    assert!((before - 3.0 * (1.0 - 1.0_f64 / std::f64::consts::E)).abs() < 1e-9, "{before}");
    adapter.move_to(&forecast(&[0.0]), &Coords::repeat(-5.0), &settings);
    let after = step(&mut adapter, &[0.0], &force.into(), true, &settings);
    assert!((*after.r_hat - Coords::repeat(-5.0)).norm() < 1e-12);
    assert!((after.bias - Coords::repeat(-5.0)).norm() < 1e-12, "the base forecast is zero");
}

#[test]
fn weights_that_nothing_asks_for_fade_with_the_leak() {
    let settings = Settings { weight_leak_per_s: 2.0, forgetting: 1.0, ..Settings::default() };
    let mut adapter = Adapter::new(1, Coords::repeat(1.0), &settings);
    step(&mut adapter, &[1.0], &Coords::repeat(1.0).into(), false, &settings);
    let before = adapter.weights()[0];
    for _ in 0..100 {
        // A feature of zero teaches nothing.
        step(&mut adapter, &[0.0], &Coords::zeros().into(), false, &settings);
    }
    // exp(-2 / s * 1 s)
    assert!((adapter.weights()[0] / before - exp(-2.0)).abs() < 1e-9);
}

#[test]
fn after_a_move_the_estimate_is_the_known_value() {
    let settings = Settings::default();
    let mut adapter = Adapter::new(2, Coords::repeat(2.0), &settings);
    step(&mut adapter, &[1.0, 0.5], &Coords::repeat(3.0).into(), false, &settings);
    adapter.move_to(&forecast(&[1.0, 0.5]), &Coords::repeat(-5.0), &settings);
    let after = step(&mut adapter, &[1.0, 0.5], &Coords::zeros().into(), true, &settings).r_hat;
    assert!((*after - Coords::repeat(-5.0)).norm() < 1e-12);
}

#[test]
fn a_row_whose_residual_is_unknown_teaches_nothing_and_is_not_estimated() {
    let settings = Settings::default();
    let mut adapter = Adapter::new(1, Coords::repeat(1.0), &settings);
    step(&mut adapter, &[1.0], &Coords::repeat(1.0).into(), false, &settings);
    let before = adapter.weights().clone();
    let mut known = [true; N];
    known[1] = false;
    let partly = KnownCoords::from(Coords::repeat(9.0)).only(known);
    let adapted = step(&mut adapter, &[1.0], &partly, false, &settings);
    for row in 0..N {
        assert_eq!(adapter.weights()[row].to_bits() == before[row].to_bits(), !known[row], "{row}");
    }
    assert_eq!((adapted.r_hat.known(), adapted.innovation.known()), (known, known));
    let before = (adapter.weights().clone(), adapter.covariance().clone());
    step(&mut adapter, &[1.0], &KnownCoords::unknown(), false, &settings);
    assert_eq!(before, (adapter.weights().clone(), adapter.covariance().clone()));
}

#[test]
fn frozen_or_non_finite_input_changes_nothing() {
    let settings = Settings::default();
    let mut adapter = Adapter::new(1, Coords::repeat(1.0), &settings);
    step(&mut adapter, &[1.0], &Coords::repeat(1.0).into(), false, &settings);
    let before = (adapter.weights().clone(), adapter.covariance().clone());
    step(&mut adapter, &[1.0], &Coords::repeat(9.0).into(), true, &settings);
    step(&mut adapter, &[f64::NAN], &Coords::repeat(9.0).into(), false, &settings);
    step(&mut adapter, &[1.0], &Coords::repeat(f64::INFINITY).into(), false, &settings);
    assert_eq!(before, (adapter.weights().clone(), adapter.covariance().clone()));
}

#[test]
fn the_spectrum_of_an_adapter_without_features_is_empty() {
    let adapter = Adapter::new(0, Coords::repeat(1.0), &Settings::default());
    assert!(adapter.spectrum().is_empty());
}

#[test]
fn the_horizon_is_corrected_only_for_a_predictor_with_a_regime_and_with_a_memory() {
    let history = {
        let mut history = History::new(4);
        history.push(Coords::zeros(), Coords::zeros(), Coords::zeros(), Coords::zeros());
        history
    };
    let corrected = |regime: &[f64], horizon_memory_s: f64| {
        let settings = Settings { horizon_memory_s, ..Settings::default() };
        let mut adapter = Adapter::new(regime.len(), Coords::repeat(1.0), &settings);
        let residual = Coords::repeat(1.0).into();
        !adapter
            .step(&forecast(regime), &history, &residual, 0.01, false, &settings)
            .horizon
            .is_empty()
    };
    assert!(corrected(&[1.0], 20.0));
    assert!(!corrected(&[1.0], 0.0));
    assert!(!corrected(&[], 20.0));
}
