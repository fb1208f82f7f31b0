//! From what an acceleration of a recorded flight is derived.

use serde::Serialize;

/// How an acceleration was got.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Derivation {
    /// Slope of a measured velocity or angular velocity.
    MeasuredRate,
    /// Accelerometer, its bias corrected by the position.
    Accelerometer,
    /// Twice differentiated pose.
    Pose,
    /// As it was recorded by this program.
    Recorded,
    /// There is nothing to derive it from.
    Unknown,
}

impl Derivation {
    /// How often the acceleration and the force of the same rows pass `H`.
    pub fn passes(self) -> usize {
        if self == Self::Pose { 2 } else { 1 }
    }
}
