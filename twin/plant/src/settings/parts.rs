//! Parts of the vehicle in a scenario: battery, servos, links, and how far the true vehicle may be from the assumed one.

use serde::{Deserialize, Serialize};

/// How far the true vehicle may be from what the loop assumes. Each value is a standard deviation relative to the assumed value; the
/// seed of the flight decides the true values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MismatchSettings {
    /// Whether the vehicle differs.
    pub on: bool,
    /// Thrust of each rotor at a given speed.
    pub rotor_thrust: f64,
    /// Time constants of each rotor.
    pub rotor_lag: f64,
    /// Torque of each joint at a given command.
    pub joint_torque: f64,
}

/// The battery: open-circuit voltage by Chen and Rincón-Mora (2006), a resistance, and one slow polarisation. Speed controllers without
/// feedback turn the rotors in proportion to the voltage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BatterySettings {
    /// Whether the voltage of the battery changes the speed of the rotors, and whether the current limit holds.
    pub on: bool,
    /// Cells in series.
    pub cells: f64,
    /// Charge of the full battery, A h.
    pub capacity_a_h: f64,
    /// Charge at the start of a flight, as a share of the capacity.
    pub charge: f64,
    /// Resistance to a change of the current, ohm.
    pub resistance_ohm: f64,
    /// Further resistance to a lasting current, ohm.
    pub polarisation_ohm: f64,
    /// Time constant with which the further resistance appears, s.
    pub polarisation_s: f64,
    /// Voltage at which the rotors turn as commanded, V.
    pub reference_v: f64,
    /// Mechanical power of a rotor per electrical power.
    pub efficiency: f64,
    /// Largest current of the speed controller of one rotor, A.
    pub rotor_current_a: f64,
}

/// Servos of the arm's joints: friction, and what current and voltage allow. Viscous damping and Coulomb friction are in the URDF.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ServoSettings {
    /// Whether static friction, limits and the servo's own rate have an effect.
    pub on: bool,
    /// Rate at which a servo takes a command, Hz.
    pub command_hz: f64,
    /// Largest torque at standstill, N m.
    pub stall_n_m: f64,
    /// Speed at which the torque is zero, rad/s.
    pub free_rad_s: f64,
    /// Friction at standstill per Coulomb friction.
    pub stiction: f64,
    /// Speed at which friction has fallen to Coulomb friction, rad/s (Stribeck).
    pub stribeck_rad_s: f64,
}

/// A link whose packets are late by a random time and may be lost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkSettings {
    /// Whether packets are late and lost.
    pub on: bool,
    /// Mean of the exponentially distributed time by which a packet is late, s.
    pub jitter_s: f64,
    /// Probability that a packet is lost.
    pub loss: f64,
}
