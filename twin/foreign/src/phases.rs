//! The phases of a recorded flight, each with its reason: ground, take-off, air, landing, crash, carried by hand.
//!
//! In: thrust, motion, attitude, arming and land detection on ticks. Out: a phase per tick, and [`Span`]s. Thrust alone does not say that
//! a vehicle flies: props may turn on the ground for a minute. Residuals, fits and scores use the phase "air" alone.

use nalgebra::Vector3;
use serde::Serialize;

use super::flags::Flags;
use super::grid::Ticks;
use super::series::Series;
use super::thrust_fit::{AIRBORNE_SHARE, high};
use twin_core::notation::{TICK_S, world_from_body};

/// Least thrust of a flying vehicle, as a share of its largest thrust.
pub(super) const LEAST_THRUST: f64 = 0.05;

/// Shortest flight and shortest landing, ticks (0.5 s): a shorter time with thrust is a spike, a shorter time without is a dip.
const SHORT_TICKS: usize = 50;

/// Ticks before and after a tick over which its speed is measured.
const SPEED_TICKS: usize = 25;

/// Speed below which a vehicle stands still, m/s: noise of motion capture and of estimators indoors stays below, and no hover does for
/// half a second.
const STILL_M_S: f64 = 0.03;

/// Speed above which a vehicle without thrust is carried, m/s.
const CARRIED_M_S: f64 = 0.15;

/// Height above the take-off place below which a vehicle that stands still stands on the ground, m.
const LOW_M: f64 = 0.1;

/// Height at which a take-off ends and a landing begins, m, where the ground's effect on the props is over, and its longest time, ticks.
const CLEAR_M: f64 = 0.3;
const CLEAR_TICKS: usize = 100;

/// Share of the thrust of hovering below which nothing hovers.
const CARRYING_SHARE: f64 = 0.7;

/// Cosine of the tilt beyond which a flight is a crash (60 degrees), and the time before the end of thrust in which it counts, ticks.
const CRASH_COS: f64 = 0.5;
const CRASH_TICKS: usize = 140;

/// Longest time for which a vehicle that tipped over tumbles with thrust before somebody stops it, ticks.
const TUMBLE_TICKS: usize = 300;

/// Number of ticks at rest from which the take-off place is known, and of ticks in flight for the thrust of hovering.
const FEWEST_TICKS: usize = 50;

/// The phase of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Nothing says whether it flies.
    #[default]
    Unknown,
    /// On the ground.
    Ground,
    /// Leaving the ground.
    TakeOff,
    /// In free flight.
    Air,
    /// Near the ground before it stands there.
    Landing,
    /// Tipped over.
    Crash,
    /// Moved without thrust.
    Carried,
}

impl Phase {
    /// The phase in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Unknown => "unknown whether it flies",
            Self::Ground => "on the ground",
            Self::TakeOff => "take-off",
            Self::Air => "in the air",
            Self::Landing => "landing",
            Self::Crash => "crash",
            Self::Carried => "carried by hand",
        }
    }
}

/// A span of one phase.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Span {
    /// The phase.
    pub phase: Phase,
    /// Time of its first tick, s.
    pub from_s: f64,
    /// Time after its last tick, s.
    pub to_s: f64,
    /// The evidence, in words.
    pub why: &'static str,
}

/// What a whole flight says about its phases; a part of the flight reuses it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Yardsticks {
    /// Thrust above which a vehicle may fly, in the unit of the thrust.
    pub threshold: f64,
    /// Height of the take-off place, m; `None` if the vehicle never stands still without thrust.
    pub ground_m: Option<f64>,
    /// Thrust of hovering, in its unit; `None` if it never flies high above the take-off place.
    pub hover: Option<f64>,
}

/// The evidence on ticks.
pub(super) struct Evidence<'a> {
    pub(super) times_s: &'a [f64],
    /// Thrust along the body's z axis, in any unit.
    pub(super) thrust: Option<&'a Series<1>>,
    /// Position of the base, m.
    pub(super) position: &'a Ticks<3>,
    /// Roll, pitch and yaw, rad.
    pub(super) eta: &'a Ticks<3>,
    pub(super) landed: Option<&'a Flags>,
    pub(super) armed: Option<&'a Flags>,
}

/// A phase and its evidence.
type Judged = (Phase, &'static str);

const NO_THRUST: Judged = (Phase::Ground, "no thrust");
const FLIES: Judged = (Phase::Air, "thrust and motion of a flight");

impl Evidence<'_> {
    fn thrust_at(&self, tick: usize) -> Option<f64> {
        Some(self.thrust?.linear(self.times_s[tick])?.x)
    }

    fn landed_at(&self, tick: usize) -> Option<bool> {
        self.landed?.at(self.times_s[tick])
    }

    fn height_at(&self, tick: usize) -> Option<f64> {
        Some(self.position.get(tick)?.as_ref()?.z)
    }

    /// Mean speed around a tick, m/s.
    fn speed_at(&self, tick: usize) -> Option<f64> {
        let (from, to) = (tick.saturating_sub(SPEED_TICKS), tick + SPEED_TICKS);
        let known = |tick: &usize| self.position[*tick].is_some();
        let last = (tick..=to.min(self.position.len() - 1)).rev().find(known)?;
        let first = (from..=tick).find(known)?;
        let time_s = self.times_s[last] - self.times_s[first];
        let moved = self.position[last]? - self.position[first]?;
        (time_s > 2.0 * TICK_S).then(|| moved.norm() / time_s)
    }

    fn is_tipped(&self, tick: usize) -> bool {
        let upright = |eta: &Vector3<f64>| (world_from_body(eta) * Vector3::z()).z;
        self.eta[tick].as_ref().is_some_and(|eta| upright(eta) < CRASH_COS)
    }

    /// The yardsticks of this flight. Least thrust is that of a vehicle with the force sensor's unit, or a share.
    pub(super) fn yardsticks(&self, least: f64) -> Yardsticks {
        let threshold =
            self.thrust.map_or(f64::INFINITY, |thrust| (high(thrust) * AIRBORNE_SHARE).max(least));
        let ticks = || 0..self.times_s.len();
        let idle = |tick: &usize| {
            let quiet = self.thrust_at(*tick).is_some_and(|u| u <= threshold)
                || self.landed_at(*tick) == Some(true);
            quiet && self.speed_at(*tick).is_some_and(|speed| speed < STILL_M_S)
        };
        let heights = ticks().filter(idle).filter_map(|tick| self.height_at(tick));
        let ground_m = median(heights.take(FEWEST_TICKS).collect());
        let flying = |tick: &usize| {
            let clear = self.height_at(*tick).zip(ground_m).is_some_and(|(z, z0)| z - z0 > CLEAR_M);
            clear && self.landed_at(*tick) != Some(true)
        };
        let thrusts = ticks().filter(flying).filter_map(|tick| self.thrust_at(tick));
        let hover = median(thrusts.filter(|u| *u > threshold).collect());
        Yardsticks { threshold, ground_m, hover }
    }

    /// Phase of one tick, without its neighbours.
    fn alone(&self, tick: usize, by: &Yardsticks) -> Judged {
        let Some(speed) = self.speed_at(tick) else { return self.without_motion(tick, by) };
        let armed = self.armed.and_then(|flags| flags.at(self.times_s[tick]));
        let landed = self.landed_at(tick);
        let still = speed < STILL_M_S;
        let above_m = self.height_at(tick).zip(by.ground_m).map(|(z, ground)| z - ground);
        let at_place = above_m.is_some_and(|above| above < LOW_M);
        match self.thrust_at(tick) {
            None if self.thrust.is_some() => (Phase::Unknown, "the thrust is missing"),
            None if landed == Some(false) => (Phase::Air, "the autopilot detects no landing"),
            None if landed == Some(true) => (Phase::Ground, "the autopilot detects a landing"),
            None => (Phase::Unknown, "neither thrust nor land detection in the recording"),
            Some(_) if armed == Some(false) && speed > CARRIED_M_S => {
                (Phase::Carried, "disarmed, and it moves")
            }
            Some(_) if armed == Some(false) => (Phase::Ground, "disarmed"),
            Some(u) if u <= by.threshold && speed > CARRIED_M_S => {
                (Phase::Carried, "it moves without thrust")
            }
            Some(u) if u <= by.threshold => NO_THRUST,
            // Detectors are late by a second or so, so a motion above the ground says more.
            Some(_) if landed == Some(true) && (still || at_place || above_m.is_none()) => {
                (Phase::Ground, "the autopilot detects that it stands on the ground")
            }
            Some(_) if still && at_place => {
                (Phase::Ground, "thrust, but it stands still at the take-off place")
            }
            Some(u) if still && by.hover.is_some_and(|hover| u < CARRYING_SHARE * hover) => {
                (Phase::Ground, "it stands still with less thrust than carries it")
            }
            Some(_) => FLIES,
        }
    }

    /// Phase of a tick without a position: thrust decides alone.
    fn without_motion(&self, tick: usize, by: &Yardsticks) -> Judged {
        match (self.thrust_at(tick), self.landed_at(tick)) {
            (Some(_), Some(true)) => (Phase::Ground, "the autopilot detects a landing"),
            (Some(u), _) if u > by.threshold => (Phase::Air, "thrust; the motion is unknown"),
            (Some(_), _) => NO_THRUST,
            (None, _) => (Phase::Unknown, "thrust and motion are missing"),
        }
    }

    /// Phase and evidence of every tick.
    pub(super) fn judge(&self, by: &Yardsticks) -> Vec<Judged> {
        let mut judged: Vec<Judged> =
            (0..self.times_s.len()).map(|tick| self.alone(tick, by)).collect();
        without_dips_and_spikes(&mut judged);
        for (from, to) in runs(&judged) {
            // The speed around the ticks beside a flight contains its motion; nobody carries a vehicle for so short a time.
            if judged[from].0 == Phase::Carried && to - from < SHORT_TICKS {
                judged[from..to].fill(NO_THRUST);
            }
        }
        for (from, to) in runs(&judged) {
            if judged[from].0 == Phase::Air {
                self.edges(&mut judged, from, to);
            }
        }
        for (from, to) in runs(&judged) {
            let tipped = |tick: &usize| self.is_tipped(*tick);
            if judged[from].0 == Phase::Air && to - from >= SHORT_TICKS {
                let last = to.saturating_sub(CRASH_TICKS).max(from);
                if to < judged.len()
                    && let Some(start) = (last..to).find(tipped)
                {
                    judged[start..to].fill((
                        Phase::Crash,
                        "tilted by more than 60 degrees before the thrust ended",
                    ));
                }
            }
        }
        self.tipped_for_long(&mut judged);
        for (from, to) in runs(&judged) {
            let after_crash = from > 0 && judged[from - 1].0 == Phase::Crash;
            if judged[from].0 == Phase::Air && after_crash && to - from < TUMBLE_TICKS {
                judged[from..to].fill((Phase::Crash, "it tumbles after it tipped over"));
            }
        }
        judged
    }

    /// Marks take-off and landing at the ends of a flight from tick `from` to `to`.
    fn edges(&self, judged: &mut [Judged], from: usize, to: usize) {
        let near = |place: Option<f64>, tick: &usize| {
            self.height_at(*tick).zip(place).is_none_or(|(z, place)| z - place < CLEAR_M)
        };
        let ground = |tick: Option<usize>| {
            tick.is_some_and(|tick| judged.get(tick).is_some_and(|(p, _)| *p == Phase::Ground))
        };
        let (rises, sinks) = (ground(from.checked_sub(1)), ground(Some(to)));
        if rises {
            let place = self.height_at(from);
            let end = (from..to.min(from + CLEAR_TICKS)).find(|tick| !near(place, tick));
            let end = end.unwrap_or(to.min(from + CLEAR_TICKS));
            judged[from..end].fill((Phase::TakeOff, "it leaves the ground"));
        }
        if sinks {
            let place = self.height_at(to - 1);
            let first = to.saturating_sub(CLEAR_TICKS).max(from);
            let start = (first..to).rev().find(|tick| !near(place, tick)).map_or(first, |t| t + 1);
            judged[start..to].fill((Phase::Landing, "it comes to the ground"));
        }
    }

    /// Marks a flight that stays tipped: no vehicle that flies does so for half a second.
    fn tipped_for_long(&self, judged: &mut [Judged]) {
        let mut start = 0;
        while start < judged.len() {
            let end = (start..judged.len()).find(|tick| !self.is_tipped(*tick));
            let end = end.unwrap_or(judged.len());
            if end - start >= SHORT_TICKS {
                let thrusts = judged[start..end].iter_mut().filter(|(phase, _)| {
                    matches!(phase, Phase::Air | Phase::TakeOff | Phase::Landing)
                });
                thrusts.for_each(|j| *j = (Phase::Crash, "tilted by more than 60 degrees"));
            }
            start = end + 1;
        }
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    (values.len() >= FEWEST_TICKS).then(|| values[values.len() / 2])
}

/// First tick and the tick after the last one of each run of one phase.
fn runs(judged: &[Judged]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for tick in 0..judged.len() {
        match runs.last_mut() {
            Some((from, to)) if judged[*from].0 == judged[tick].0 => *to = tick + 1,
            _ => runs.push((tick, tick + 1)),
        }
    }
    runs
}

/// A short dip of the thrust inside a flight belongs to it; a short flight is a spike and belongs to what was before it.
fn without_dips_and_spikes(judged: &mut [Judged]) {
    let is_air =
        |judged: &[Judged], tick: usize| judged.get(tick).is_some_and(|j| j.0 == Phase::Air);
    for flying in [false, true] {
        let mut start = 0;
        while start < judged.len() {
            let air = is_air(judged, start) == flying;
            let end =
                (start..judged.len()).find(|tick| is_air(judged, *tick) != is_air(judged, start));
            let (end, inside) = (end.unwrap_or(judged.len()), start > 0 && end.is_some());
            if air && end - start < SHORT_TICKS && (inside || flying) {
                let other = if flying {
                    let before = start.checked_sub(1).and_then(|tick| judged.get(tick));
                    before.or(judged.get(end)).copied().unwrap_or(NO_THRUST)
                } else {
                    judged[start - 1]
                };
                judged[start..end].fill(other);
            }
            start = end;
        }
    }
}

/// The spans of a flight. A hole in its times ends a span.
pub(super) fn spans(times_s: &[f64], judged: &[Judged]) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for (t_s, (phase, why)) in times_s.iter().zip(judged) {
        match spans.last_mut() {
            Some(span) if span.phase == *phase && t_s - span.to_s < TICK_S => {
                span.to_s = t_s + TICK_S;
            }
            _ => spans.push(Span { phase: *phase, from_s: *t_s, to_s: t_s + TICK_S, why }),
        }
    }
    spans
}

#[cfg(test)]
#[path = "phases_tests.rs"]
mod tests;
