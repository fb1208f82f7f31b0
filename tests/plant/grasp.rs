//! Friction holds the cube up to the limit of Coulomb's law.

use nalgebra::Vector3;
use twin_core::tick::{GripperCommand, Truth};

use super::rig::{Rig, RigSettings};

/// Friction coefficient of pads and cube.
const MU: f64 = 0.8;

/// Slip with 5 % more than Coulomb's limit, which is sharp: the elastic give of the contacts …
const HELD_MM: f64 = 0.1;

/// … and with 5 % less, when the cube falls at 5 % of g: 980 mm in 2 s, far beyond the 20 mm at which it leaves the pads.
const LOST_MM: f64 = 20.0;

/// Share of the force by which the contact solver is off at 4 iterations.
const PRESS_TOLERANCE: f64 = 0.02;

/// Time in which the fingers build up their force, ticks of 10 ms.
const SETTLE: usize = 20;

fn slip_mm(truths: &[Truth]) -> f64 {
    let start = truths[SETTLE].payload_in_palm;
    truths[SETTLE..]
        .iter()
        .map(|truth| (truth.payload_in_palm - start).norm() * 1e3)
        .fold(0.0, f64::max)
}

fn held(cube_kg: f64, grip_n: f64) -> Vec<Truth> {
    let settings = RigSettings { cube_kg, cube_off_centre_m: 0.0, grip_n, locked_arm: true };
    Rig::new(&settings).run(220, GripperCommand::Close)
}

#[test]
fn a_cube_is_held_just_above_coulombs_limit_and_lost_just_below() {
    for cube_kg in [0.3, 0.4, 0.5] {
        // Two pads carry the weight: 2 mu F = m g.
        let limit_n = cube_kg * super::oracle::GRAVITY_M_S2 / (2.0 * MU);
        let above = slip_mm(&held(cube_kg, 1.05 * limit_n));
        assert!(above < HELD_MM, "{cube_kg} kg slipped {above:.3} mm at 1.05 of the limit");
        let below = slip_mm(&held(cube_kg, 0.95 * limit_n));
        assert!(below > LOST_MM, "{cube_kg} kg moved only {below:.3} mm at 0.95 of the limit");
    }
}

#[test]
fn each_pad_presses_with_the_force_asked_and_no_more() {
    for grip_n in [5.0, 20.0] {
        let truths = held(0.3, grip_n);
        for truth in &truths[SETTLE..] {
            let forces =
                truth.contacts.iter().map(|contact| Vector3::from(contact.force_in_world_n).norm());
            let (shown_n, summed_n) = (forces.sum::<f64>(), truth.grip_force_n);
            for found_n in [shown_n, summed_n] {
                assert!(
                    (found_n - 2.0 * grip_n).abs() < PRESS_TOLERANCE * grip_n,
                    "{found_n:.2} N of 2 x {grip_n} N"
                );
            }
        }
    }
}
