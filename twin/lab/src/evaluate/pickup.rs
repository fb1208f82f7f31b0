//! Measures the adapter after a change of the load: innovation, covariance resets and the time until the estimate fits again, with the
//! adapter, without it, and without its reset.

use serde::Serialize;

use super::pictures::{Curve, Picture};
use super::series::EvaluateError;
use twin_core::notation::position;
use twin_core::tick::{EventKind, Tick};
use twin_scenario::{Scenario, Verdict, fly};

/// Modes of the adapter: name and the overrides that select it.
pub const MODES: [(&str, &[&str]); 3] = [
    ("adapter on", &[]),
    ("reset disabled", &["gains.reset_threshold=1000"]),
    ("adapter off", &["gains.adapter_on=0"]),
];

/// The estimate fits again once its vertical error stays below [`FITS_N`] (N) for [`STAYS_S`] (s).
const FITS_N: f64 = 0.5;
const STAYS_S: f64 = 0.5;

/// Window around the change of the load: s before and s after it.
const BEFORE_S: f64 = 2.0;
const AFTER_S: f64 = 6.0;

/// Result of one flight.
#[derive(Clone, Debug, Serialize)]
pub struct PickupFlight {
    /// Scenario.
    pub scenario: String,
    /// Mode of the adapter.
    pub mode: &'static str,
    /// Seed.
    pub seed: u64,
    /// How the flight ended.
    pub verdict: Verdict,
    /// Time of the change of the load, s; `None` if it never changed.
    pub at_s: Option<f64>,
    /// Times of all resets of the flight, s.
    pub resets_s: Vec<f64>,
    /// Largest smoothed innovation within the window, compared with the threshold.
    pub innovation_peak: f64,
    /// The threshold in force.
    pub threshold: f64,
    /// Time until the estimate's vertical error stays small, s; `None` if it does not within the window.
    pub recovery_s: Option<f64>,
    /// Largest position error within the window, m.
    pub error_peak_m: f64,
    #[serde(skip)]
    rows: Vec<TickRecord>,
}

#[derive(Clone, Copy, Debug)]
struct TickRecord {
    t_s: f64,
    innovation: f64,
    estimate_error_n: f64,
    error_m: f64,
    held: bool,
}

impl From<&Tick> for TickRecord {
    fn from(tick: &Tick) -> Self {
        let chi = tick.truth.as_ref().map_or(&*tick.measurement.chi, |truth| &truth.chi);
        Self {
            t_s: tick.measurement.t_s,
            innovation: tick.adapted.innovation_mean_norm,
            estimate_error_n: tick.residual[2] - tick.adapted.r_hat_prior[2],
            error_m: (position(chi) - position(&tick.reference.chi_des)).norm(),
            held: tick.adapted.frozen
                && tick.reference.adaptation == twin_core::tick::Adaptation::Held,
        }
    }
}

/// Flies `scenario` in `mode`. The load changes when the cube leaves its support (the phase after the grasp) or is dropped.
///
/// # Errors
/// [`EvaluateError`] if the flight cannot be built.
pub fn pick_up(scenario: &Scenario, mode: &'static str) -> Result<PickupFlight, EvaluateError> {
    let tuning = scenario.tuning().map_err(twin_scenario::BuildError::from)?;
    let (mut rows, mut resets_s, mut at_s) = (Vec::new(), Vec::new(), None);
    let report = fly(scenario, &mut |tick| {
        rows.push(TickRecord::from(tick));
        if tick.adapted.reset {
            resets_s.push(tick.measurement.t_s);
        }
        let changes = |kind: EventKind, text: &str| {
            tick.events.iter().any(|event| event.kind == kind && event.text.contains(text))
        };
        if changes(EventKind::Grasp, "") || changes(EventKind::Disturbance, "payload") {
            at_s = Some(tick.measurement.t_s);
        }
    })?;
    let inside = |t_s: f64| at_s.is_some_and(|at| t_s >= at && t_s <= at + AFTER_S);
    let peak = |value: fn(&TickRecord) -> f64| {
        rows.iter().filter(|row| inside(row.t_s)).map(value).fold(0.0, f64::max)
    };
    Ok(PickupFlight {
        scenario: report.scenario,
        mode,
        seed: report.seed,
        verdict: report.verdict,
        at_s,
        resets_s,
        innovation_peak: peak(|row| row.innovation),
        threshold: tuning.adapter.reset_threshold,
        recovery_s: at_s.and_then(|at| recovery(&rows, at)),
        error_peak_m: peak(|row| row.error_m),
        rows,
    })
}

/// Time from `at_s` until the estimate fits and continues to fit, s; a tick with a frozen adapter does not count as fitting.
fn recovery(rows: &[TickRecord], at_s: f64) -> Option<f64> {
    let mut since = None;
    for row in rows.iter().filter(|row| row.t_s >= at_s && row.t_s <= at_s + AFTER_S) {
        if row.held || row.estimate_error_n.abs() > FITS_N {
            since = None;
            continue;
        }
        let begun = *since.get_or_insert(row.t_s);
        if row.t_s - begun >= STAYS_S {
            return Some(begun - at_s);
        }
    }
    None
}

/// The flights of one scenario as pictures: innovation with resets, and the vertical error of the estimate.
pub fn pictures(flights: &[PickupFlight]) -> Vec<Picture> {
    let Some(first) = flights.first() else { return Vec::new() };
    let picture = |what: &str, y: &str, value: fn(&TickRecord) -> f64| Picture {
        title: format!("{}: {what} about the change of the load", first.scenario),
        x: "s after the load changes".to_owned(),
        y: y.to_owned(),
        curves: flights.iter().map(|flown| curve(flown, value)).collect(),
        marks: marks(flights),
        map: false,
    };
    vec![
        picture("mean innovation", "norm, z", |row| row.innovation),
        picture("vertical error of the estimate", "N", |row| row.estimate_error_n),
        picture("position error", "m", |row| row.error_m),
    ]
}

fn curve(flown: &PickupFlight, value: fn(&TickRecord) -> f64) -> Curve {
    let at_s = flown.at_s.unwrap_or(0.0);
    let points = flown.rows.iter().map(|row| (row.t_s - at_s, value(row)));
    Curve {
        name: flown.mode.to_owned(),
        points: points.filter(|(t_s, _)| (-BEFORE_S..=AFTER_S).contains(t_s)).collect(),
        measured: false,
    }
}

/// Marks at the change of the load and at the resets of the flight with the adapter on.
fn marks(flights: &[PickupFlight]) -> Vec<(f64, String)> {
    let resets = flights.iter().find(|flown| flown.mode == MODES[0].0).map(|flown| {
        let at_s = flown.at_s.unwrap_or(0.0);
        flown.resets_s.iter().map(move |t_s| (t_s - at_s, "reset".to_owned()))
    });
    std::iter::once((0.0, "load changes".to_owned()))
        .chain(resets.into_iter().flatten())
        .filter(|(t_s, _)| (-BEFORE_S..=AFTER_S).contains(t_s))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recovery_is_when_the_estimate_begins_to_fit_for_good() {
        let row = |tick: u32, estimate_error_n: f64| TickRecord {
            t_s: f64::from(tick) * 0.01,
            innovation: 0.0,
            estimate_error_n,
            error_m: 0.0,
            held: (300..320).contains(&tick),
        };
        // Wrong by 3 N until 1.5 s, right for 0.3 s, wrong again, right from 2.2 s on; contact at 3 s comes too late to matter.
        let error = |tick: u32| match tick {
            0..150 | 180..220 => 3.0,
            _ => 0.1,
        };
        let rows: Vec<TickRecord> = (0..600).map(|tick| row(tick, error(tick))).collect();
        assert!((recovery(&rows, 1.0).unwrap() - 1.2).abs() < 1e-9);
        assert!((recovery(&rows, 2.8).unwrap() - 0.4).abs() < 1e-9, "held is not fitting");
        let never: Vec<TickRecord> = (0..600).map(|tick| row(tick, 3.0)).collect();
        assert_eq!(recovery(&never, 1.0), None);
    }
}
