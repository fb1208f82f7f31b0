//! The robots under `urdf/` and the errors of broken ones.

use std::path::Path;

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};
use proptest::prelude::*;

use super::*;
use crate::notation::{Coords, GRAVITY_M_S2, attitude, position, world_from_body};

const VEHICLE: &str = include_str!("../../urdf/aerial_manipulator.urdf");
const SCENERY: [&str; 3] = [
    include_str!("../../urdf/box.urdf"),
    include_str!("../../urdf/table.urdf"),
    include_str!("../../urdf/cube.urdf"),
];

/// Both sides are some dozen f64 products of numbers near one.
const ROUNDING: f64 = 1e-12;
/// The URDF holds angles with ten decimals and the arm is half a metre long.
const WRITTEN_ANGLE: f64 = 1e-9;

fn parse(text: &str) -> Result<Robot, ModelError> {
    Robot::parse(text, Path::new("urdf/test.urdf"), &Packages::default())
}

fn vehicle() -> Robot {
    parse(VEHICLE).unwrap()
}

fn arm_joints(robot: &Robot) -> [usize; 2] {
    ["joint1", "joint2"].map(|name| robot.joint(name).unwrap())
}

fn arm(robot: &Robot) -> Arm {
    Arm::new(robot, &arm_joints(robot), robot.link("tool").unwrap())
}

#[test]
fn the_vehicle_weighs_three_kilograms() {
    let robot = vehicle();
    assert!((robot.total_mass_kg() - 3.0).abs() < ROUNDING);
    assert_eq!(robot.links[robot.root].name, "base_link");
    for link in robot.links.iter().filter(|link| link.name != "tool") {
        let tensor = link.inertial.inertia_in_link;
        assert!(tensor.cholesky().is_some(), "{}: {tensor}", link.name);
    }
}

#[test]
fn scenery_loads_and_stands_where_it_says() {
    for (text, top) in SCENERY.into_iter().zip([0.10, 0.55, 0.025]) {
        let robot = parse(text).unwrap();
        let Geometry { origin, shape: Shape::Box { size_m }, .. } = &robot.links[0].collisions[0]
        else {
            panic!("{} is not a box", robot.name)
        };
        assert!((origin.translation.z + size_m[2] / 2.0 - top).abs() < ROUNDING, "{}", robot.name);
    }
}

#[test]
fn the_hand_points_down_and_the_tool_is_where_the_formula_says() {
    let arm = arm(&vehicle());
    let (l1, a, s, beta) = (0.18, 0.135, 0.045, -45.2_f64.to_radians());
    for (q1, q2) in [(-20.1_f64, 65.3_f64), (0.0, 0.0), (35.0, 80.0), (-60.0, 150.0)] {
        let q = Vector2::new(q1.to_radians(), q2.to_radians());
        let (q12, hand) = (q.x + q.y, q.x + q.y + beta);
        let oracle = Vector3::new(
            l1 * q.x.sin() + a * q12.sin() + s * hand.sin(),
            0.0,
            -0.05 - l1 * q.x.cos() - a * q12.cos() - s * hand.cos(),
        );
        let tool = arm.tool_in_body(&q);
        assert!((tool.translation.vector - oracle).norm() < WRITTEN_ANGLE, "{tool} {oracle}");
    }
    let down = arm.tool_in_body(&Vector2::new(-20.1_f64.to_radians(), 65.3_f64.to_radians()));
    let hand_axis = down.rotation * -Vector3::z();
    assert!((hand_axis + Vector3::z()).norm() < WRITTEN_ANGLE);
}

#[test]
fn the_pads_meet_at_zero_and_open_by_110_mm() {
    let robot = vehicle();
    let inner_face = |name: &str, opening: f64| {
        let mut positions = vec![0.0; robot.joints.len()];
        positions[robot.joint("finger_left_joint").unwrap()] = opening;
        let link = robot.link(name).unwrap();
        let palm = robot.link("palm").unwrap();
        let poses = link_poses(&robot, &Isometry3::identity(), &positions);
        let pad = &robot.links[link].collisions[0];
        let Shape::Box { size_m } = pad.shape else { panic!("the pad is a box") };
        let centre = (poses[palm].inverse() * poses[link] * pad.origin).translation.y;
        centre - centre.signum() * size_m[1] / 2.0
    };
    for opening in [0.0, 0.055] {
        let gap = inner_face("finger_left", opening) - inner_face("finger_right", opening);
        assert!((gap - 2.0 * opening).abs() < ROUNDING, "{gap}");
    }
}

/// `sum m_i g z_i`, from the pose of every link.
fn potential_energy(robot: &Robot, chi: &Coords) -> f64 {
    let mut positions = vec![0.0; robot.joints.len()];
    for (row, joint) in arm_joints(robot).into_iter().enumerate() {
        positions[joint] = chi[6 + row];
    }
    let rotation = Rotation3::from_matrix_unchecked(world_from_body(&attitude(chi)));
    let world_from_root =
        Isometry3::from_parts(Translation3::from(position(chi)), UnitQuaternion::from(rotation));
    let poses = link_poses(robot, &world_from_root, &positions);
    let height = |(link, pose): (&Link, &Isometry3<f64>)| {
        link.inertial.mass_kg * (pose * nalgebra::Point3::from(link.inertial.com_in_link)).z
    };
    GRAVITY_M_S2 * robot.links.iter().zip(&poses).map(height).sum::<f64>()
}

/// Step of the central difference and what it leaves of a smooth function of size 30: h² and 1e-16 / h, both below 1e-8.
const STEP: f64 = 1e-5;
const DIFFERENCE: f64 = 1e-7;

proptest! {
    #[test]
    fn gravity_is_the_gradient_of_the_potential_energy(
        angles in prop::array::uniform5(-1.3..1.3f64), z in -2.0..2.0f64,
    ) {
        let robot = vehicle();
        let mut chi = Coords::zeros();
        chi[2] = z;
        chi.fixed_rows_mut::<5>(3).copy_from_slice(&angles);
        let gravity = Statics::new(&robot, &arm_joints(&robot)).gravity(&chi);
        for row in 0..8 {
            let mut step = Coords::zeros();
            step[row] = STEP;
            let rise = potential_energy(&robot, &(chi + step)) - potential_energy(&robot, &(chi - step));
            prop_assert!((gravity[row] - rise / (2.0 * STEP)).abs() < DIFFERENCE, "row {row}");
        }
    }

    #[test]
    fn tool_velocity_is_the_derivative_of_the_tool_position(
        q in prop::array::uniform2(-1.5..1.5f64), q_dot in prop::array::uniform2(-2.0..2.0f64),
    ) {
        let arm = arm(&vehicle());
        let (q, q_dot) = (Vector2::from(q), Vector2::from(q_dot));
        let at = |t: f64| arm.tool_in_body(&(q + q_dot * t)).translation.vector;
        let oracle = (at(STEP) - at(-STEP)) / (2.0 * STEP);
        prop_assert!((arm.tool_velocity_in_body(&q, &q_dot) - oracle).norm() < DIFFERENCE);
    }
}
