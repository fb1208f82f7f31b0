//! The ways in which a flight may end.

use serde::{Deserialize, Serialize};

/// How a flight ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The task is done: the payload rests upright at its place.
    Completed,
    /// The time ran out.
    TimedOut,
    /// The payload was lost in flight.
    Dropped,
    /// The payload was put down at the wrong place or in the wrong pose.
    Misplaced,
    /// The vehicle hit something or tipped over.
    Crashed,
    /// The vehicle left the arena.
    FlewAway,
    /// The task gave up.
    GaveUp,
    /// A value became NaN or infinite.
    NonFinite,
}

impl std::fmt::Display for Verdict {
    /// The name that `expect.verdict` of a scenario uses.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Completed => "completed",
            Self::TimedOut => "timed_out",
            Self::Dropped => "dropped",
            Self::Misplaced => "misplaced",
            Self::Crashed => "crashed",
            Self::FlewAway => "flew_away",
            Self::GaveUp => "gave_up",
            Self::NonFinite => "non_finite",
        })
    }
}

/// When a flight is over; the scenario's `verdict`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VerdictSettings {
    /// The vehicle has left when it is farther than this from the origin, m.
    pub arena_radius_m: f64,
    /// The vehicle has crashed when a body that is not a pad met something harder than this, N.
    pub crash_n: f64,
    /// The vehicle has tipped over when it is tilted more than this, rad.
    pub tipped_rad: f64,
    /// The payload is lost when it moved this far in the palm, m.
    pub lost_m: f64,
    /// A payload is placed within this horizontal distance of its place, m.
    pub placed_m: f64,
    /// A payload is placed within this height above or below its place, m.
    pub placed_height_m: f64,
    /// A payload is placed when it is tilted less than this, rad.
    pub placed_tilt_rad: f64,
    /// A payload is placed when it moves slower than this, m/s.
    pub placed_speed_m_s: f64,
}
