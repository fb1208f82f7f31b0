//! The source from which an acceleration of a recorded flight is derived.

use serde::Serialize;

/// How an acceleration was derived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Derivation {
    /// The slope of a measured velocity or angular velocity.
    MeasuredRate,
    /// The accelerometer, with its bias corrected by the position.
    Accelerometer,
    /// The second derivative of the pose.
    Pose,
    /// A recording of this program, which contains the acceleration itself.
    Recorded,
    /// No source: the acceleration is unknown.
    Unknown,
}

impl Derivation {
    /// Number of times that the acceleration, and the applied force that belongs to it, pass the filter `H`.
    pub fn passes(self) -> usize {
        if self == Self::Pose { 2 } else { 1 }
    }
}
