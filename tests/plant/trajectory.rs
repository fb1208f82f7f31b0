//! One second of open-loop flight of the whole simulated vehicle, compared with the oracle, which a Runge-Kutta method integrates.

use nalgebra::{DVector, Rotation3, UnitQuaternion, Vector2, Vector3};
use twin_core::elementary::{acos, sin};
use twin_core::notation::{Coords, MAX_ROTORS};
use twin_core::source::{InnerLoop, InnerState, Source};
use twin_core::tick::{ActuatorCommand, Setpoint};
use twin_plant::model::{JointKind, Robot};
use twin_plant::{PlantSettings, SimulatedVehicle, Start};

use super::oracle::{Effort, Oracle, State};
use super::rig::{aerial_manipulator, any_setpoint, awkward, quiet_settings};

/// The plant is second order in its step of 1 ms; measured 0.03 mm, 0.004° and 0.0013°. With inertial forces at the end of a step instead
/// of its middle, the errors would be 0.16 mm and 0.009°; with the damping of the joints there too, 2.1 mm and 0.10°.
const POSITION_TOLERANCE_M: f64 = 0.05e-3;
const ATTITUDE_TOLERANCE_DEG: f64 = 0.006;
const JOINT_TOLERANCE_DEG: f64 = 0.002;

/// Range of the largest tilt. Without tilt, the flight would not test gyroscopic terms and the attitude in the middle of a step.
const TILT_DEG: std::ops::Range<f64> = 40.0..70.0;

/// Start in the world, so high that a tumbling vehicle meets nothing, and angles of the arm.
const START_M: [f64; 3] = [0.0, 0.0, 2000.0];
const START_RAD: [f64; 2] = [0.4, 0.8];

/// Plant step, s, and number of the oracle's steps in it.
const STEP_S: f64 = 1e-3;
const SUBSTEPS: u32 = 10;

/// Rotor thrusts and joint torques of step `k`.
pub(super) fn command(k: u32) -> ActuatorCommand {
    let t = f64::from(k) * STEP_S;
    let wave = |hz: f64, phase: f64| sin(std::f64::consts::TAU * hz * t + phase);
    let mut rotor_thrust_n = [0.0; MAX_ROTORS];
    rotor_thrust_n[0] = 8.20 + 0.10 * wave(0.7, 0.3);
    rotor_thrust_n[1] = 7.12 + 0.15 * wave(1.1, 1.0);
    rotor_thrust_n[2] = 7.02 + 0.10 * wave(1.6, 2.0);
    rotor_thrust_n[3] = 8.12 + 0.15 * wave(0.9, 0.0);
    let joint_torque_n_m = Vector2::new(0.5 * wave(1.3, 0.0), 0.3 * wave(1.9, 0.5));
    ActuatorCommand { rotor_thrust_n, joint_torque_n_m, saturated: false }
}

/// Inner controllers that count their calls, one for each step, and command by the count.
pub(super) struct OpenLoop<'a>(pub u32, pub &'a dyn Fn(u32) -> ActuatorCommand);

impl InnerLoop for OpenLoop<'_> {
    fn command(&mut self, _setpoint: &Setpoint, _state: &InnerState) -> ActuatorCommand {
        self.0 += 1;
        (self.1)(self.0 - 1)
    }
}

/// `robot` with its fingers fixed and its joints without dry friction.
pub(super) fn simplified(mut robot: Robot) -> Robot {
    for joint in &mut robot.joints {
        joint.friction = 0.0;
        if joint.kind == JointKind::Prismatic {
            joint.kind = JointKind::Fixed;
            joint.mimic = None;
        }
    }
    robot
}

/// Actuators that follow their commands at once.
pub(super) fn settings(robot: &Robot) -> PlantSettings {
    let mut settings = quiet_settings();
    settings.vehicle.gripper.joint.clear();
    let moves = |name: &String| {
        robot.joint(name).is_some_and(|joint| robot.joints[joint].kind != JointKind::Fixed)
    };
    settings.vehicle.arm_joints.retain(moves);
    settings.vehicle.joint_delay_s = 0.0;
    settings.vehicle.rotor.delay_s = 0.0;
    settings.vehicle.rotor.lag_s = 1e-9;
    settings.vehicle.rotor.fall_lag_s = 1e-9;
    settings.vehicle.rotor.thrust_scale = 1.0;
    settings.payload.mass_kg = 0.0;
    settings
}

/// Force and moment of the rotors from their positions, thrusts and directions of rotation.
fn wrench(settings: &PlantSettings, command: &ActuatorCommand) -> Effort {
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for (rotor, thrust) in settings.vehicle.rotors.iter().zip(command.rotor_thrust_n) {
        let [x, y, _] = rotor.position_m;
        force.z += thrust;
        // x × z = -y, y × z = x; the air rotates the frame of a counter-clockwise rotor clockwise.
        moment += Vector3::new(
            y * thrust,
            -x * thrust,
            -rotor.spin * settings.vehicle.rotor.torque_ratio_m * thrust,
        );
    }
    Effort {
        force_in_body: force,
        moment_in_body: moment,
        joints: DVector::from_column_slice(command.joint_torque_n_m.as_slice()),
    }
}

/// Largest errors of distance (m), attitude (deg) and joints (deg) so far.
#[derive(Default)]
pub(super) struct Errors {
    pub(super) position_m: f64,
    pub(super) attitude_deg: f64,
    pub(super) joint_deg: f64,
    /// Origin of the root link in the oracle at the end, m.
    pub(super) position: Vector3<f64>,
}

impl Errors {
    fn add(&mut self, oracle: &Oracle<'_>, state: &State, chi: &Coords) {
        let position = state.com - state.rotation * oracle.com_in_root;
        let attitude = UnitQuaternion::from_rotation_matrix(&Rotation3::from_euler_angles(
            chi[3], chi[4], chi[5],
        ));
        let joints = state
            .joints
            .iter()
            .zip(chi.iter().skip(6))
            .map(|(q, found)| (q - found).abs())
            .fold(0.0, f64::max);
        self.position = position;
        self.position_m = self.position_m.max((position - chi.fixed_rows::<3>(0)).norm());
        self.attitude_deg = self.attitude_deg.max(attitude.angle_to(&state.rotation).to_degrees());
        self.joint_deg = self.joint_deg.max(joints.to_degrees());
    }
}

/// The vehicle at the start.
pub(super) fn built(robot: &Robot, settings: &PlantSettings) -> SimulatedVehicle {
    let (position, joints) = (START_M.into(), START_RAD.into());
    let start = Start { position, joints, grasped: None, inner_steps: 1 };
    SimulatedVehicle::new(robot.clone(), &[], settings.clone(), &start, 1)
        .expect("the vehicle is built")
}

/// Flies for `ticks` of 10 ms; returns the errors and the largest tilt, deg.
pub(super) fn fly(
    robot: &Robot,
    ticks: u32,
    settings: &PlantSettings,
    command: &dyn Fn(u32) -> ActuatorCommand,
) -> (Errors, f64) {
    let mut oracle = Oracle::new(robot);
    oracle.armature.fill(settings.vehicle.joint_armature_kg_m2);
    let damping = oracle.moving.iter().map(|&joint| robot.joints[joint].damping);
    oracle.damping = DVector::from_iterator(oracle.moving.len(), damping);
    let mut vehicle = built(robot, settings);
    let joints = Vector2::from(START_RAD);
    let mut state = State {
        com: Vector3::from(START_M) + oracle.com_in_root,
        rotation: UnitQuaternion::identity(),
        joints: DVector::from_column_slice(&joints.as_slice()[..oracle.moving.len()]),
        velocity: DVector::zeros(oracle.dofs()),
    };
    let (setpoint, mut inner) = (any_setpoint(), OpenLoop(0, command));
    let (mut errors, mut tilt_deg) = (Errors::default(), 0.0_f64);
    for tick in 0..ticks {
        vehicle.advance(&setpoint, &mut inner);
        for k in 10 * tick..10 * (tick + 1) {
            let effort = wrench(settings, &command(k));
            for _ in 0..SUBSTEPS {
                state = oracle.step(&state, &effort, STEP_S / f64::from(SUBSTEPS));
            }
        }
        errors.add(&oracle, &state, &vehicle.truth().expect("it is simulated").chi);
        tilt_deg = tilt_deg.max(acos((state.rotation * Vector3::z()).z).to_degrees());
    }
    (errors, tilt_deg)
}

fn check(robot: &Robot, ticks: u32) {
    let (Errors { position_m, attitude_deg, joint_deg, .. }, tilt_deg) =
        fly(robot, ticks, &settings(robot), &command);
    let found = format!(
        "{:.3} mm, {attitude_deg:.4}°, {joint_deg:.4}° at {tilt_deg:.0}°",
        position_m * 1e3
    );
    assert!(TILT_DEG.contains(&tilt_deg), "{found}");
    assert!(position_m <= POSITION_TOLERANCE_M, "{found}");
    assert!(attitude_deg <= ATTITUDE_TOLERANCE_DEG, "{found}");
    assert!(joint_deg <= JOINT_TOLERANCE_DEG, "{found}");
}

#[test]
fn a_second_of_open_loop_flight_follows_the_oracle() {
    check(&simplified(aerial_manipulator()), 100);
}

#[test]
fn a_root_whose_mass_is_off_its_origin_follows_the_oracle_too() {
    // The weight of this vehicle is off the middle of the rotors, so it tips over sooner.
    check(&simplified(awkward()), 40);
}

#[test]
fn a_vehicle_without_joints_follows_the_oracle_too() {
    let mut robot = simplified(aerial_manipulator());
    robot.joints.iter_mut().for_each(|joint| joint.kind = JointKind::Fixed);
    check(&robot, 50);
}
