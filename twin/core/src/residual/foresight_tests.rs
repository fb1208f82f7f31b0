//! Residuals with a known future: a ramp, and white noise of known deviation.

use rand::SeedableRng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::*;
use crate::normal::StandardNormal;
use crate::notation::TICK_S;
use crate::residual::History;
use crate::residual::lra::{Adapter, Settings};

/// A few roundings of numbers near 10.
const ROUNDING: f64 = 1e-9;

/// Slope of the ramp per tick, N and N m.
const SLOPE: f64 = 0.01;

/// One tick of the foresight whose forecast starts at `now` and rises by `slope` per step, for the residual `r`; the adapter is off.
fn step(foresight: &mut Foresight, r: f64, now: f64, slope: f64, lead_s: f64) -> Foreseen {
    let base = (0..=25).map(|j| Coords::repeat(now + slope * f64::from(j)).into()).collect();
    let forecast = Forecast { base, regime: Vec::new(), attention: Vec::new() };
    let settings = Settings { enabled: false, ..Settings::default() };
    let residual = KnownCoords::from(Coords::repeat(r));
    let mut adapter = Adapter::new(0, Coords::repeat(1.0), &settings);
    let adapted = adapter.step(&forecast, &History::new(1), &residual, TICK_S, false, &settings);
    foresight.step(&forecast, &adapted, &residual, &Coords::repeat(lead_s), TICK_S, true)
}

#[test]
fn a_ramp_that_is_forecast_is_compensated_at_the_lead_and_without_lead_as_it_is_now() {
    let (mut ahead, mut none) = (Foresight::default(), Foresight::default());
    for t in 0..200 {
        let r = SLOPE * f64::from(t);
        // 35 ms lie between the third and the fourth step.
        let foreseen = step(&mut ahead, r, r, SLOPE, 0.035);
        assert!((foreseen.used[0] - (r + 3.5 * SLOPE)).abs() < ROUNDING, "{t}: {foreseen:?}");
        assert!((foreseen.trust[5] - 1.0).abs() < ROUNDING);
        let foreseen = step(&mut none, r, r, SLOPE, 0.0);
        assert!((foreseen.used[7] - r).abs() < ROUNDING);
    }
    // A lead beyond the horizon takes its end.
    assert!(
        (step(&mut ahead, 2.0, 2.0, SLOPE, 0.4).r_hat[2] - (2.0 + 25.0 * SLOPE)).abs() < ROUNDING
    );
}

#[test]
fn the_error_at_the_lead_is_that_of_the_forecast_made_one_lead_ago() {
    let mut foresight = Foresight::default();
    for t in 0..40 {
        let r = SLOPE * f64::from(t);
        // The forecast stays where it is, so ten ticks later it errs by ten slopes.
        let error = step(&mut foresight, r, r, 0.0, 0.1).error.get(3);
        let wanted = (t >= 10).then_some(10.0 * SLOPE);
        assert_eq!(error.is_some(), wanted.is_some(), "{t}");
        assert!((error.unwrap_or(0.0) - wanted.unwrap_or(0.0)).abs() < ROUNDING, "{t}: {error:?}");
    }
}

#[test]
fn a_forecast_that_errs_more_than_persistence_loses_its_weight() {
    let mut foresight = Foresight::default();
    let mut last = None;
    for t in 0..300 {
        let r = SLOPE * f64::from(t);
        // It foresees a fall while the residual rises: it errs twice as much as persistence.
        last = Some(step(&mut foresight, r, r, -SLOPE, 0.1));
    }
    let foreseen = last.unwrap();
    assert_eq!(foreseen.trust, Coords::zeros());
    assert!((foreseen.used[0] - 299.0 * SLOPE).abs() < ROUNDING, "the estimate of now");
}

#[test]
fn in_contact_nothing_is_judged_and_what_waits_is_dropped() {
    let mut foresight = Foresight::default();
    for t in 0..30 {
        step(&mut foresight, f64::from(t), 0.0, 0.0, 0.05);
    }
    let forecast = Forecast {
        base: vec![Coords::zeros().into(); 26],
        regime: Vec::new(),
        attention: Vec::new(),
    };
    let settings = Settings { enabled: false, ..Settings::default() };
    let residual = KnownCoords::from(Coords::repeat(100.0));
    let adapted = Adapter::new(0, Coords::repeat(1.0), &settings).step(
        &forecast,
        &History::new(1),
        &residual,
        TICK_S,
        true,
        &settings,
    );
    let lead = Coords::repeat(0.05);
    let held = foresight.step(&forecast, &adapted, &residual, &lead, TICK_S, false);
    assert!(!held.error.is_any_known());
    assert!(!step(&mut foresight, 0.0, 0.0, 0.0, 0.05).error.is_any_known());
}

#[test]
fn nine_tenths_of_the_errors_lie_in_the_band_whatever_their_distribution() {
    // 90 % ± 1.5 %: three deviations of the share among 20,000 errors that are correlated over the memory of 2 s.
    const TOLERANCE: f64 = 0.015;
    for heavy in [false, true] {
        let mut rng = Pcg64::seed_from_u64(5);
        let mut foresight = Foresight::default();
        let (mut inside, mut all) = (0.0, 0.0);
        let mut band: Option<f64> = None;
        for t in 0..21_000 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            // The heavy tails of a cube are those of gusts.
            let r = if heavy { normal * normal * normal } else { normal };
            if let Some(half) = band.filter(|_| t > 1000) {
                all += 1.0;
                inside += f64::from(u8::from(r.abs() <= half));
            }
            band = step(&mut foresight, r, 0.0, 0.0, 0.05).std.get(0).map(|std| BAND_90 * std);
        }
        assert!((inside / all - 0.9).abs() < TOLERANCE, "{heavy}: {}", inside / all);
    }
}
