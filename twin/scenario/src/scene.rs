//! The scene for the viewers: shapes of vehicle, arena and payload, parsed once, in the order of
//! [`twin_core::tick::Truth::poses`].

use nalgebra::Isometry3;
use serde::{Deserialize, Serialize};

use super::{BuildError, Scenario, assemble};
use twin_core::tick::Pose;
use twin_plant::model::{Geometry, Shape, link_poses};
use twin_record::scene::{Scene, SceneBody, SceneGroup, SceneRotor};

/// Colour of the payload cube.
const PAYLOAD_RGBA: [f32; 4] = [0.90, 0.62, 0.0, 1.0];

/// Limits of a vehicle's actuators.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActuatorLimits {
    /// Smallest and largest thrust of a rotor, N.
    pub rotor_thrust_n: [f64; 2],
    /// Largest torque of each joint of the arm, N m; `None` if the joint has no limit or does not exist.
    pub joint_torque_n_m: [Option<f64>; 2],
}

/// The actuator limits of a scenario's vehicle: rotor limits from the scenario, joint limits from the URDF.
pub(super) fn actuator_limits(scenario: &Scenario) -> Result<ActuatorLimits, BuildError> {
    let vehicle = &scenario.settings.vehicle;
    let robot = assemble::models(scenario)?.robot;
    let effort = |index: usize| {
        let name = vehicle.arm_joints.get(index)?;
        let joint = robot.joints.iter().find(|joint| joint.name == *name)?;
        joint.effort.is_finite().then_some(joint.effort)
    };
    Ok(ActuatorLimits {
        rotor_thrust_n: [vehicle.rotor.min_thrust_n, vehicle.rotor.max_thrust_n],
        joint_torque_n_m: [effort(0), effort(1)],
    })
}

/// The scene of a scenario.
pub(super) fn scene(scenario: &Scenario) -> Result<Scene, BuildError> {
    let settings = &scenario.settings;
    let models = assemble::models(scenario)?;
    let start = settings.task.start_position_m;
    let root = Isometry3::translation(start[0], start[1], start[2]);
    let zeros = vec![0.0; models.robot.joints.len()];
    let mut bodies: Vec<SceneBody> = models
        .robot
        .links
        .iter()
        .zip(link_poses(&models.robot, &root, &zeros))
        .map(|(link, pose)| body(&link.name, true, SceneGroup::Vehicle, &pose, &link.visuals))
        .collect();
    if settings.payload.mass_kg > 0.0 {
        let shape = Shape::Box { size_m: [settings.payload.size_m; 3] };
        let cube = Geometry { origin: Isometry3::identity(), shape, rgba: PAYLOAD_RGBA };
        let [x, y, z] = settings.payload.position_m;
        bodies.push(body(
            "payload",
            true,
            SceneGroup::Payload,
            &Isometry3::translation(x, y, z),
            &[cube],
        ));
    }
    for (object, robot) in settings.arena.objects.iter().zip(&models.objects) {
        let [x, y, z] = object.position_m;
        let poses =
            link_poses(robot, &Isometry3::translation(x, y, z), &vec![0.0; robot.joints.len()]);
        for (link, pose) in robot.links.iter().zip(poses) {
            let name = format!("{}/{}", object.name, link.name);
            bodies.push(body(&name, false, SceneGroup::Arena, &pose, &link.visuals));
        }
    }
    let rotor = &settings.vehicle.rotor;
    Ok(Scene {
        bodies,
        rotors: settings
            .vehicle
            .rotors
            .iter()
            .map(|r| SceneRotor {
                position_in_body: r.position_m,
                radius_m: rotor.radius_m,
                spin: if r.spin < 0.0 { -1 } else { 1 },
            })
            .collect(),
        base_body: models.robot.links[models.robot.root].name.clone(),
    })
}

fn body(
    name: &str,
    moving: bool,
    group: SceneGroup,
    pose: &Isometry3<f64>,
    shapes: &[Geometry],
) -> SceneBody {
    let q = pose.rotation;
    let pose =
        Pose { position: pose.translation.vector.into(), quaternion_wxyz: [q.w, q.i, q.j, q.k] };
    SceneBody {
        name: name.to_owned(),
        moving,
        group,
        pose,
        shapes: shapes.iter().map(Into::into).collect(),
    }
}
