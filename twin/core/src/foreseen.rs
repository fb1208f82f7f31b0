//! The record of what the loop foresees: the residual at the time at which the force that answers it acts.

use serde::{Deserialize, Serialize};

use crate::notation::{Coords, KnownCoords};

/// The residual at the loop's delay. A force that is asked for now acts only after the delay `d`, so the controller compensates the
/// residual that is forecast for then, `r_hat(t + d | t)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Foreseen {
    /// Lead `d` per coordinate, s.
    pub lead_s: Coords,
    /// Forecast for the end of the lead, N and N m. It is known where the residual is known, and so are the following fields.
    pub r_hat: KnownCoords,
    /// Trust in that forecast, from 0 (the controller compensates the estimate of now) to 1 (it compensates the forecast).
    pub trust: Coords,
    /// The estimate that the controller compensates before its limits, N and N m: between the estimate of now and the forecast.
    pub used: KnownCoords,
    /// Measured residual of this tick less the forecast that was made for it one lead ago, N and N m.
    pub error: KnownCoords,
    /// Predictive standard deviation at the end of the lead, N and N m: 1.645 of it hold 90 % of the errors so far.
    pub std: KnownCoords,
    /// The same for the estimate of a tick before its residual is measured, N and N m.
    pub std_now: KnownCoords,
}
