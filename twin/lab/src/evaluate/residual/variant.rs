//! Which effects are on, and the flights with them.
//!
//! In: a scenario. Out: the ticks of its flight from 2 s on, while histories fill and filters settle before.

use serde::Serialize;

use super::super::series::{EvaluateError, ReplayTick};
use twin_core::source::{Disturbance, EFFECTS};
use twin_scenario::settings::Scheduled;
use twin_scenario::{Scenario, Verdict, fly};

/// Ticks before this time belong to the start, s.
pub const FROM_S: f64 = 2.0;

/// Which effects are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Variant {
    /// All of them.
    On,
    /// All but this one.
    Without(&'static str),
    /// None.
    Off,
}

impl Variant {
    /// Every variant: all on, each effect off in turn, all off.
    pub fn all() -> Vec<Self> {
        let without = EFFECTS.iter().map(|name| Self::Without(name));
        std::iter::once(Self::On).chain(without).chain([Self::Off]).collect()
    }

    /// The effects that are off.
    pub fn off(self) -> Vec<&'static str> {
        match self {
            Self::On => Vec::new(),
            Self::Without(name) => vec![name],
            Self::Off => EFFECTS.to_vec(),
        }
    }

    /// A few words for tables.
    pub fn words(self) -> String {
        match self {
            Self::On => "everything on".to_owned(),
            Self::Without(name) => format!("without {name}"),
            Self::Off => "everything off".to_owned(),
        }
    }
}

/// One flight.
#[derive(Clone, Debug, Serialize)]
pub struct Flown {
    /// Scenario.
    pub scenario: String,
    /// Seed.
    pub seed: u64,
    /// Which effects were on.
    pub variant: Variant,
    /// How the flight ended.
    pub verdict: Verdict,
    /// Reason for the verdict, in a sentence.
    pub reason: String,
    /// Number of its ticks from [`FROM_S`] on, up to the first whose residual is unknown.
    pub ticks: usize,
}

/// Flies `scenario` with the effects of `variant`; the other effects are switched off at 0 s. Returns the ticks that [`Flown::ticks`] counts.
///
/// # Errors
/// [`EvaluateError`] if the flight cannot be built, or a signal asked the program to end.
pub fn fly_variant(
    scenario: &Scenario,
    variant: Variant,
) -> Result<(Flown, Vec<ReplayTick>), EvaluateError> {
    let mut scenario = scenario.clone();
    let switch = |name: &str| Scheduled {
        at_s: 0.0,
        disturbance: Disturbance::Effect { name: name.to_owned(), on: false },
    };
    scenario.settings.disturbances.extend(variant.off().into_iter().map(switch));
    let (mut ticks, mut known) = (Vec::new(), true);
    let report = fly(&scenario, &mut |tick| {
        if tick.measurement.t_s < FROM_S {
            return;
        }
        let tick = ReplayTick::from(tick);
        known &= tick.residual.iter().all(|r| r.is_finite());
        if known {
            ticks.push(tick);
        }
    })?;
    let flown = Flown {
        scenario: report.scenario,
        seed: report.seed,
        variant,
        verdict: report.verdict,
        reason: report.reason,
        ticks: ticks.len(),
    };
    Ok((flown, ticks))
}
