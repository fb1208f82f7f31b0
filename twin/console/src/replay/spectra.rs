//! The eigenvalues of the adapter's covariance during a recorded flight. A recording has the trace only, so the covariance is computed
//! again: it depends on the features, which are recorded, and not on the residual.
//!
//! In: the ticks in their order. Out: the eigenvalues, largest first. State: an adapter without resets of its own.

use twin_core::notation::{Coords, TICK_S};
use twin_core::residual::History;
use twin_core::residual::lra::{Adapter, Settings};
use twin_core::tick::Tick;

/// The eigenvalues are computed every so many ticks, and after a reset.
const EVERY_TICKS: u64 = 10;

/// Largest relative difference from the recorded trace. A larger one means that an operator changed the adapter in flight, and that the
/// covariance is unknown until the next reset. The recorded trace has 64 bits.
const SAME_TRACE: f64 = 1e-6;

/// Follows the covariance.
pub(super) struct Spectra {
    adapter: Option<Adapter>,
    settings: Settings,
    /// The covariance does not depend on the history.
    unseen: History,
    newest: Vec<f64>,
}

impl Spectra {
    /// The spectra of a flight that starts with these settings of the adapter.
    pub(super) fn new(settings: &Settings) -> Self {
        // The recorded resets are taken over, so the adapter makes none. The horizon has a covariance of its own, which is not asked for.
        let settings = Settings { reset_enabled: false, horizon_memory_s: 0.0, ..*settings };
        Self { adapter: None, settings, unseen: History::new(1), newest: Vec::new() }
    }

    /// The eigenvalues at `tick`, which follows the tick of the last call; empty while they are unknown.
    pub(super) fn at(&mut self, tick: &Tick) -> &[f64] {
        let features = tick.forecast.regime.len();
        let settings = &self.settings;
        let start = |settings: &Settings| Adapter::new(features, Coords::repeat(1.0), settings);
        if tick.index == 0 {
            self.adapter = Some(start(settings));
        }
        if let Some(adapter) = &mut self.adapter {
            adapter.step(
                &tick.forecast,
                &self.unseen,
                &tick.residual,
                TICK_S,
                tick.adapted.frozen,
                settings,
            );
        }
        let trace = tick.adapted.covariance_trace;
        if tick.adapted.reset && features > 0 {
            let reset_scale = trace / features as f64;
            self.adapter = Some(start(&Settings { reset_scale, ..*settings }));
        }
        let same = |adapter: &Adapter| {
            (adapter.covariance().trace() - trace).abs() <= SAME_TRACE * trace.abs()
        };
        if !self.adapter.as_ref().is_some_and(same) {
            self.adapter = None;
            self.newest.clear();
        }
        if let Some(adapter) = &self.adapter
            && (tick.index.is_multiple_of(EVERY_TICKS) || tick.adapted.reset)
        {
            self.newest = adapter.spectrum();
        }
        &self.newest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_scenario::Scenario;

    /// Length of the flight that is compared.
    const TICKS: usize = 300;

    #[test]
    fn the_spectrum_of_the_ticks_is_that_of_the_adapter_that_flew_them() {
        let file = std::path::Path::new("../../scenarios/hover.toml");
        let scenario = Scenario::load(file, &[]).expect("a scenario");
        let mut flight = scenario.build().expect("a flight");
        let mut spectra = Spectra::new(&flight.tuning().adapter);
        let mut compared = 0;
        for _ in 0..TICKS {
            let tick = flight.tick();
            let found = spectra.at(&tick).to_vec();
            if !tick.index.is_multiple_of(EVERY_TICKS) {
                continue;
            }
            let flown = flight.covariance_spectrum();
            assert_eq!(found.len(), flown.len());
            for (found, flown) in found.iter().zip(&flown) {
                assert!(
                    (found - flown).abs() <= SAME_TRACE * flown.abs().max(1.0),
                    "{found}, {flown}"
                );
            }
            compared += 1;
        }
        assert!(compared > 20 && spectra.newest.len() > 1, "there is a spectrum to compare");
    }

    #[test]
    fn a_trace_that_differs_makes_the_spectrum_unknown_until_the_next_reset() {
        let mut tick = twin_record::fixture::tick(0);
        let settings = Settings::default();
        let mut spectra = Spectra::new(&settings);
        tick.adapted.frozen = true;
        tick.adapted.reset = false;
        let features = tick.forecast.regime.len() as f64;
        tick.adapted.covariance_trace = features * settings.reset_scale;
        assert_eq!(spectra.at(&tick).len(), tick.forecast.regime.len());
        tick.index = 10;
        tick.adapted.covariance_trace *= 2.0;
        assert!(spectra.at(&tick).is_empty(), "an operator changed something");
        tick.index = 20;
        assert!(spectra.at(&tick).is_empty(), "nothing is made up");
        (tick.index, tick.adapted.reset) = (30, true);
        assert_eq!(spectra.at(&tick).first(), Some(&(2.0 * settings.reset_scale)));
    }
}
