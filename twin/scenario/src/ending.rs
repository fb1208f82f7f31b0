//! How a flight may end, in a word.

use serde::{Deserialize, Serialize};

/// How a flight ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The task is done: payload at rest, upright, where it belongs.
    Completed,
    /// The time ran out.
    TimedOut,
    /// The payload was lost on the way.
    Dropped,
    /// The payload was put down, but not where or how it should.
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
    /// The word of a scenario's `expect.verdict`.
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
