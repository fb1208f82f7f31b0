//! Recognises a slip of the unit in a number that is out of range.

use super::Quantity;

/// A unit, the unit of the slip, and the factor from the slip to the unit. Kilometres per hour are missing: the factor 3.6 is too small to
/// recognise.
const SLIPS: &[(&str, &str, f64)] = &[
    ("kg", "grams", 1e-3),
    ("m", "centimetres", 1e-2),
    ("m", "millimetres", 1e-3),
    ("s", "milliseconds", 1e-3),
    ("m/s", "millimetres per second", 1e-3),
    ("m/s²", "milli-g", 9.806_65e-3),
    ("N", "grams of thrust", 9.806_65e-3),
    ("rad", "degrees", std::f64::consts::PI / 180.0),
    ("rad/s", "degrees per second", std::f64::consts::PI / 180.0),
];

/// Factor beyond an end of the range from which a value counts as a slip of the unit; a smaller excess is merely too large a value.
const IMPLAUSIBLE: f64 = 10.0;

/// A number in a wrong unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// The number as it was given.
    pub found: f64,
    /// Unit in which the number would make sense.
    pub unit: &'static str,
    /// The number in its right unit, to six digits.
    pub corrected: f64,
}

impl std::fmt::Display for Slip {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} looks like {}, write {}", self.found, self.unit, self.corrected)
    }
}

/// The first slip of the unit that turns the implausible `value` into a value within the range.
pub(super) fn of(quantity: &Quantity, value: f64) -> Option<Slip> {
    let end = quantity.max.abs().max(quantity.min.abs());
    if !value.is_finite() || value.abs() < IMPLAUSIBLE * end {
        return None;
    }
    let of_unit = SLIPS.iter().filter(|(of, ..)| *of == quantity.unit);
    of_unit
        .map(|(_, unit, factor)| Slip { found: value, unit, corrected: rounded(value * factor) })
        .find(|slip| quantity.allows(slip.corrected))
}

/// Six significant digits: the corrected value is a suggestion.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
