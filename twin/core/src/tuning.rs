//! The values in force of a flight: which field holds each gain of the registry, and how a gain is read and set.
//!
//! Every slider of a client, every `gains.*` key of a scenario and every recorded gain event calls [`Tuning::set`], so one function decides
//! which values are allowed.

use serde::{Deserialize, Serialize};

use crate::control::Gains;
use crate::notation::COORDINATE_NAMES;
use crate::quantity::{self, OutOfRange, Quantity};
use crate::residual::lra;

/// The values in force; changed between ticks only.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// Control law.
    pub gains: Gains,
    /// Latent Residual Adapter.
    pub adapter: lra::Settings,
}

/// One gain that an operator may change.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Stable name, `slope.x`.
    pub name: String,
    /// Group in which it is shown.
    pub group: &'static str,
    /// Symbol as in the paper, `Φ x`.
    pub label: String,
    /// Unit, range and help.
    pub quantity: &'static Quantity,
}

/// Why a change was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TuningError {
    /// No parameter has this name.
    #[error("no gain is called {name:?}; allowed: {allowed}")]
    UnknownName {
        /// Name that was given.
        name: String,
        /// Existing names.
        allowed: String,
    },
    /// The value is NaN, infinite or outside its range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
}

/// A gain that is a single number, named like its quantity.
struct Scalar {
    quantity: &'static Quantity,
    group: &'static str,
    label: &'static str,
    slot: fn(&mut Tuning) -> Slot<'_>,
}

const fn scalar(
    quantity: &'static Quantity,
    group: &'static str,
    label: &'static str,
    slot: fn(&mut Tuning) -> Slot<'_>,
) -> Scalar {
    Scalar { quantity, group, label, slot }
}

const ROBUST: &str = "Robust term";
const ADAPTER: &str = "Adapter";

/// The single gains in the order of display.
static SCALARS: [Scalar; 15] = [
    scalar(&quantity::LEAK, ROBUST, "ν", |t| Slot::Number(&mut t.gains.leak)),
    scalar(&quantity::ROBUST_GAIN_INITIAL, ROBUST, "σ̂(0)", |t| {
        Slot::Number(&mut t.gains.robust_gain_initial)
    }),
    scalar(&quantity::ROBUST_GAIN_CAP, ROBUST, "σ̂ cap", |t| {
        Slot::Number(&mut t.gains.robust_gain_cap)
    }),
    scalar(&quantity::BOUNDARY_LAYER, ROBUST, "boundary layer", |t| {
        Slot::Number(&mut t.gains.boundary_layer)
    }),
    scalar(&quantity::RESIDUAL_BANDWIDTH, ADAPTER, "r̂ low-pass", |t| {
        Slot::Number(&mut t.gains.residual_bandwidth_hz)
    }),
    scalar(&quantity::RESIDUAL_FILTER_ON, ADAPTER, "r̂ filter", |t| {
        Slot::Switch(&mut t.gains.residual_filter_on)
    }),
    scalar(&quantity::FORGETTING, ADAPTER, "λ", |t| Slot::Number(&mut t.adapter.forgetting)),
    scalar(&quantity::BIAS, ADAPTER, "bias", |t| Slot::Number(&mut t.adapter.bias_s)),
    scalar(&quantity::WEIGHT_LEAK, ADAPTER, "leak of W", |t| {
        Slot::Number(&mut t.adapter.weight_leak_per_s)
    }),
    scalar(&quantity::HORIZON_MEMORY, ADAPTER, "memory of horizon", |t| {
        Slot::Number(&mut t.adapter.horizon_memory_s)
    }),
    scalar(&quantity::RESET_SCALE, ADAPTER, "σ₀", |t| Slot::Number(&mut t.adapter.reset_scale)),
    scalar(&quantity::RESET_THRESHOLD, ADAPTER, "δ", |t| {
        Slot::Number(&mut t.adapter.reset_threshold)
    }),
    scalar(&quantity::INNOVATION_SMOOTHING, ADAPTER, "α", |t| {
        Slot::Number(&mut t.adapter.innovation_smoothing)
    }),
    scalar(&quantity::RESET_ON, ADAPTER, "reset", |t| Slot::Switch(&mut t.adapter.reset_enabled)),
    scalar(&quantity::ADAPTER_ON, ADAPTER, "LRA", |t| Slot::Switch(&mut t.adapter.enabled)),
];

impl Tuning {
    /// Every gain that an operator may change, in the order of display.
    pub fn parameters() -> Vec<Parameter> {
        let rows = |stem: &'static str, group: &'static str, letter: &'static str| {
            COORDINATE_NAMES.iter().enumerate().map(move |(index, row)| Parameter {
                name: format!("{stem}.{row}"),
                group,
                label: format!("{letter} {}", symbol(row)),
                quantity: match (stem, index) {
                    ("slope", _) => &quantity::SLOPE,
                    ("lead", _) => &quantity::LEAD,
                    (_, 0..3) => &quantity::DAMPING_OF_TRANSLATION,
                    _ => &quantity::DAMPING_OF_ROTATION,
                },
            })
        };
        let scalars = SCALARS.iter().map(|scalar| Parameter {
            name: scalar.quantity.name.to_owned(),
            group: scalar.group,
            label: scalar.label.to_owned(),
            quantity: scalar.quantity,
        });
        rows("slope", "Φ error slope", "Φ")
            .chain(rows("damping", "Λ damping", "Λ"))
            .chain(rows("lead", "Lead of r̂", "d"))
            .chain(scalars)
            .collect()
    }

    /// The value in force of `name`; `None` if there is no such parameter.
    pub fn get(&self, name: &str) -> Option<f64> {
        let mut copy = *self;
        copy.slot(name).map(|slot| slot.read())
    }

    /// Sets `name` to `value` after checking both.
    ///
    /// # Errors
    /// [`TuningError`] for an unknown name and for a value that is not finite or out of range; then nothing is changed.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), TuningError> {
        let parameters = Self::parameters();
        let Some(parameter) = parameters.iter().find(|p| p.name == name) else {
            let allowed = parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(TuningError::UnknownName {
                name: name.chars().take(64).collect(),
                allowed,
            });
        };
        parameter.quantity.check_as(name, value)?;
        if let Some(slot) = self.slot(name) {
            slot.write(value);
        }
        Ok(())
    }

    fn slot(&mut self, name: &str) -> Option<Slot<'_>> {
        let Some((stem, row)) = name.split_once('.') else {
            let scalar = SCALARS.iter().find(|scalar| scalar.quantity.name == name)?;
            return Some((scalar.slot)(self));
        };
        let row = COORDINATE_NAMES.iter().position(|known| *known == row)?;
        match stem {
            "slope" => Some(Slot::Number(&mut self.gains.slope[row])),
            "lead" => Some(Slot::Number(&mut self.gains.lead[row])),
            "damping" => Some(Slot::Number(&mut self.gains.damping[row])),
            _ => None,
        }
    }
}

/// Field of [`Tuning`] that a named gain sets.
enum Slot<'a> {
    Number(&'a mut f64),
    Switch(&'a mut bool),
}

impl Slot<'_> {
    fn read(&self) -> f64 {
        match self {
            Slot::Number(number) => **number,
            Slot::Switch(on) => f64::from(u8::from(**on)),
        }
    }

    fn write(self, value: f64) {
        match self {
            Slot::Number(number) => *number = value,
            Slot::Switch(on) => *on = value >= 0.5,
        }
    }
}

fn symbol(row: &str) -> &str {
    match row {
        "phi" => "φ",
        "theta" => "θ",
        "psi" => "ψ",
        "q1" => "q₁",
        "q2" => "q₂",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Preset;

    fn tuning() -> Tuning {
        Tuning { gains: Gains::preset(Preset::Tuned), adapter: lra::Settings::default() }
    }

    #[test]
    fn every_listed_parameter_can_be_read_set_and_is_inside_its_own_range() {
        for parameter in Tuning::parameters() {
            let mut t = tuning();
            let now = t.get(&parameter.name).expect(&parameter.name);
            let Quantity { min, max, .. } = *parameter.quantity;
            assert!(now >= min && now <= max, "{}: {now}", parameter.name);
            for value in [min, max] {
                t.set(&parameter.name, value).expect(&parameter.name);
                assert_eq!(t.get(&parameter.name), Some(value), "{}", parameter.name);
            }
        }
    }

    #[test]
    fn unusable_values_are_refused_and_change_nothing() {
        let mut t = tuning();
        for value in [f64::NAN, f64::INFINITY, -1.0, 1e9] {
            assert!(t.set("slope.x", value).is_err());
        }
        assert!(matches!(t.set("slope.w", 1.0), Err(TuningError::UnknownName { .. })));
        assert!(matches!(t.set("", 1.0), Err(TuningError::UnknownName { .. })));
        assert_eq!(t, tuning());
    }
}
