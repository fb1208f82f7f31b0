//! The numeric attributes of a URDF: how many numbers each holds, and their range.
//!
//! `urdf-rs` skips words that are not numbers, and accepts NaN and infinity; these checks refuse all of them first.

/// Largest magnitude of a length, angle, mass or inertia; a larger number has a wrong unit or exponent.
const MAX_MAGNITUDE: f64 = 1e6;

#[derive(Clone, Copy)]
enum Range {
    Bounded,
    Positive,
    NotNegative,
    NotZero,
    Unit,
    Finite,
}

/// A numeric attribute and the numbers that it may hold.
pub(super) struct Number {
    pub(super) element: &'static str,
    pub(super) attribute: &'static str,
    count: usize,
    range: Range,
    pub(super) required: bool,
}

const fn number(
    element: &'static str,
    attribute: &'static str,
    count: usize,
    range: Range,
    required: bool,
) -> Number {
    Number { element, attribute, count, range, required }
}

/// Every numeric attribute of a link or a joint.
pub(super) const NUMBERS: &[Number] = &[
    number("origin", "xyz", 3, Range::Bounded, false),
    number("origin", "rpy", 3, Range::Bounded, false),
    number("origin", "quat_xyzw", 4, Range::Bounded, false),
    number("mass", "value", 1, Range::Positive, true),
    number("inertia", "ixx", 1, Range::Bounded, true),
    number("inertia", "ixy", 1, Range::Bounded, true),
    number("inertia", "ixz", 1, Range::Bounded, true),
    number("inertia", "iyy", 1, Range::Bounded, true),
    number("inertia", "iyz", 1, Range::Bounded, true),
    number("inertia", "izz", 1, Range::Bounded, true),
    number("box", "size", 3, Range::Positive, true),
    number("cylinder", "radius", 1, Range::Positive, true),
    number("cylinder", "length", 1, Range::Positive, true),
    number("capsule", "radius", 1, Range::Positive, true),
    number("capsule", "length", 1, Range::Positive, true),
    number("sphere", "radius", 1, Range::Positive, true),
    number("mesh", "scale", 3, Range::NotZero, false),
    number("color", "rgba", 4, Range::Unit, true),
    number("axis", "xyz", 3, Range::Bounded, true),
    number("limit", "lower", 1, Range::Finite, false),
    number("limit", "upper", 1, Range::Finite, false),
    number("limit", "effort", 1, Range::NotNegative, true),
    number("limit", "velocity", 1, Range::NotNegative, true),
    number("dynamics", "damping", 1, Range::NotNegative, false),
    number("dynamics", "friction", 1, Range::NotNegative, false),
    number("mimic", "multiplier", 1, Range::Bounded, false),
    number("mimic", "offset", 1, Range::Bounded, false),
];

impl Number {
    /// Whether `text` holds the right count of numbers, each in range.
    pub(super) fn accepts(&self, text: &str) -> bool {
        let mut count = 0;
        let good = text.split_whitespace().all(|word| {
            count += 1;
            word.parse().is_ok_and(|value| self.range.contains(value))
        });
        good && count == self.count
    }

    /// The allowed content of the attribute, in words.
    pub(super) fn allowed(&self) -> String {
        let plural = if self.count == 1 { "" } else { "s" };
        format!("{} finite number{plural}, {}", self.count, self.range.words())
    }
}

impl Range {
    fn contains(self, value: f64) -> bool {
        let bounded = value.abs() <= MAX_MAGNITUDE;
        match self {
            Range::Bounded => bounded,
            Range::Positive => bounded && value > 0.0,
            Range::NotZero => bounded && value != 0.0,
            Range::NotNegative => value.is_finite() && value >= 0.0,
            Range::Unit => (0.0..=1.0).contains(&value),
            Range::Finite => value.is_finite(),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Range::Bounded => "of magnitude up to 1e6",
            Range::Positive => "above 0 and up to 1e6",
            Range::NotZero => "not 0, of magnitude up to 1e6",
            Range::NotNegative => "0 or above",
            Range::Unit => "each in 0..=1",
            Range::Finite => "of either sign",
        }
    }
}
