//! The measured residual: the label of learning and the target of adaptation.

use crate::notation::{Coords, KnownCoords};
use crate::tick::Measurement;

/// `r = H[tau_applied] - M_bar H[chi_ddot]` (`eq:residual_dynamics`), N and N m. The source passes both terms through the same filter `H`;
/// a mismatch of the filters would appear as a false force. Unknown where one of the terms is unknown, and on the ground.
pub fn residual(measurement: &Measurement, nominal_inertia: &Coords) -> KnownCoords {
    let r = *measurement.tau_applied - nominal_inertia.component_mul(&measurement.chi_ddot);
    KnownCoords::from(r).only(measurement.residual_known())
}
