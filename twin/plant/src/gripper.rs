//! The gripper: one force-limited velocity motor drives coupled fingers. Friction between colliders holds the payload; nothing is
//! welded.

use rapier3d_f64::prelude::*;

use super::{Articulation, GripperSettings, PlantError};
use crate::model::Robot;
use twin_core::tick::{GripperCommand, GripperReading};

/// Product of motor damping and closing speed, as a multiple of the grip force. Below 1 the motor would not reach the grip force.
const MOTOR_HEADROOM: f64 = 1.5;

/// Fingers and palm of the vehicle.
#[derive(Clone, Debug)]
pub(super) struct Gripper {
    /// Degrees of freedom of both fingers, leader first.
    fingers: Vec<usize>,
    /// Colliders of the fingers.
    pub(super) pads: Vec<ColliderHandle>,
    /// Palm link.
    pub(super) palm: usize,
    settings: GripperSettings,
    command: Option<GripperCommand>,
}

impl Gripper {
    /// The gripper of `robot`, or `None` if the scenario names none.
    pub(super) fn build(
        world: &mut PhysicsWorld,
        articulation: &Articulation,
        robot: &Robot,
        settings: &GripperSettings,
        urdf: &str,
    ) -> Result<Option<Self>, PlantError> {
        if settings.joint.is_empty() {
            return Ok(None);
        }
        let names = |items: Vec<&str>| items.join(", ");
        let leader = robot.joint(&settings.joint).ok_or_else(|| PlantError::UnknownName {
            key: "vehicle.gripper.joint",
            file: urdf.to_owned(),
            what: "joint",
            name: settings.joint.clone(),
            available: names(robot.joints.iter().map(|j| j.name.as_str()).collect()),
        })?;
        let palm = robot.link(&settings.palm_link).ok_or_else(|| PlantError::UnknownName {
            key: "vehicle.gripper.palm_link",
            file: urdf.to_owned(),
            what: "link",
            name: settings.palm_link.clone(),
            available: names(robot.links.iter().map(|l| l.name.as_str()).collect()),
        })?;
        let follows = |joint: usize| {
            joint == leader || robot.joints[joint].mimic.is_some_and(|m| m.joint == leader)
        };
        let mut fingers: Vec<usize> = (0..articulation.dofs.len())
            .filter(|dof| {
                follows(articulation.dofs[*dof].joint) && articulation.dofs[*dof].prismatic
            })
            .collect();
        fingers.sort_by_key(|dof| articulation.dofs[*dof].joint != leader);
        let pads: Vec<ColliderHandle> = fingers
            .iter()
            .flat_map(|dof| {
                articulation.colliders[robot.joints[articulation.dofs[*dof].joint].child].clone()
            })
            .collect();
        for pad in &pads {
            if let Some(collider) = world.colliders.get_mut(*pad) {
                collider.set_friction(settings.friction);
            }
        }
        Ok(Some(Self { fingers, pads, palm, settings: settings.clone(), command: None }))
    }

    /// Distance between the pads, m, and its rate, m/s.
    pub(super) fn reading(
        &self,
        world: &PhysicsWorld,
        articulation: &Articulation,
    ) -> GripperReading {
        self.fingers.iter().map(|dof| articulation.joint_state(world, *dof)).fold(
            GripperReading::default(),
            |sum, (position, rate)| GripperReading {
                opening_m: sum.opening_m + position,
                speed_m_s: sum.speed_m_s + rate,
            },
        )
    }

    /// Drives the fingers to the command; does nothing while the command stays the same.
    pub(super) fn drive(
        &mut self,
        world: &mut PhysicsWorld,
        articulation: &Articulation,
        command: GripperCommand,
    ) {
        if self.command == Some(command) {
            return;
        }
        self.command = Some(command);
        let speed_m_s = match command {
            GripperCommand::Open => self.settings.open_m_s,
            GripperCommand::Close => -self.settings.close_m_s,
        };
        let damping = MOTOR_HEADROOM * self.settings.force_n / speed_m_s.abs().max(1e-3);
        for dof in &self.fingers {
            let handle = articulation.dofs[*dof].handle;
            let Some((multibody, link)) = world.multibody_joints.get_mut(handle) else { continue };
            let Some(link) = multibody.link_mut(link) else { continue };
            let data = &mut link.joint.data;
            data.set_motor(JointAxis::LinX, 0.0, speed_m_s, 0.0, damping);
            data.set_motor_model(JointAxis::LinX, MotorModel::ForceBased);
            data.set_motor_max_force(JointAxis::LinX, self.settings.force_n);
        }
    }

    /// Degrees of freedom of the fingers.
    pub(super) fn fingers(&self) -> &[usize] {
        &self.fingers
    }
}

/// Couples each mimicking joint to its leader, and gives every joint its damping and friction from the URDF and the armature of
/// the arm.
pub(super) fn apply_joint_properties(
    world: &mut PhysicsWorld,
    articulation: &Articulation,
    robot: &Robot,
    arm: &[usize],
    armature_kg_m2: f64,
) {
    let ids: Vec<Option<usize>> = articulation
        .dofs
        .iter()
        .map(|dof| world.multibody_joints.get(dof.handle).map(|(_, link)| link))
        .collect();
    let Some(multibody) = articulation.multibody_mut(world) else { return };
    for (dof, id) in articulation.dofs.iter().zip(&ids) {
        let Some(id) = *id else { continue };
        let joint = &robot.joints[dof.joint];
        let Some(column) = multibody.link(id).map(MultibodyLink::assembly_id) else { continue };
        multibody.damping_mut()[column] = joint.damping;
        multibody.frictions_mut()[column] = joint.friction;
        if arm.contains(&dof.joint) {
            multibody.armature_mut()[column] = armature_kg_m2;
        }
        let Some(mimic) = joint.mimic else { continue };
        let leader = articulation.dofs.iter().position(|d| d.joint == mimic.joint);
        let Some(leader_id) = leader.and_then(|l| ids[l]) else { continue };
        let axis = |prismatic: bool| if prismatic { 0 } else { 3 };
        multibody.add_dof_coupling(MultibodyDofCoupling {
            link1: leader_id,
            dof1: 0,
            axis1: axis(leader.is_some_and(|l| articulation.dofs[l].prismatic)),
            link2: id,
            dof2: 0,
            axis2: axis(dof.prismatic),
            coeff: mimic.multiplier,
            offset: mimic.offset,
        });
    }
}
