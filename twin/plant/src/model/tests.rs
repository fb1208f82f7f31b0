//! The robots under `urdf/`, and URDFs in an unusual order or form.

use std::path::Path;

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};
use proptest::prelude::*;

use super::*;
use twin_core::elementary::{cos, sin};
use twin_core::notation::{Coords, GRAVITY_M_S2, attitude, position, world_from_body};
use twin_core::task::ToolKinematics;

const VEHICLE: &str = include_str!("../../../../urdf/aerial_manipulator.urdf");
const SCENERY: [&str; 3] = [
    include_str!("../../../../urdf/box.urdf"),
    include_str!("../../../../urdf/table.urdf"),
    include_str!("../../../../urdf/cube.urdf"),
];

/// Both sides are sums of some dozen products of numbers near one in f64.
const ROUNDING: f64 = 1e-12;
/// The URDF holds angles with ten decimals, and the arm is half a metre long.
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
            l1 * sin(q.x) + a * sin(q12) + s * sin(hand),
            0.0,
            -0.05 - l1 * cos(q.x) - a * cos(q12) - s * cos(hand),
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

/// Potential energy `sum m_i g z_i`, J, from the pose of every link.
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

/// Step of the central difference; its errors for a smooth function of size 30, h² and 1e-16 / h, are both below 1e-8.
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

/// Two links in an awkward order; the second's inertia is written in axes turned by 90° about z.
const PAIR: &str = r#"<robot name="pair">
  <link name="child"><inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><mass value="1"/>
    <inertia ixx="1" ixy="0.1" ixz="0.2" iyy="2" iyz="0.3" izz="2.5"/></inertial>
    <visual><geometry><mesh filename="package://pair/m/one.stl" scale="2 2 -2"/></geometry><material name="late"/></visual></link>
  <link name="grandchild"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <joint name="b" type="continuous"><parent link="child"/><child link="grandchild"/><axis xyz="0 0 2"/>
    <mimic joint="a" multiplier="-2" offset="0.5"/></joint>
  <joint name="a" type="continuous"><parent link="base"/><child link="child"/><axis xyz="0 0 1"/></joint>
  <link name="base"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <material name="late"><color rgba="0.25 0.5 0.75 1"/></material>
</robot>"#;

const ONE_STL: &str = "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 1\nvertex 1 0 1\nvertex 0 1 1\nendloop\nendfacet\nendsolid one\n";

fn load_pair() -> Robot {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    std::fs::create_dir_all(folder.join("share/m")).unwrap();
    std::fs::write(folder.join("share/m/one.stl"), ONE_STL).unwrap();
    std::fs::write(folder.join("pair.urdf"), PAIR).unwrap();
    let packages = Packages(vec![("pair".into(), folder.join("share"))]);
    Robot::load(&folder.join("pair.urdf"), &packages).unwrap()
}

#[test]
fn order_inertia_mimic_colour_and_mesh_are_read() {
    let robot = load_pair();
    let names: Vec<&str> = robot.joints.iter().map(|joint| &*joint.name).collect();
    assert_eq!((names, &*robot.links[robot.root].name), (vec!["a", "b"], "base"));
    assert_eq!(robot.joints[1].mimic, Some(Mimic { joint: 0, multiplier: -2.0, offset: 0.5 }));
    assert!(robot.joints[0].effort.is_infinite() && robot.joints[0].velocity.is_infinite());

    // Axes x' = y and y' = -x by hand: Ixx = Iy'y', Iyy = Ix'x', Ixy = -Ix'y', Ixz = -Iy'z', Iyz = Ix'z'.
    let oracle = nalgebra::Matrix3::new(2.0, -0.1, -0.3, -0.1, 1.0, 0.2, -0.3, 0.2, 2.5);
    let child = &robot.links[0];
    assert!((child.inertial.inertia_in_link - oracle).norm() < ROUNDING);
    assert!((child.inertial.com_in_link - Vector3::new(1.0, 2.0, 3.0)).norm() < ROUNDING);

    // Joint a turns by 0.3, joint b by 0.5 - 2 * 0.3.
    let poses = link_poses(&robot, &Isometry3::identity(), &[0.3, 9.0]);
    let (_, _, yaw) = poses[1].rotation.euler_angles();
    assert!((yaw - (0.3 + 0.5 - 0.6)).abs() < ROUNDING, "{yaw}");

    let drawn = &child.visuals[0];
    let vertices = vec![[0.0, 0.0, -2.0], [2.0, 0.0, -2.0], [0.0, 2.0, -2.0]];
    // A mirrored mesh has its corners in the opposite order, so that the normals still point outward.
    assert_eq!(drawn.shape, Shape::Mesh { vertices, triangles: vec![[0, 2, 1]] });
    assert_eq!(drawn.rgba.map(f32::to_bits), [0.25, 0.5, 0.75, 1.0_f32].map(f32::to_bits));
}

#[test]
fn a_vehicle_without_arm_has_only_its_weight_to_hold() {
    let robot = vehicle();
    let bare = Statics::new(&robot, &[]).gravity(&Coords::zeros());
    assert!((bare[2] - 3.0 * GRAVITY_M_S2).abs() < ROUNDING);
    assert_eq!((bare[6].to_bits(), bare[7].to_bits()), (0, 0));
    let tool = Arm::new(&robot, &[], robot.link("tool").unwrap());
    let moved = tool.tool_velocity_in_body(&Vector2::new(0.1, 0.2), &Vector2::new(1.0, 1.0));
    assert!(moved.norm() < ROUNDING);
}
