//! The correction of the horizon: against the solution of the normal equations, and what it does while nothing can be learned.

use super::*;
use crate::elementary::powi;
use crate::residual::HORIZON;
use crate::residual::waves::{push, residual};

/// Forgetting of a memory of 2 s, so that a test of a few hundred ticks forgets.
const FORGETTING: f64 = 0.995;

/// Sums of hundreds of numbers of order ten, times the condition of the normal equations, near 1e6.
const ROUNDING: f64 = 1e-7;

/// A forecast of the constant `value` over the whole horizon.
fn constant(value: f64) -> Forecast {
    let base = vec![Coords::repeat(value).into(); HORIZON + 1];
    Forecast { base, regime: vec![1.0], attention: Vec::new() }
}

fn adapter() -> HorizonAdapter {
    HorizonAdapter::new(Coords::repeat(2.0))
}

/// One step with the constant forecast of one newton.
fn step(
    adapter: &mut HorizonAdapter,
    history: &History,
    r: &KnownCoords,
    learning: bool,
) -> Vec<Coords> {
    adapter.step(&constant(1.0), &Coords::zeros(), history, r, FORGETTING, learning)
}

/// Flies `ticks` of the waves; returns the adapter, the history and the last correction.
fn flown(ticks: usize) -> (HorizonAdapter, History, Vec<Coords>) {
    let (mut adapter, mut history, mut said) = (adapter(), History::new(4), Vec::new());
    for tick in 0..ticks {
        push(&mut history, tick);
        said = step(&mut adapter, &history, &residual(tick).into(), true);
    }
    (adapter, history, said)
}

#[test]
fn on_trial_it_corrects_nothing() {
    let (adapter, _, said) = flown(TRIAL as usize);
    assert!(adapter.weights[0].norm() > 0.0);
    assert_eq!(said, vec![Coords::zeros(); KNOTS.len()]);
}

#[test]
fn it_learns_what_a_constant_forecast_leaves_over_at_every_knot() {
    // The waves have an amplitude of one and a period as long as the memory, so the prior keeps a third of it at the last knot.
    const LEFT: f64 = 0.33;
    const TICKS_FLOWN: usize = 3000;
    let (_, _, said) = flown(TICKS_FLOWN);
    for (knot, said) in KNOTS.into_iter().zip(said) {
        let wanted = residual(TICKS_FLOWN - 1 + knot) - Coords::repeat(1.0);
        let error = (said - wanted).amax();
        assert!(error < LEFT, "{error} at {knot}");
    }
}

#[test]
fn covariance_and_weights_are_those_of_least_squares_with_a_prior_that_stays() {
    const TICKS_FLOWN: usize = 400;
    let (mut adapter, mut history) = (adapter(), History::new(4));
    // Normal equations: information A and right side b of the first knot, which learns in the tick of its forecast.
    let mut a = DMatrix::identity(INPUTS, INPUTS) / PRIOR;
    let mut b: DMatrix<f64> = DMatrix::zeros(INPUTS, N);
    for tick in 0..TICKS_FLOWN {
        push(&mut history, tick);
        step(&mut adapter, &history, &residual(tick).into(), true);
        let made = adapter.made.front().unwrap();
        let target = residual(tick) / 2.0 - made.uncorrected[0];
        a = a * FORGETTING + &made.inputs * made.inputs.transpose();
        b = b * FORGETTING + &made.inputs * DMatrix::from_row_slice(1, N, target.as_slice());
        a[(tick % INPUTS, tick % INPUTS)] += (1.0 - FORGETTING) * INPUTS as f64 / PRIOR;
    }
    let inverse = a.try_inverse().unwrap();
    assert!((&adapter.covariance - &inverse).amax() < ROUNDING * PRIOR);
    assert!((&adapter.weights[0] - inverse * b).amax() < ROUNDING);
    assert_eq!(adapter.covariance, adapter.covariance.transpose());
}

#[test]
fn where_nothing_moves_the_covariance_stays_near_its_prior_and_the_weights_leak() {
    // An input waits for its turn, and is forgotten for as long.
    let longest = PRIOR * powi(FORGETTING, -i32::try_from(INPUTS).unwrap()) * 1.1;
    let (mut adapter, mut history, _) = flown(1000);
    let moved = adapter.weights[0].norm();
    let rest = Coords::repeat(1.0);
    for _ in 0..20_000 {
        history.push(Coords::zeros(), Coords::zeros(), rest, rest);
        step(&mut adapter, &history, &rest.into(), true);
    }
    assert!(adapter.covariance.diagonal().max() < longest);
    assert!(adapter.weights[0].norm() < 0.01 * moved);
}

#[test]
fn while_adaptation_is_held_it_says_the_same_learns_nothing_and_drops_what_waits() {
    let (mut adapter, mut history, _) = flown(500);
    let weights = adapter.weights.clone();
    push(&mut history, 500);
    let mut other = adapter.clone();
    let held = step(&mut adapter, &history, &Coords::repeat(90.0).into(), false);
    assert_eq!(held, step(&mut other, &history, &residual(500).into(), true));
    assert_eq!(adapter.weights, weights);
    assert!(adapter.made.is_empty());
}

#[test]
fn a_coordinate_whose_residual_is_unknown_is_not_learned() {
    let (mut adapter, mut history, _) = flown(500);
    let column = |adapter: &HorizonAdapter| adapter.weights[0].column(2).into_owned();
    let mut known = residual(500);
    known[2] = f64::NAN;
    push(&mut history, 500);
    let mut rows = [true; N];
    rows[2] = false;
    let (before, turn) = (column(&adapter), adapter.turn);
    step(&mut adapter, &history, &KnownCoords::from(known).only(rows), true);
    // Only the leak of the input in turn moves it.
    let after = column(&adapter);
    let step = adapter.covariance.column(turn) * (before[turn] - after[turn]);
    assert!((before - &after - step / adapter.covariance[(turn, turn)]).amax() < ROUNDING);
    assert!(after.iter().all(|weight| weight.is_finite()));
}

#[test]
fn a_number_that_is_not_finite_is_not_answered_and_not_learned() {
    let (mut adapter, mut history, _) = flown(500);
    let weights = adapter.weights.clone();
    history.push(Coords::repeat(f64::NAN), Coords::repeat(f64::NAN), residual(0), residual(0));
    assert!(step(&mut adapter, &history, &residual(500).into(), true).is_empty());
    assert_eq!(adapter.weights, weights);
    for tick in 500..510 {
        push(&mut history, tick);
        let said = step(&mut adapter, &history, &residual(tick).into(), true);
        assert_eq!(said.len(), if tick < 504 { said.len() } else { KNOTS.len() });
    }
}

#[test]
fn a_correction_is_used_in_the_share_that_would_have_been_best() {
    // What is left of the doubt and of the start after ten memories of 2 s.
    const LEFT: f64 = 0.01;
    const DOUBT: f64 = 0.01;
    let learned = |error: f64, correction: f64| {
        let mut share = Share::new(DOUBT);
        for _ in 0..2000 {
            share.learn(&Coords::repeat(error), &Coords::repeat(correction));
        }
        share.share()[0]
    };
    assert!((learned(0.5, 1.0) - 0.5).abs() < LEFT, "half of it would have been right");
    assert!((learned(2.0, 1.0) - 1.0).abs() < LEFT, "never more than all of it");
    assert!(learned(-1.0, 1.0).abs() < LEFT, "it made the forecast worse");
    assert!(learned(1e-3, 1e-3).abs() < 3.0 * LEFT, "too small to be judged");
    assert!(Share::new(DOUBT).share().amax() < LEFT, "nothing is known yet");
}

#[test]
fn between_the_knots_the_correction_is_a_line() {
    let corrections: Vec<Coords> = KNOTS.iter().map(|j| Coords::repeat(*j as f64)).collect();
    for j in 0..=HORIZON {
        assert!((at_step(&corrections, j) - Coords::repeat(j as f64)).amax() < 1e-12);
    }
    assert_eq!(at_step(&[], 3), Coords::zeros());
}
