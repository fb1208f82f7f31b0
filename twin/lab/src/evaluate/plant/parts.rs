//! Parts of the vehicle: battery, servos, and the arm that swings out.

use super::{Point, Section, picture, published, range, twin};
use crate::evaluate::series::EvaluateError;
use nalgebra::{Vector2, Vector3};
use twin_core::elementary::{exp, powf, squared};
use twin_core::notation::{Coords, GRAVITY_M_S2, MAX_ROTORS, TICK_S};
use twin_core::source::{EFFECTS, InnerLoop, InnerState, Source};
use twin_core::tick::{ActuatorCommand, Setpoint};
use twin_plant::curves::{discharge, open_cell_v, servo_friction, servo_torque};
use twin_plant::model::{Robot, Statics};
use twin_plant::{BatterySettings, PlantSettings, ServoSettings, SimulatedVehicle, Start};
use twin_scenario::{BuildError, Scenario};

/// Power of four rotors of the standard vehicle in hover, W.
const HOVER_W: f64 = 250.0;

pub(super) fn battery(s: &BatterySettings) -> Section {
    // Chen and Rincón-Mora (2006), equation 2, written out again.
    let theory = |c: f64| {
        -1.031 * exp(-35.0 * c) + 3.685 + 0.2156 * c - 0.1178 * squared(c) + 0.3201 * powf(c, 3.0)
    };
    let charges = range(0.0, 1.0, 100);
    let shares = discharge(s, HOVER_W, 900);
    let minutes = shares.iter().enumerate().map(|(i, share)| (i as f64 / 60.0, *share));
    // The energy of the charge that a hover of 10 min takes, at the mean voltage.
    let taken = HOVER_W / s.efficiency * 600.0 / (s.reference_v * shares[300]) / 3600.0;
    let end = s.charge - taken / s.capacity_a_h;
    let current_a = HOVER_W / s.efficiency / (s.reference_v * shares[599]);
    let loaded_v = s.cells * theory(end) - current_a * (s.resistance_ohm + s.polarisation_ohm);
    Section {
        title: "Battery",
        source: "Open-circuit voltage: Chen and Rincón-Mora, Accurate Electrical Battery Model Capable of Predicting Runtime and I-V Performance, \
                 IEEE Transactions on Energy Conversion 21 (2006), equation 2. Controllers without feedback turn the rotors in proportion to \
                 the voltage.",
        pictures: vec![
            picture(
                "Open-circuit voltage of a cell",
                "charge / capacity",
                "V",
                vec![
                    published("Chen, Rincón-Mora", charges.clone().map(|c| (c, theory(c)))),
                    twin("twin", charges.map(|c| (c, open_cell_v(c)))),
                ],
            ),
            picture(
                "Rotor speed per commanded speed in a hover",
                "min",
                "",
                vec![twin("twin", minutes)],
            ),
        ],
        points: vec![
            Point::new("cell at half charge", [open_cell_v(0.5), theory(0.5)], 1e-9, "V"),
            // The current is not constant while the battery empties.
            Point::new(
                "pack after 10 min of hover",
                [s.reference_v * shares[599], loaded_v],
                0.1,
                "V",
            ),
        ],
    }
}

pub(super) fn servo(s: &ServoSettings) -> Section {
    let friction = |rate: f64| 1.0 + (s.stiction - 1.0) * exp(-squared(rate / s.stribeck_rad_s));
    let torque = |rate: f64| s.stall_n_m * (1.0 - rate / s.free_rad_s).clamp(0.0, 1.0);
    let half = 0.5 * s.free_rad_s;
    Section {
        title: "Servo",
        source: "Friction: Stribeck's curve in the form of Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994). Torque and \
                 speed: straight line between stall torque and free speed of the data sheet, 3.0 N m and 77 rev/min for the XM430-W210 at 12 V.",
        pictures: vec![
            picture(
                "Friction per Coulomb friction",
                "rad/s",
                "",
                vec![
                    published("Stribeck", range(0.0, 0.5, 100).map(|v| (v, friction(v)))),
                    twin("twin", range(0.0, 0.5, 50).map(|v| (v, servo_friction(s, v)))),
                ],
            ),
            picture(
                "Largest torque",
                "rad/s in the sense of the torque",
                "N m",
                vec![
                    published("data sheet", range(-4.0, 10.0, 100).map(|v| (v, torque(v)))),
                    twin("twin", range(-4.0, 10.0, 70).map(|v| (v, servo_torque(s, v)))),
                ],
            ),
        ],
        points: vec![
            Point::new(
                "friction at the Stribeck speed",
                [servo_friction(s, s.stribeck_rad_s), friction(s.stribeck_rad_s)],
                1e-9,
                "",
            ),
            Point::new(
                "torque at half the free speed",
                [servo_torque(s, half), torque(half)],
                1e-9,
                "N m",
            ),
        ],
    }
}

/// Rotors that carry the weight, and joints without torque.
struct Limp(ActuatorCommand);

impl InnerLoop for Limp {
    fn command(&mut self, _setpoint: &Setpoint, _state: &InnerState) -> ActuatorCommand {
        self.0
    }
}

/// Mass (kg) and moments of inertia (kg m²) of a base that the arm cannot move.
const ANCHOR: f64 = 1e4;

/// Steps of 10 ms in which the arm comes to rest.
const FALL_TICKS: usize = 1500;

/// Settings of a vehicle on which nothing acts but gravity, its joints and its servos.
fn quiet(scenario: &Scenario) -> PlantSettings {
    let mut settings = scenario.settings.plant();
    for name in EFFECTS.into_iter().filter(|name| *name != "servo") {
        if let Some(switch) = settings.effect_mut(name) {
            *switch = false;
        }
    }
    settings.payload.mass_kg = 0.0;
    settings.vehicle.rotor.max_thrust_n = 1e6;
    settings.vehicle.rotor.thrust_scale = 1.0;
    settings
}

/// Coordinates of `robot` on a base that does not move, while its arm falls.
fn fall(
    scenario: &Scenario,
    settings: PlantSettings,
    mut robot: Robot,
) -> Result<Vec<Coords>, EvaluateError> {
    let base = &mut robot.links[robot.root].inertial;
    base.mass_kg = ANCHOR;
    base.inertia_in_link = nalgebra::Matrix3::from_diagonal_element(ANCHOR);
    let rotors = settings.vehicle.rotors.len();
    let mut rotor_thrust_n = [0.0; MAX_ROTORS];
    rotor_thrust_n[..rotors].fill(robot.total_mass_kg() * GRAVITY_M_S2 / rotors as f64);
    let mut inner = Limp(ActuatorCommand {
        rotor_thrust_n,
        joint_torque_n_m: Vector2::zeros(),
        saturated: false,
    });
    let start = Start {
        position: Vector3::new(0.0, 0.0, 50.0),
        joints: Vector2::new(-0.8, 1.2),
        grasped: None,
        inner_steps: 2,
    };
    let setpoint = scenario.parts()?.setpoint;
    let mut vehicle = SimulatedVehicle::new(robot, &[], settings, &start, scenario.settings.seed)
        .map_err(BuildError::from)?;
    let step = |_| {
        vehicle.advance(&setpoint, &mut inner);
        vehicle.truth().map(|truth| truth.chi)
    };
    Ok((0..FALL_TICKS).filter_map(step).collect())
}

/// The arm falls from a raised posture until friction holds it.
pub(super) fn arm(scenario: &Scenario) -> Result<Section, EvaluateError> {
    let settings = quiet(scenario);
    let robot = scenario.robot()?;
    let stiction = settings.vehicle.servo.stiction;
    let names = &settings.vehicle.arm_joints;
    let joints: Vec<usize> = names.iter().filter_map(|name| robot.joint(name)).collect();
    let most: Vec<f64> = joints.iter().map(|j| stiction * robot.joints[*j].friction).collect();
    let statics = Statics::new(&robot, &joints);
    let flown = fall(scenario, settings, robot)?;
    let weight = flown.last().map(|chi| statics.gravity(chi));
    let points = most.iter().enumerate().filter_map(|(row, most)| {
        let held = weight?[6 + row].abs();
        let at = format!("torque of gravity on q{} at rest, at most the static friction", row + 1);
        // A torque just above static friction moves the joint against its damping by less than a degree a second.
        Some(Point::new(at, [held.min(*most), held], 2e-3, "N m"))
    });
    let curve = |row: usize| {
        flown.iter().enumerate().map(|(i, chi)| (i as f64 * TICK_S, chi[row])).collect::<Vec<_>>()
    };
    Ok(Section {
        title: "Free decay of the arm",
        source: "The arm falls without torque from a raised posture below a base that cannot move. Viscous and Coulomb friction of the URDF \
                 stop it; it rests where gravity is weaker than static friction (independent statics of the URDF).",
        pictures: vec![picture(
            "Joint angles",
            "s",
            "rad",
            vec![twin("q1", curve(6)), twin("q2", curve(7))],
        )],
        points: points.collect(),
    })
}
