//! Settings of the standard vehicle, for the unit tests of this crate.

use super::mismatch::{Mismatch, Ratios};
use super::settings::{AeroSettings, MismatchSettings, RotorPlace, RotorSettings};

/// Rotors of the standard vehicle.
pub(crate) const ROTOR: RotorSettings = RotorSettings {
    radius_m: 0.178,
    min_thrust_n: 0.3,
    max_thrust_n: 15.0,
    torque_ratio_m: 0.018,
    thrust_coefficient_n_s2: 4.3e-5,
    lag_s: 0.04,
    fall_lag_s: 0.04,
    delay_s: 0.005,
    thrust_scale: 0.97,
    modelled_lag_s: 0.04,
    blade_area_m2: 0.0107,
    lift_slope_per_rad: 5.5,
    flap_stiffness_n_m_rad: 2.6,
};

/// Air in which every effect is off.
pub(crate) const AERO: AeroSettings = AeroSettings {
    inflow: false,
    flapping: false,
    rotor_drag: false,
    rotor_drag_n_s_m: [0.25, 0.25, 0.0],
    body_drag: false,
    body_drag_n_s2_m2: 0.06,
    ground_effect: false,
    ground_effect_radius_m: 0.178,
    fountain: 2.0,
    ground_settling_s: 0.1,
    recirculation: false,
    recirculation_m_s: 0.5,
    downwash: false,
    wake_s: 0.3,
    link_drag_area_m2: 0.006,
    unsteady: false,
    turbulence_n: 0.25,
    turbulence_n_m: 0.015,
    turbulence_s: 0.3,
};

/// Four rotors in X.
pub(crate) fn quad() -> Vec<RotorPlace> {
    [(1.0, 1.0, 1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0), (1.0, -1.0, -1.0)]
        .map(|(x, y, spin)| RotorPlace { position_m: [0.23 * x, 0.23 * y, 0.0], spin })
        .to_vec()
}

/// A vehicle that is as the loop assumes.
pub(crate) fn ratios() -> Ratios {
    let same = MismatchSettings { on: false, rotor_thrust: 0.0, rotor_lag: 0.0, joint_torque: 0.0 };
    Mismatch::new(&same, 1).ratios()
}
