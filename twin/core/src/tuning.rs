//! The values in force of a flight, and the one registry that names, bounds and describes each of them.
//!
//! Every slider of every client, every `gains.*` key of a scenario and every recorded gain event goes through
//! [`Tuning::set`], so there is one place that decides what is allowed.

use serde::{Deserialize, Serialize};

use crate::control::Gains;
use crate::notation::ROWS;
use crate::residual::lra;

/// The values in force; changed between ticks only.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// Control law.
    pub gains: Gains,
    /// Latent Residual Adapter.
    pub adapter: lra::Settings,
}

/// One value an operator may change.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Stable name, `slope.x`.
    pub name: String,
    /// Group it is shown under.
    pub group: &'static str,
    /// Symbol as in the paper, `Φ x`.
    pub label: String,
    /// Unit, empty if none.
    pub unit: &'static str,
    /// What it does, one sentence.
    pub help: &'static str,
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Step of a slider.
    pub step: f64,
}

/// Why a change was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TuningError {
    /// No parameter has this name.
    #[error("no gain is called {name:?}; allowed: {allowed}")]
    UnknownName {
        /// What was asked for.
        name: String,
        /// What exists.
        allowed: String,
    },
    /// The value is NaN, infinite or outside its range.
    #[error("{name} = {found} refused: expected a finite value in {min}..={max} {unit}")]
    OutOfRange {
        /// Parameter.
        name: String,
        /// What was asked for.
        found: f64,
        /// Smallest allowed value.
        min: f64,
        /// Largest allowed value.
        max: f64,
        /// Unit.
        unit: &'static str,
    },
}

/// Scalar parameters: name, group, label, unit, help, min, max, step.
type Row = (&'static str, &'static str, &'static str, &'static str, &'static str, f64, f64, f64);

const SCALARS: [Row; 12] = [
    ("leak", "Robust term", "ν", "1/s", "leak of the adaptive gain σ̂", 0.1, 20.0, 0.05),
    (
        "robust_gain_initial",
        "Robust term",
        "σ̂(0)",
        "",
        "adaptive gain at the start; a change sets σ̂ now",
        0.001,
        10.0,
        0.01,
    ),
    ("robust_gain_cap", "Robust term", "σ̂ cap", "", "largest adaptive gain", 0.05, 1e6, 0.05),
    (
        "boundary_layer",
        "Robust term",
        "boundary layer",
        "",
        "‖s‖ below which the robust term is linear",
        1e-6,
        5.0,
        0.01,
    ),
    (
        "residual_bandwidth_hz",
        "Adapter",
        "r̂ low-pass",
        "Hz",
        "corner of the low-pass on r̂",
        0.1,
        50.0,
        0.1,
    ),
    (
        "residual_filter_on",
        "Adapter",
        "r̂ filter",
        "",
        "1: r̂ passes the low-pass, 0: r̂ is taken as it is",
        0.0,
        1.0,
        1.0,
    ),
    ("forgetting", "Adapter", "λ", "", "forgetting factor of the RLS step", 0.9, 1.0, 0.0005),
    ("reset_scale", "Adapter", "σ₀", "", "covariance after a reset is σ₀ I", 0.001, 100.0, 0.01),
    (
        "reset_threshold",
        "Adapter",
        "δ",
        "",
        "mean innovation at which the covariance is reset",
        0.01,
        1000.0,
        0.01,
    ),
    (
        "innovation_smoothing",
        "Adapter",
        "α",
        "",
        "weight of the old value in the mean innovation",
        0.0,
        0.999,
        0.001,
    ),
    ("reset_on", "Adapter", "reset", "", "1: the covariance may be reset, 0: never", 0.0, 1.0, 1.0),
    ("adapter_on", "Adapter", "LRA", "", "1: adapts, 0: base forecast only", 0.0, 1.0, 1.0),
];

impl Tuning {
    /// Every value an operator may change, in the order it is shown.
    pub fn parameters() -> Vec<Parameter> {
        let rows = |stem: &'static str,
                    group: &'static str,
                    letter: &str,
                    max: f64,
                    help: &'static str| {
            ROWS.iter()
                .map(|row| Parameter {
                    name: format!("{stem}.{row}"),
                    group,
                    label: format!("{letter} {}", symbol(row)),
                    unit: if stem == "slope" { "1/s" } else { "" },
                    help,
                    min: 0.0,
                    max,
                    step: 0.05,
                })
                .collect::<Vec<_>>()
        };
        let mut all = rows("slope", "Φ error slope", "Φ", 20.0, "pull of the error in s = ė + Φe");
        all.extend(rows("damping", "Λ damping", "Λ", 60.0, "force per sliding variable"));
        all.extend(SCALARS.iter().map(|&(name, group, label, unit, help, min, max, step)| {
            Parameter {
                name: name.to_owned(),
                group,
                label: label.to_owned(),
                unit,
                help,
                min,
                max,
                step,
            }
        }));
        all
    }

    /// The value in force of `name`; `None` if there is no such parameter.
    pub fn get(&self, name: &str) -> Option<f64> {
        let mut copy = *self;
        copy.slot(name).map(|slot| slot.read())
    }

    /// Sets `name` to `value` after checking both.
    ///
    /// # Errors
    /// [`TuningError`] for an unknown name and for a value that is not finite or out of range; nothing is changed then.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), TuningError> {
        let parameters = Self::parameters();
        let Some(parameter) = parameters.iter().find(|p| p.name == name) else {
            let allowed = parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(TuningError::UnknownName {
                name: name.chars().take(64).collect(),
                allowed,
            });
        };
        if !(value.is_finite() && value >= parameter.min && value <= parameter.max) {
            return Err(TuningError::OutOfRange {
                name: name.to_owned(),
                found: value,
                min: parameter.min,
                max: parameter.max,
                unit: parameter.unit,
            });
        }
        if let Some(slot) = self.slot(name) {
            slot.write(value);
        }
        Ok(())
    }

    fn slot(&mut self, name: &str) -> Option<Slot<'_>> {
        let (gains, adapter) = (&mut self.gains, &mut self.adapter);
        let number = match name.split_once('.') {
            Some((stem, row)) => {
                let i = ROWS.iter().position(|r| *r == row)?;
                match stem {
                    "slope" => &mut gains.slope[i],
                    "damping" => &mut gains.damping[i],
                    _ => return None,
                }
            }
            None => match name {
                "leak" => &mut gains.leak,
                "robust_gain_initial" => &mut gains.robust_gain_initial,
                "robust_gain_cap" => &mut gains.robust_gain_cap,
                "boundary_layer" => &mut gains.boundary_layer,
                "residual_bandwidth_hz" => &mut gains.residual_bandwidth_hz,
                "forgetting" => &mut adapter.forgetting,
                "reset_scale" => &mut adapter.reset_scale,
                "reset_threshold" => &mut adapter.reset_threshold,
                "innovation_smoothing" => &mut adapter.innovation_smoothing,
                "residual_filter_on" => {
                    return Some(Slot::Switch(&mut gains.residual_filter_on));
                }
                "reset_on" => return Some(Slot::Switch(&mut adapter.reset_enabled)),
                "adapter_on" => return Some(Slot::Switch(&mut adapter.enabled)),
                _ => return None,
            },
        };
        Some(Slot::Number(number))
    }
}

/// A place in [`Tuning`] that a named value lives in.
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
            assert!(now >= parameter.min && now <= parameter.max, "{}: {now}", parameter.name);
            for value in [parameter.min, parameter.max] {
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
