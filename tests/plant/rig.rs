//! Vehicles for the tests: that of the URDF, a variant that is harder to load, and a gripper on a base that does not move.

use std::path::{Path, PathBuf};

use nalgebra::{DVector, Isometry3, Matrix3, UnitQuaternion, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use twin_core::notation::MAX_ROTORS;
use twin_core::source::{InnerLoop, InnerState, Source};
use twin_core::tick::{ActuatorCommand, GripperCommand, Setpoint, Truth};
use twin_plant::model::{Inertial, Joint, JointKind, Link, Packages, Robot};
use twin_plant::{PlantSettings, SimulatedVehicle, Start};
use twin_scenario::Scenario;

use super::oracle::{GRAVITY_M_S2, Oracle, State};

/// Path of a file of the repository.
pub(super) fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The vehicle of the URDF.
pub(super) fn aerial_manipulator() -> Robot {
    Robot::load(&repository("urdf/aerial_manipulator.urdf"), &Packages(Vec::new()))
        .expect("the URDF loads")
}

/// The vehicle with features that its URDF lacks: a root whose centre of mass is off its origin, with products of inertia, and a
/// rotated link with mass that is fixed to it.
pub(super) fn awkward() -> Robot {
    let mut robot = aerial_manipulator();
    let root = robot.root;
    let tilted = |rpy: [f64; 3], moments: [f64; 3]| -> Matrix3<f64> {
        let r = *UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2])
            .to_rotation_matrix()
            .matrix();
        r * Matrix3::from_diagonal(&moments.into()) * r.transpose()
    };
    robot.links[root].inertial.com_in_link = Vector3::new(0.03, -0.02, 0.04);
    robot.links[root].inertial.inertia_in_link = tilted([0.3, -0.4, 0.5], [0.04, 0.05, 0.07]);
    let inertial = Inertial {
        mass_kg: 0.4,
        com_in_link: Vector3::new(0.02, 0.01, -0.03),
        inertia_in_link: tilted([-0.2, 0.6, 0.1], [1.0e-3, 1.4e-3, 1.9e-3]),
    };
    robot.links.push(Link {
        name: "camera".into(),
        inertial,
        visuals: Vec::new(),
        collisions: Vec::new(),
    });
    let child = robot.links.len() - 1;
    let origin = Isometry3::new(Vector3::new(0.15, 0.02, -0.05), Vector3::new(0.2, 0.7, -0.4));
    let fixed = robot
        .joints
        .iter()
        .find(|joint| joint.kind == JointKind::Fixed)
        .expect("the wrist is fixed")
        .clone();
    robot.joints.push(Joint { name: "camera_joint".into(), parent: root, child, origin, ..fixed });
    robot
}

/// A random pose high above everything with every joint inside its limits; rates up to `speed` (rad/s, m/s).
pub(super) fn random_state(robot: &Robot, oracle: &Oracle<'_>, seed: u64, speed: f64) -> State {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut draw = || 2.0 * rng.random::<f64>() - 1.0;
    let rotation =
        UnitQuaternion::new_normalize(nalgebra::Quaternion::new(draw(), draw(), draw(), draw()));
    let joints = DVector::from_iterator(
        oracle.moving.len(),
        oracle.moving.iter().map(|&joint| {
            let Joint { lower, upper, .. } = robot.joints[joint];
            0.5 * (lower + upper) + 0.45 * (upper - lower) * draw()
        }),
    );
    let mut velocity = DVector::from_fn(oracle.dofs(), |_, _| speed * draw());
    // The fingers slide, so their rates are in m/s.
    for (row, &joint) in oracle.moving.iter().enumerate() {
        if robot.joints[joint].kind == JointKind::Prismatic {
            velocity[6 + row] *= 0.1;
        }
    }
    State { com: Vector3::new(draw(), draw(), 5.0 + draw()), rotation, joints, velocity }
}

/// Plant settings of the defaults, with air, noise and scatter switched off.
pub(super) fn quiet_settings() -> PlantSettings {
    let scenario = Scenario::load(&repository("scenarios/hover.toml"), &quiet())
        .expect("the overrides are valid");
    scenario.settings.plant()
}

/// Overrides that switch air, noise and scatter off.
pub(super) fn quiet() -> Vec<String> {
    let off = [
        "aero.inflow",
        "aero.flapping",
        "aero.rotor_drag",
        "aero.body_drag",
        "aero.ground_effect",
        "aero.recirculation",
        "aero.downwash",
        "aero.unsteady",
        "vehicle.mismatch.on",
        "vehicle.battery.on",
        "vehicle.servo.on",
        "vehicle.link.on",
        "sensors.mocap_link.on",
    ]
    .map(|key| format!("{key}=false"));
    let zero = [
        "aero.turbulence_n",
        "aero.turbulence_n_m",
        "payload.position_spread_m",
        "payload.yaw_std_rad",
        "sensors.mocap_noise_m",
        "sensors.mocap_noise_rad",
        "sensors.payload_calibration_m",
        "sensors.accelerometer_noise_m_s2",
        "sensors.accelerometer_bias_m_s2",
        "sensors.vibration_m_s2",
        "sensors.gyro_noise_rad_s",
        "sensors.gyro_bias_rad_s",
    ];
    off.into_iter().chain(zero.map(|key| format!("{key}=0.0"))).collect()
}

/// Inner controllers that always command the same thrust of every rotor and the same torques.
pub(super) struct Constant(ActuatorCommand);

impl InnerLoop for Constant {
    fn command(&mut self, _setpoint: &Setpoint, _state: &InnerState) -> ActuatorCommand {
        self.0
    }
}

/// Mass (kg) and moments of inertia (kg m²) so large that the forces of gripper and arm move the base invisibly within seconds.
const ANCHOR: f64 = 1.0e4;

/// Arm angles at which the hand points straight down, rad.
const HAND_DOWN_RAD: [f64; 2] = [-0.3508, 1.1397];

/// The vehicle with a base so heavy that it stays where it is. Its rotors carry it, and no other force acts.
pub(super) struct Rig {
    vehicle: SimulatedVehicle,
    setpoint: Setpoint,
    inner: Constant,
}

/// Initial state of a rig.
pub(super) struct RigSettings {
    /// Mass of the cube between the fingers, kg; 0: none.
    pub cube_kg: f64,
    /// Offset of the cube's centre from the grasp point along the direction of the fingers, m.
    pub cube_off_centre_m: f64,
    /// Force of each finger, N.
    pub grip_n: f64,
    /// Whether the arm is locked with the hand down; otherwise it is free and straight.
    pub locked_arm: bool,
}

/// `robot` with a base that does not move.
pub(super) fn anchored(mut robot: Robot) -> Robot {
    let base = &mut robot.links[robot.root].inertial;
    base.mass_kg = ANCHOR;
    base.inertia_in_link = Matrix3::from_diagonal_element(ANCHOR);
    robot
}

/// The command whose rotors carry `weight_n`, with the arm's joints free.
pub(super) fn carrying(weight_n: f64, rotors: usize) -> ActuatorCommand {
    let mut rotor_thrust_n = [0.0; MAX_ROTORS];
    rotor_thrust_n[..rotors].fill(weight_n / rotors as f64);
    ActuatorCommand { rotor_thrust_n, joint_torque_n_m: Vector2::zeros(), saturated: false }
}

impl Rig {
    pub(super) fn new(wanted: &RigSettings) -> Self {
        Self::with(wanted, quiet_settings())
    }

    /// The rig with settings of its own.
    pub(super) fn with(wanted: &RigSettings, mut settings: PlantSettings) -> Self {
        let mut robot = anchored(aerial_manipulator());
        if wanted.locked_arm {
            for (name, angle) in ["joint1", "joint2"].iter().zip(HAND_DOWN_RAD) {
                let index = robot.joint(name).expect("an arm joint");
                let joint = &mut robot.joints[index];
                joint.origin *= UnitQuaternion::new(joint.axis * angle);
                joint.kind = JointKind::Fixed;
            }
            settings.vehicle.arm_joints.clear();
        }
        settings.payload.mass_kg = wanted.cube_kg;
        settings.vehicle.gripper.force_n = wanted.grip_n;
        settings.vehicle.rotor.thrust_scale = 1.0;
        settings.vehicle.rotor.max_thrust_n = f64::MAX.sqrt();
        let position = Vector3::new(0.0, 0.0, 2.0);
        let poses = twin_plant::model::link_poses(
            &robot,
            &Isometry3::from(position),
            &vec![0.0; robot.joints.len()],
        );
        let tool = poses[robot.link("tool").expect("the grasp point")];
        let cube = tool * nalgebra::Point3::new(0.0, wanted.cube_off_centre_m, 0.0);
        let grasped = (wanted.cube_kg > 0.0).then_some(cube.coords);
        let start = Start { position, joints: Vector2::zeros(), grasped, inner_steps: 1 };
        let weight_n = (robot.total_mass_kg() + wanted.cube_kg) * GRAVITY_M_S2;
        let command = carrying(weight_n, settings.vehicle.rotors.len());
        let vehicle =
            SimulatedVehicle::new(robot, &[], settings, &start, 1).expect("the rig is built");
        Self { vehicle, setpoint: any_setpoint(), inner: Constant(command) }
    }

    /// Sets the torques of the free arm, N m.
    pub(super) fn set_torque(&mut self, joint_torque_n_m: Vector2<f64>) {
        self.inner.0.joint_torque_n_m = joint_torque_n_m;
    }

    /// Advances by `ticks` of 10 ms with one command to the gripper; returns the truth after each tick.
    pub(super) fn run(&mut self, ticks: usize, gripper: GripperCommand) -> Vec<Truth> {
        self.setpoint.gripper = gripper;
        (0..ticks)
            .map(|_| {
                self.vehicle.advance(&self.setpoint, &mut self.inner);
                self.vehicle.truth().expect("a simulated vehicle knows the truth")
            })
            .collect()
    }
}

/// A set-point for inner controllers that do not read it.
pub(super) fn any_setpoint() -> Setpoint {
    let scenario = Scenario::load(&repository("scenarios/hover.toml"), &[]).expect("it loads");
    scenario.parts().expect("it builds").setpoint
}
