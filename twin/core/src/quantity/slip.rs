//! Which slip of the unit a number out of range looks like.

use super::Quantity;

/// A unit, a slip and the factor that turns the slip into the unit. Kilometres per hour are too near to metres per second to be
/// told from them.
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

/// A value at least so many times the end of its range was hardly meant in its unit; a smaller one is merely too large.
const IMPLAUSIBLE: f64 = 10.0;

/// A number in a wrong unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// The number as it was given.
    pub found: f64,
    /// The unit it looks like.
    pub unit: &'static str,
    /// The number in its right unit, to six digits.
    pub corrected: f64,
}

impl std::fmt::Display for Slip {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} looks like {}, write {}", self.found, self.unit, self.corrected)
    }
}

/// The first slip that makes `value`, which no one can have meant, a value of the range.
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
