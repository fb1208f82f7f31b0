//! The measured residual: the label of learning and the target of adaptation.

use crate::notation::{Coords, KnownCoords};
use crate::tick::Measurement;

/// `r = H[tau_applied] - M_bar H[chi_ddot]` (`eq:residual_dynamics`), N and N m. Both terms went through the same filter `H`
/// in the source; any mismatch there turns into a phantom force. Unknown where either is, and on the ground.
pub fn residual(measurement: &Measurement, nominal_inertia: &Coords) -> KnownCoords {
    let r = *measurement.tau_applied - nominal_inertia.component_mul(&measurement.chi_ddot);
    KnownCoords::from(r).only(measurement.residual_known())
}
