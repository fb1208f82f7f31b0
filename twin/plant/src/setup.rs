//! The world, the joints and the cube at the start of a flight.

use nalgebra::{Isometry3, UnitQuaternion, Vector2, Vector3};
use rand::RngExt;
use rand::distr::Distribution;
use rand_pcg::Pcg64;
use rapier3d_f64::prelude::*;

use super::arena::Arena;
use super::gripper::{Gripper, apply_joint_properties};
use super::{Articulation, ContactSettings, PlantError, PlantSettings, STEP_S, VehicleSettings};
use crate::model::Robot;
use twin_core::normal::StandardNormal;
use twin_core::notation::GRAVITY_M_S2;

/// Initial pose of the vehicle and its payload.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Origin of the root link in the world, m.
    pub position: Vector3<f64>,
    /// Arm joint angles, rad.
    pub joints: Vector2<f64>,
    /// Position of the payload in the world if it starts in the closed gripper, m.
    pub grasped: Option<Vector3<f64>>,
    /// Plant steps of 1 ms between two calls of the inner controllers.
    pub inner_steps: u64,
}

/// Rapier's world with everything that was inserted into it.
pub(super) struct BuiltWorld {
    pub(super) world: PhysicsWorld,
    pub(super) articulation: Articulation,
    /// Degrees of freedom of the arm.
    pub(super) arm: Vec<usize>,
    pub(super) gripper: Option<Gripper>,
    pub(super) arena: Arena,
}

/// Vehicle, arena and cube at the start of a flight.
pub(super) fn rig(
    robot: &Robot,
    objects: &[Robot],
    settings: &PlantSettings,
    start: &Start,
    rng: &mut Pcg64,
) -> Result<BuiltWorld, PlantError> {
    let vehicle = &settings.vehicle;
    let mut world = new_world(&settings.contact);
    let root = Isometry3::from_parts(start.position.into(), UnitQuaternion::identity());
    let articulation = Articulation::build(&mut world, robot, &root)?;
    let arm = arm_dofs(robot, &articulation, vehicle)?;
    let joints: Vec<usize> = arm.iter().map(|dof| articulation.dofs[*dof].joint).collect();
    let armature = vehicle.joint_armature_kg_m2;
    apply_joint_properties(&mut world, &articulation, robot, &joints, armature);
    let gripper =
        Gripper::build(&mut world, &articulation, robot, &vehicle.gripper, &vehicle.urdf)?;
    let positions = initial_joints(robot, &articulation, &arm, gripper.as_ref(), start, settings);
    articulation.set_joint_positions(&mut world, &positions);
    let pose = payload_pose(settings, start, rng);
    let arena = Arena::build(&mut world, &settings.arena, objects, &settings.payload, &pose)?;
    Ok(BuiltWorld { world, articulation, arm, gripper, arena })
}

/// An empty world of Rapier with the measured contact settings: stiff contacts, no recycling, gravity along -z.
pub fn new_world(contact: &ContactSettings) -> PhysicsWorld {
    let mut world =
        PhysicsWorld { gravity: Vector::new(0.0, 0.0, -GRAVITY_M_S2), ..PhysicsWorld::default() };
    let parameters = &mut world.integration_parameters;
    parameters.dt = STEP_S;
    parameters.num_solver_iterations = contact.iterations;
    parameters.num_internal_pgs_iterations = contact.sweeps;
    parameters.num_internal_stabilization_iterations = 1;
    parameters.contact_recycling = false;
    parameters.contact_softness = SpringCoefficients::new(contact.frequency_hz, 1.0);
    parameters.static_contact_softness = SpringCoefficients::new(contact.static_frequency_hz, 1.0);
    world
}

/// Degrees of freedom of the arm joints `q1 q2`.
fn arm_dofs(
    robot: &Robot,
    articulation: &Articulation,
    vehicle: &VehicleSettings,
) -> Result<Vec<usize>, PlantError> {
    vehicle
        .arm_joints
        .iter()
        .map(|name| {
            let joint = robot.joint(name);
            articulation.dofs.iter().position(|dof| Some(dof.joint) == joint).ok_or_else(|| {
                PlantError::UnknownName {
                    key: "vehicle.arm_joints",
                    file: vehicle.urdf.clone(),
                    what: "moving joint",
                    name: name.clone(),
                    available: articulation
                        .dofs
                        .iter()
                        .map(|dof| robot.joints[dof.joint].name.as_str())
                        .collect::<Vec<_>>()
                        .join(", "),
                }
            })
        })
        .collect()
}

/// Joint positions at the start: the arm as `start` says, the fingers open or closed on the payload.
fn initial_joints(
    robot: &Robot,
    articulation: &Articulation,
    arm: &[usize],
    gripper: Option<&Gripper>,
    start: &Start,
    settings: &PlantSettings,
) -> Vec<f64> {
    let mut positions = vec![0.0; articulation.dofs.len()];
    for (row, dof) in arm.iter().enumerate() {
        positions[*dof] = start.joints[row];
    }
    for dof in gripper.iter().flat_map(|g| g.fingers()) {
        let joint = &robot.joints[articulation.dofs[*dof].joint];
        positions[*dof] =
            if start.grasped.is_some() { 0.5 * settings.payload.size_m } else { joint.upper };
    }
    positions
}

/// Start pose of the cube, with a seeded random offset.
fn payload_pose(settings: &PlantSettings, start: &Start, rng: &mut Pcg64) -> Isometry3<f64> {
    let payload = &settings.payload;
    let mut scatter = || payload.position_spread_m * (2.0 * rng.random::<f64>() - 1.0);
    let shift = Vector3::new(scatter(), scatter(), 0.0);
    let normal: f64 = StandardNormal.sample(rng);
    let yaw = payload.yaw_std_rad * normal;
    match start.grasped {
        Some(position) => Isometry3::translation(position.x, position.y, position.z),
        None => Isometry3::new(Vector3::from(payload.position_m) + shift, Vector3::z() * yaw),
    }
}
