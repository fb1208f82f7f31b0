//! The gains of the normalised torques of a flight.

use serde::Serialize;

use super::torque_fit::TorqueAxis;

/// The gains of a flight's normalised torques, and the inertia that converts them to N m.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Torque {
    /// Inertia about the body axes in use, kg m².
    pub inertia_kg_m2: [f64; 3],
    /// True if the inertia is unknown; torques are then per kg m².
    pub per_inertia: bool,
    /// Gains about roll, pitch and yaw.
    pub axes: [TorqueAxis; 3],
}

/// Names of the axes in sentences: the names of their coordinates.
const AXES: [&str; 3] = ["phi", "theta", "psi"];

impl Torque {
    /// Gains that are unknown about every axis, for the reason `why`.
    pub(super) fn unknown(inertia_kg_m2: Option<[f64; 3]>, why: &str) -> Self {
        let axis = || TorqueAxis::Unknown { why: why.to_owned() };
        Self {
            inertia_kg_m2: inertia_kg_m2.unwrap_or([1.0; 3]),
            per_inertia: inertia_kg_m2.is_none(),
            axes: [axis(), axis(), axis()],
        }
    }

    /// Per axis whether its gain is known.
    pub fn known(&self) -> [bool; 3] {
        std::array::from_fn(|axis| matches!(self.axes[axis], TorqueAxis::Fitted(_)))
    }

    /// Gains, uncertainty and unknown axes in words.
    pub fn sentence(&self) -> String {
        if let [TorqueAxis::Unknown { why }, second, third] = &self.axes
            && [second, third].iter().all(|axis| **axis == self.axes[0])
        {
            return format!("no torque is known: {why}");
        }
        let axis = |(name, axis): (&&str, &TorqueAxis)| match axis {
            TorqueAxis::Fitted(fit) => format!("{name} {}", fit.sentence()),
            TorqueAxis::Unknown { why } => format!("{name} unknown, {why}"),
        };
        let axes: Vec<String> = AXES.iter().zip(&self.axes).map(axis).collect();
        let unit = if self.per_inertia {
            "; the inertia is unknown: torques are per kg m2".to_owned()
        } else {
            let [x, y, z] = self.inertia_kg_m2;
            format!("; inertia in use {x:.4}, {y:.4}, {z:.4} kg m2")
        };
        format!("torque from TorqueSetpoint: {}{unit}", axes.join("; "))
    }
}
