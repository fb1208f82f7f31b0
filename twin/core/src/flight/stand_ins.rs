//! The numbers that stand for unknown values in the loop: predictors and control laws need a number in every coordinate.
//!
//! No stand-in is measured, so none appears in a tick: estimates, error and sliding variable are unknown there. Where everything is known,
//! the loop uses the measured values bit for bit. State: the last known value of each coordinate.

use crate::notation::{Coords, KnownCoords, KnownMask, known_in_both};
use crate::tick::{ControlState, Measurement, Reference};

/// Replaces unknown coordinates by their last known values.
#[derive(Clone, Debug)]
pub(super) struct StandIns {
    last_chi: Coords,
}

/// A tick as predictors remember it, with a number in every coordinate.
pub(super) struct Remembered {
    pub(super) chi_dot: Coords,
    pub(super) tau: Coords,
    pub(super) residual: Coords,
}

impl StandIns {
    /// Before a coordinate was known for the first time, zero stands for it.
    pub(super) fn new() -> Self {
        Self { last_chi: Coords::zeros() }
    }

    /// Coordinates for models and predictors: the last known value stands for an unknown one.
    pub(super) fn coordinates(&mut self, chi: &KnownCoords) -> Coords {
        self.last_chi = chi.or(&self.last_chi);
        self.last_chi
    }
}

/// Rates, force and residual for predictors. Zero stands for an unknown rate and the nominal residual for an unknown residual; an unknown
/// force gets the value that gives the nominal residual.
pub(super) fn remembered(
    measurement: &Measurement,
    residual: &KnownCoords,
    nominal_residual: &Coords,
    nominal_inertia: &Coords,
) -> Remembered {
    let chi_ddot = measurement.chi_ddot.or(&Coords::zeros());
    let nominal_force = nominal_residual + nominal_inertia.component_mul(&chi_ddot);
    Remembered {
        chi_dot: measurement.chi_dot.or(&Coords::zeros()),
        tau: measurement.tau_applied.or(&nominal_force),
        residual: residual.or(nominal_residual),
    }
}

/// Measurement and reference for a control law, which must see no error in a coordinate unless it is both measured and desired. Otherwise
/// measurement and reference both get the desired value, or the measured value if none is desired, or zero. Zero stands for an unknown
/// acceleration and the nominal residual for an unknown force.
pub(super) fn for_control(
    measurement: &Measurement,
    reference: &Reference,
    nominal_residual: &Coords,
) -> (Measurement, Reference) {
    let (chi, chi_des) = without_error(&measurement.chi, &reference.chi_des);
    let (chi_dot, chi_des_dot) = without_error(&measurement.chi_dot, &reference.chi_des_dot);
    let measurement = Measurement {
        chi,
        chi_dot,
        chi_ddot: measurement.chi_ddot.or(&Coords::zeros()).into(),
        tau_applied: measurement.tau_applied.or(nominal_residual).into(),
        ..measurement.clone()
    };
    (measurement, Reference { chi_des, chi_des_dot, ..*reference })
}

fn without_error(measured: &KnownCoords, asked: &KnownCoords) -> (KnownCoords, KnownCoords) {
    let known = known_in_both(measured.known(), asked.known());
    let place = asked.or(&measured.or(&Coords::zeros()));
    (measured.only(known).or(&place).into(), asked.only(known).or(&place).into())
}

/// Error and sliding variable of the control law, known only where measurement and reference both are known.
pub(super) fn as_known(
    control: ControlState,
    measurement: &Measurement,
    reference: &Reference,
) -> ControlState {
    let both = |measured: &KnownCoords, asked: &KnownCoords| -> KnownMask {
        known_in_both(measured.known(), asked.known())
    };
    let error = both(&measurement.chi, &reference.chi_des);
    let rate = both(&measurement.chi_dot, &reference.chi_des_dot);
    ControlState {
        error: control.error.only(error),
        sliding: control.sliding.only(known_in_both(error, rate)),
        ..control
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notation::N;
    use crate::tick::{Adaptation, GripperCommand, GripperReading};

    fn measurement(chi: KnownCoords) -> Measurement {
        Measurement {
            t_s: 0.0,
            chi,
            chi_dot: Coords::repeat(0.1).into(),
            chi_ddot: Coords::repeat(0.2).into(),
            tau_applied: Coords::repeat(0.3).into(),
            gripper: GripperReading::default(),
            payload: None,
            saturated: false,
            airborne: true,
        }
    }

    fn reference(chi_des: KnownCoords) -> Reference {
        Reference {
            chi_des,
            chi_des_dot: Coords::zeros().into(),
            chi_des_ddot: Coords::zeros(),
            gripper: GripperCommand::Open,
            adaptation: Adaptation::Free,
            follows_measurement: false,
            transporting: false,
            cruising: false,
            release: None,
        }
    }

    fn without(row: usize, value: f64) -> KnownCoords {
        KnownCoords::from(Coords::repeat(value)).only(std::array::from_fn(|other| other != row))
    }

    #[test]
    fn where_everything_is_known_control_sees_what_was_measured_and_asked_for() {
        let chi = KnownCoords::from(Coords::from_fn(|row, _| 0.1 * row as f64));
        let (measured, asked) = (measurement(chi), reference(Coords::repeat(0.7).into()));
        assert_eq!(for_control(&measured, &asked, &Coords::zeros()), (measured, asked));
    }

    #[test]
    fn a_row_that_is_not_both_measured_and_asked_for_has_no_error_and_all_rows_are_numbers() {
        let (measured, asked) = (measurement(without(2, 1.0)), reference(without(5, 0.4)));
        let (measured, asked) = for_control(&measured, &asked, &Coords::zeros());
        assert!(measured.chi.known() == [true; N] && asked.chi_des.known() == [true; N]);
        let error = *measured.chi - *asked.chi_des;
        for row in 0..N {
            // Tolerance for one subtraction of numbers below one.
            let wanted = if row == 2 || row == 5 { 0.0 } else { 0.6 };
            assert!((error[row] - wanted).abs() < 1e-12, "{row} {error}");
        }
    }

    #[test]
    fn predictors_see_the_last_known_coordinate_and_the_force_that_leaves_the_nominal_residual() {
        let mut stand_ins = StandIns::new();
        assert_eq!(stand_ins.coordinates(&without(1, 2.0))[1].to_bits(), 0.0_f64.to_bits());
        stand_ins.coordinates(&Coords::repeat(3.0).into());
        let chi = stand_ins.coordinates(&without(1, 4.0));
        assert_eq!([chi[0], chi[1]].map(f64::to_bits), [4.0, 3.0].map(f64::to_bits));
        let (nominal, inertia) = (Coords::repeat(9.0), Coords::repeat(2.0));
        let pushed = Measurement { tau_applied: without(3, 0.3), ..measurement(chi.into()) };
        let seen = remembered(&pushed, &without(3, 5.0), &nominal, &inertia);
        assert_eq!(seen.residual[3].to_bits(), 9.0_f64.to_bits());
        let left = seen.tau[3] - inertia[3] * pushed.chi_ddot[3];
        assert!((left - 9.0).abs() < 1e-12, "{left}");
    }
}
