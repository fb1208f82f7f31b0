//! The registry of quantities: name, unit, range and help of every number in a scenario, on a slider or in a message, each defined once.
//!
//! The registry serves the check of scenario files, their JSON Schema, the gains, the check of clients' messages and the sliders. [`at`]
//! finds a quantity by the key of a scenario; code that handles one quantity names its static.

mod change;
mod flight;
mod gains;
mod slip;
mod world;
mod parts;

pub use change::{
    PAYLOAD_MASS, PUSH_DURATION, PUSH_FORCE, SEED, SEEK_TIME, SPEED, STEP_TICKS, WIND,
};
pub use gains::{
    ADAPTER_ON, BIAS, BOUNDARY_LAYER, DAMPING_OF_ROTATION, DAMPING_OF_TRANSLATION, FORGETTING,
    HORIZON_MEMORY, INNOVATION_SMOOTHING, LEAD, LEAK, RESET_ON, RESET_SCALE, RESET_THRESHOLD,
    RESIDUAL_BANDWIDTH, RESIDUAL_FILTER_ON, ROBUST_GAIN_CAP, ROBUST_GAIN_INITIAL, SLOPE,
    WEIGHT_LEAK,
};
pub use slip::Slip;

use crate::notation::COORDINATE_NAMES;

/// A number with its unit and range, and the keys and messages that carry it.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// Unique name, `payload_mass`.
    pub name: &'static str,
    /// Unit, empty if none.
    pub unit: &'static str,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Step of a slider; by default a hundredth of the range.
    pub step: f64,
    /// Meaning, in a few words.
    pub help: &'static str,
    /// Keys of a scenario that hold it: dotted, without indices of lists, but with the name of the coordinate where coordinates differ. One
    /// `*` in a segment stands for any characters.
    pub keys: &'static [&'static str],
    /// Further keys that hold it, at which 0 is allowed too and means "none".
    pub keys_or_none: &'static [&'static str],
    /// Messages of a client that carry it: type, kind of a disturbance, field.
    pub messages: &'static [&'static str],
}

/// A value that is not finite or lies outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {found} refused: expected a finite value in {allowed}")]
pub struct OutOfRange {
    /// Name of the quantity or key that was to be set.
    pub name: String,
    /// Refused value.
    pub found: f64,
    /// Range and unit.
    pub allowed: String,
}

impl Quantity {
    /// A quantity that occurs only at `keys` of a scenario.
    const fn new(
        name: &'static str,
        unit: &'static str,
        [min, max]: [f64; 2],
        help: &'static str,
        keys: &'static [&'static str],
    ) -> Self {
        let step = (max - min) / 100.0;
        Self { name, unit, min, max, step, help, keys, keys_or_none: &[], messages: &[] }
    }

    /// Sets the step of its slider.
    const fn step(self, step: f64) -> Self {
        Self { step, ..self }
    }

    /// Allows 0 too at these keys of a scenario.
    const fn or_none_at(self, keys_or_none: &'static [&'static str]) -> Self {
        Self { keys_or_none, ..self }
    }

    /// Adds the messages that carry it.
    const fn sent_as(self, messages: &'static [&'static str]) -> Self {
        Self { messages, ..self }
    }

    /// True if `value` is finite and lies in the range.
    pub fn allows(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }

    /// Checks `value` on behalf of `name`, which the error reports.
    ///
    /// # Errors
    /// [`OutOfRange`] if it is not finite or outside the range.
    pub fn check_as(&self, name: &str, value: f64) -> Result<(), OutOfRange> {
        if self.allows(value) {
            return Ok(());
        }
        Err(OutOfRange { name: name.to_owned(), found: value, allowed: self.range() })
    }

    /// Checks `value`.
    ///
    /// # Errors
    /// [`OutOfRange`] if it is not finite or outside the range.
    pub fn check(&self, value: f64) -> Result<(), OutOfRange> {
        self.check_as(self.name, value)
    }

    /// Range and unit, for people: `0.001..=2 kg`.
    pub fn range(&self) -> String {
        let space = if self.unit.is_empty() { "" } else { " " };
        format!("{}..={}{space}{}", plain(self.min), plain(self.max), self.unit)
    }

    /// The slip of the unit that would explain `value`, if there is one.
    pub fn slip(&self, value: f64) -> Option<Slip> {
        slip::of(self, value)
    }
}

/// The shortest text of a number: `1e-9` rather than ten digits.
fn plain(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A whole number as a double, rounded away from zero: a number beyond the end of a range never rounds to that end.
pub fn whole(value: i128) -> f64 {
    let nearest = value as f64;
    if (nearest as i128).unsigned_abs() >= value.unsigned_abs() {
        nearest
    } else if value > 0 {
        nearest.next_up()
    } else {
        nearest.next_down()
    }
}

/// Every quantity.
pub fn all() -> impl Iterator<Item = &'static Quantity> {
    let named = change::ALL.iter().chain(&gains::ALL).copied();
    named.chain(world::ALL).chain(parts::ALL).chain(flight::ALL)
}

/// The range of the number at a key of a scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The quantity.
    pub quantity: &'static Quantity,
    /// True if 0 is allowed too and means "none".
    pub or_none: bool,
}

impl Bounds {
    /// True if `value` is allowed at this key.
    pub fn allow(&self, value: f64) -> bool {
        (self.or_none && value == 0.0) || self.quantity.allows(value)
    }

    /// What is allowed, for people.
    pub fn words(&self) -> String {
        let none = if self.or_none { "0 or " } else { "" };
        format!("{none}{}", self.quantity.range())
    }
}

/// The bounds of the number at `path` in a scenario, whose segments include indices of lists. If several keys match, the one with the most
/// characters other than `*` counts. `None` if nothing bounds the number.
pub fn at(path: &[String]) -> Option<Bounds> {
    let is_key = |segment: &&String| segment.parse::<usize>().is_err();
    let keys: Vec<&str> = path.iter().filter(is_key).map(String::as_str).collect();
    let row = path.last().and_then(|last| COORDINATE_NAMES.get(last.parse::<usize>().ok()?));
    let of_row = row.and_then(|row| nearest(&[keys.as_slice(), &[*row]].concat()));
    of_row.or_else(|| nearest(&keys))
}

fn nearest(keys: &[&str]) -> Option<Bounds> {
    let fitting = all().flat_map(|quantity| {
        let of = |patterns: &'static [&'static str], or_none| {
            let fitting = patterns.iter().filter(|pattern| fits(pattern, keys));
            fitting.map(move |pattern| (literal(pattern), Bounds { quantity, or_none }))
        };
        of(quantity.keys, false).chain(of(quantity.keys_or_none, true))
    });
    fitting.max_by_key(|(characters, _)| *characters).map(|(_, bounds)| bounds)
}

/// Number of characters of a pattern other than `*`.
fn literal(pattern: &str) -> usize {
    pattern.bytes().filter(|byte| *byte != b'*').count()
}

fn fits(pattern: &str, keys: &[&str]) -> bool {
    let mut segments = pattern.split('.');
    let all = keys.iter().all(|key| segments.next().is_some_and(|segment| fits_one(segment, key)));
    all && segments.next().is_none()
}

fn fits_one(pattern: &str, key: &str) -> bool {
    match pattern.split_once('*') {
        Some((head, tail)) => {
            key.len() >= head.len() + tail.len() && key.starts_with(head) && key.ends_with(tail)
        }
        None => pattern == key,
    }
}

#[cfg(test)]
mod tests;
