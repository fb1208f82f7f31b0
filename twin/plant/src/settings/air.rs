//! The air in a scenario: aerodynamic effects and wind.

use serde::{Deserialize, Serialize};

/// Aerodynamic effects, each with its own switch.
#[expect(clippy::struct_excessive_bools, reason = "independent effects, each with its switch")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AeroSettings {
    /// Thrust and torque depend on the air that flows through the rotors.
    pub inflow: bool,
    /// The rotor discs tilt in a cross flow and turn the vehicle.
    pub flapping: bool,
    /// Force of the rotors in their own plane (H-force), proportional to thrust and air speed.
    pub rotor_drag: bool,
    /// Force of all rotors at 30 N of thrust along x, y and z, N s/m.
    pub rotor_drag_n_s_m: [f64; 3],
    /// Quadratic drag of the body.
    pub body_drag: bool,
    /// Body drag, N s²/m².
    pub body_drag_n_s2_m2: f64,
    /// Increase of thrust near floor, box and table.
    pub ground_effect: bool,
    /// Radius of the rotors in the ground effect, m.
    pub ground_effect_radius_m: f64,
    /// Lift on the body by the flow that rises between the rotors near the ground, as a multiple of the effect of one image rotor.
    pub fountain: f64,
    /// Time constant with which the ground effect follows the height, s.
    pub ground_settling_s: f64,
    /// Rotors near floor, box and table take in a part of their own wake.
    pub recirculation: bool,
    /// Standard deviation of the velocity of that air one radius above a surface, m/s.
    pub recirculation_m_s: f64,
    /// Wake of the rotors on arm and payload.
    pub downwash: bool,
    /// Time constant with which the wake builds up, s.
    pub wake_s: f64,
    /// Drag area of each arm link in wake and wind, m².
    pub link_drag_area_m2: f64,
    /// The flow around the vehicle is unsteady.
    pub unsteady: bool,
    /// Unsteady force of the vehicle's own flow, standard deviation, N.
    pub turbulence_n: f64,
    /// Unsteady moment, standard deviation, N m.
    pub turbulence_n_m: f64,
    /// Correlation time of the unsteady force and moment, s.
    pub turbulence_s: f64,
}

/// Wind model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WindKind {
    /// The mean velocity.
    Constant,
    /// Mean plus a 1-cos gust of `gust_m_s` lasting `gust_s` every `gust_period_s`. Its front passes over the vehicle.
    Gust,
    /// Mean plus Dryden turbulence of `turbulence_m_s` and `scale_m` along every axis.
    Dryden,
    /// Mean plus Dryden turbulence whose strength and scale follow from mean and altitude (MIL-F-8785C, low altitude).
    DrydenAltitude,
}

/// Wind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindSettings {
    /// Whether the wind has an effect.
    pub on: bool,
    /// Model.
    pub kind: WindKind,
    /// Mean velocity in the world, m/s.
    pub velocity_m_s: [f64; 3],
    /// Peak of a gust along the mean (or x if there is no mean), m/s.
    pub gust_m_s: f64,
    /// Duration of a gust, s.
    pub gust_s: f64,
    /// Time between gusts, s.
    pub gust_period_s: f64,
    /// Standard deviation of the Dryden turbulence, m/s; with `dryden` alone.
    pub turbulence_m_s: f64,
    /// Scale length of the Dryden turbulence, m; with `dryden` alone.
    pub scale_m: f64,
}
