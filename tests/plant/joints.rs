//! Limits, mimic and effort of the joints.

use nalgebra::{Vector2, Vector3};
use twin_core::notation::Coords;
use twin_core::source::{InnerLoop, InnerState};
use twin_core::tick::{GripperCommand, Truth};
use twin_scenario::Scenario;

use super::rig::{Rig, RigSettings, aerial_manipulator, repository};

/// Rapier's joint limits and couplings are constraints of 1e6 Hz; their measured give is below a micrometre.
const FINGER_TOLERANCE_M: f64 = 1e-5;

/// Give of the coupling while one finger alone pushes with the force of both; measured 14 µm.
const COUPLING_TOLERANCE_M: f64 = 5e-5;

/// Give of an arm joint's limit under full torque, rad: 0.1°.
const LIMIT_TOLERANCE_RAD: f64 = 1.7e-3;

/// Positions of the left and right finger from the poses of the links.
fn fingers(truth: &Truth) -> [f64; 2] {
    let robot = aerial_manipulator();
    let place = |name: &str| {
        let pose = &truth.poses[robot.link(name).expect("a link")];
        let [w, i, j, k] = pose.quaternion_wxyz;
        let turn = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, i, j, k));
        (Vector3::from(pose.position), turn)
    };
    let (palm, turn) = place("palm");
    let along = |name: &str| (turn.inverse() * (place(name).0 - palm)).y;
    [along("finger_left"), -along("finger_right")]
}

#[test]
fn fingers_stop_at_their_limits() {
    let settings =
        RigSettings { cube_kg: 0.0, cube_off_centre_m: 0.0, grip_n: 20.0, locked_arm: true };
    let mut rig = Rig::new(&settings);
    for (command, end_m) in [(GripperCommand::Close, 0.0), (GripperCommand::Open, 0.055)] {
        let truths = rig.run(60, command);
        for finger in fingers(truths.last().expect("it flew")) {
            assert!((finger - end_m).abs() < FINGER_TOLERANCE_M, "{command:?}: {finger} m");
        }
        for finger in truths.iter().flat_map(fingers) {
            assert!(
                (-FINGER_TOLERANCE_M..=0.055 + FINGER_TOLERANCE_M).contains(&finger),
                "{finger} m"
            );
        }
    }
}

#[test]
fn the_mimic_finger_follows_also_when_only_one_of_them_touches() {
    let settings =
        RigSettings { cube_kg: 0.3, cube_off_centre_m: 0.008, grip_n: 20.0, locked_arm: true };
    let truths = Rig::new(&settings).run(100, GripperCommand::Close);
    for truth in &truths {
        let [left, right] = fingers(truth);
        assert!((left - right).abs() < COUPLING_TOLERANCE_M, "{left} m and {right} m");
    }
    let last = truths.last().expect("it flew");
    assert!(
        last.payload_in_palm.y.abs() < 1e-3,
        "the cube was drawn to the middle: {}",
        last.payload_in_palm
    );
}

#[test]
fn an_arm_joint_stops_at_its_limit_under_full_torque() {
    let robot = aerial_manipulator();
    let joint = |name: &str| &robot.joints[robot.joint(name).expect("an arm joint")];
    let (first, second) = (joint("joint1"), joint("joint2"));
    let settings =
        RigSettings { cube_kg: 0.0, cube_off_centre_m: 0.0, grip_n: 20.0, locked_arm: false };
    let mut rig = Rig::new(&settings);
    for sign in [1.0, -1.0] {
        rig.set_torque(Vector2::new(sign * first.effort, sign * second.effort));
        let truths = rig.run(150, GripperCommand::Open);
        for (row, joint) in [(6, first), (7, second)] {
            let positions = truths.iter().map(|truth| truth.chi[row]);
            let beyond =
                positions.map(|q| (q - joint.upper).max(joint.lower - q)).fold(f64::MIN, f64::max);
            assert!(beyond < LIMIT_TOLERANCE_RAD, "{}: {beyond} rad beyond its limit", joint.name);
            assert!(
                beyond > -LIMIT_TOLERANCE_RAD,
                "{}: never reached its limit ({beyond} rad)",
                joint.name
            );
        }
    }
}

#[test]
fn joint_torques_never_exceed_the_effort_of_the_urdf() {
    let robot = aerial_manipulator();
    let scenario = Scenario::load(&repository("scenarios/hover.toml"), &[]).expect("it loads");
    let mut parts = scenario.parts().expect("it builds");
    let state = InnerState {
        eta: Vector3::zeros(),
        eta_dot: Vector3::zeros(),
        joint: parts.setpoint.joint_des,
        joint_dot: Vector2::zeros(),
    };
    let near = parts.inner.command(&parts.setpoint, &state);
    assert!(near.joint_torque_n_m.amax() < 1.0 && !near.saturated, "{near:?}");
    for sign in [1.0, -1.0] {
        let mut far = parts.setpoint;
        far.joint_des += Vector2::repeat(2.0 * sign);
        far.r_hat = Coords::repeat(50.0 * sign);
        let command = parts.inner.command(&far, &state);
        for (torque, name) in command.joint_torque_n_m.iter().zip(["joint1", "joint2"]) {
            let effort = robot.joints[robot.joint(name).expect("an arm joint")].effort;
            assert!((torque - sign * effort).abs() < 1e-12, "{name}: {torque} N m of {effort} N m");
        }
        assert!(command.saturated, "the limit is reported");
    }
}
