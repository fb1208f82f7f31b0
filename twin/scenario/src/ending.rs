//! The ways in which a flight may end.

use serde::{Deserialize, Serialize};

/// How a flight ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The task is done: the payload rests upright at its place, or the vehicle followed its reference in the air.
    Completed,
    /// The time ran out.
    TimedOut,
    /// The payload was lost in flight.
    Dropped,
    /// The payload was put down at the wrong place or in the wrong pose.
    Misplaced,
    /// The vehicle ended its hover, path or way-points on a surface.
    Grounded,
    /// The vehicle ended its hover, path or way-points too far from its reference.
    OffCourse,
    /// The vehicle hit something or tipped over.
    Crashed,
    /// The vehicle left the arena.
    FlewAway,
    /// The task gave up.
    GaveUp,
    /// A value became NaN or infinite.
    NonFinite,
    /// A signal ended the program before the flight was over. No scenario can expect this.
    #[serde(skip_deserializing)]
    Interrupted,
}

impl std::fmt::Display for Verdict {
    /// The name that `expect.verdict` of a scenario uses.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Completed => "completed",
            Self::TimedOut => "timed_out",
            Self::Dropped => "dropped",
            Self::Misplaced => "misplaced",
            Self::Grounded => "grounded",
            Self::OffCourse => "off_course",
            Self::Crashed => "crashed",
            Self::FlewAway => "flew_away",
            Self::GaveUp => "gave_up",
            Self::NonFinite => "non_finite",
            Self::Interrupted => "interrupted",
        })
    }
}

/// Criteria for the end of a flight; the scenario's `verdict`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VerdictSettings {
    /// The vehicle has left the arena if it is farther than this from the origin, m.
    pub arena_radius_m: f64,
    /// The vehicle has crashed if a contact force on a body other than a pad exceeds this, N.
    pub crash_n: f64,
    /// The vehicle has tipped over if its tilt exceeds this, rad.
    pub tipped_rad: f64,
    /// A hover, a path or way-points are completed if the position error, as its root mean square, is at most this, m.
    pub error_m: f64,
    /// The payload is lost if it has moved this far in the palm, m.
    pub lost_m: f64,
    /// A payload is placed if its horizontal distance from its place is below this, m.
    pub placed_m: f64,
    /// A payload is placed if its height differs from that of its place by less than this, m.
    pub placed_height_m: f64,
    /// A payload is placed if its tilt is below this, rad.
    pub placed_tilt_rad: f64,
    /// A payload is placed if its speed is below this, m/s.
    pub placed_speed_m_s: f64,
}
