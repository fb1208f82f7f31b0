//! Loads and flies scenarios of the repository.

use std::path::Path;

use twin_core::tick::Tick;
use twin_scenario::{Report, Scenario, fly};

/// The scenario `scenarios/{name}.toml` with `overrides`.
pub(super) fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenarios/{name}.toml"));
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    Scenario::load(&file, &overrides).expect(name)
}

/// Flies the scenario to its verdict.
pub(super) fn flown(scenario: &Scenario) -> (Report, Vec<Tick>) {
    let mut ticks = Vec::new();
    let report = fly(scenario, &mut |tick| ticks.push(tick.clone())).expect("the scenario builds");
    (report, ticks)
}

/// Mean of `value` over the ticks from `from_s` to `to_s`.
pub(super) fn mean(ticks: &[Tick], from_s: f64, to_s: f64, value: impl Fn(&Tick) -> f64) -> f64 {
    let within = |tick: &&Tick| (from_s..to_s).contains(&tick.measurement.t_s);
    let values: Vec<f64> = ticks.iter().filter(within).map(value).collect();
    assert!(!values.is_empty(), "no tick from {from_s} s to {to_s} s");
    values.iter().sum::<f64>() / values.len() as f64
}
