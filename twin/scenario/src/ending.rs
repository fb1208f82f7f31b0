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
