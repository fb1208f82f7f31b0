//! A [`Robot`] as a Rapier multibody: links tied by fixed joints become one body, every moving joint one degree of freedom.
//!
//! The root body's frame sits at its centre of mass (Rapier integrates the root's origin with the velocity of its centre of
//! mass); every other body's frame is its link frame.

use nalgebra::{DMatrix, Isometry3, Matrix3, Vector3};
use rapier3d_f64::prelude::*;

use super::PlantError;
use super::convert::{from_pose, rotation_matrix, to_pose, to_vector};
use super::lump::{lumped_inertial, mass_properties};
use crate::model::{Geometry, Inertial, JointKind, Robot, Shape};
use twin_input::budget::MOVING_JOINTS;

/// Largest relative difference between the tensor of the URDF and the tensor that Rapier stores; both are f64.
const TENSOR_TOLERANCE: f64 = 1e-9;

/// One rigid body with the links that form it.
#[derive(Clone, Debug)]
pub struct Body {
    /// Rapier's handle.
    pub handle: RigidBodyHandle,
    /// Mass, centre of mass and tensor of all its links, in the body frame.
    pub inertial: Inertial,
    /// Links that form it.
    pub links: Vec<usize>,
}

/// One moving joint.
#[derive(Clone, Debug)]
pub struct Dof {
    /// Index of the joint in the [`Robot`].
    pub joint: usize,
    /// Parent body.
    pub parent: usize,
    /// Child body.
    pub child: usize,
    /// Rapier's handle.
    pub handle: MultibodyJointHandle,
    /// The joint slides (`true`) or turns (`false`).
    pub prismatic: bool,
    /// `parent_body_from_joint` with x along the axis.
    pub(super) frame_in_parent: Pose,
}

/// The vehicle in Rapier's world.
#[derive(Clone, Debug)]
pub struct Articulation {
    /// Bodies, root first.
    pub bodies: Vec<Body>,
    /// Moving joints, parents before children.
    pub dofs: Vec<Dof>,
    /// For each link its body and `body_from_link`.
    pub link_places: Vec<(usize, Isometry3<f64>)>,
    /// For each link the colliders made from it.
    pub colliders: Vec<Vec<ColliderHandle>>,
}

impl Articulation {
    /// Inserts `robot` into `world` with the origin of its root link at `world_from_root`, m. All joints stand at zero; Rapier's own
    /// damping and contacts between the links are off.
    ///
    /// # Errors
    /// [`PlantError`] if Rapier cannot represent a tensor, a mesh has no hull or a joint closes a loop.
    pub fn build(
        world: &mut PhysicsWorld,
        robot: &Robot,
        world_from_root: &Isometry3<f64>,
    ) -> Result<Self, PlantError> {
        let moving = robot.joints.iter().filter(|joint| joint.kind != JointKind::Fixed);
        MOVING_JOINTS.check_count(moving.count())?;
        let mut this = Self::group_links(robot);
        this.insert_bodies(world, robot, world_from_root);
        this.insert_joints(world, robot)?;
        this.insert_colliders(world, robot)?;
        this.check_tensors(world, robot)?;
        if let Some(multibody) = this.multibody_mut(world) {
            multibody.damping_mut().fill(0.0);
            multibody.set_self_contacts_enabled(false);
        }
        Ok(this)
    }

    /// Finds the links that move together, and the pose of each in its body.
    fn group_links(robot: &Robot) -> Self {
        let mut link_places = vec![(0, Isometry3::identity()); robot.links.len()];
        let mut groups = vec![vec![robot.root]];
        for joint in &robot.joints {
            let (parent_body, parent_place) = link_places[joint.parent];
            if joint.kind == JointKind::Fixed {
                link_places[joint.child] = (parent_body, parent_place * joint.origin);
                groups[parent_body].push(joint.child);
            } else {
                link_places[joint.child] = (groups.len(), Isometry3::identity());
                groups.push(vec![joint.child]);
            }
        }
        let lump = |links: &[usize]| lumped_inertial(robot, links, &link_places);
        let root_com = Isometry3::translation(0.0, 0.0, 0.0)
            * Isometry3::from_parts(
                (-lump(&groups[0]).com_in_link).into(),
                nalgebra::UnitQuaternion::identity(),
            );
        for link in &groups[0] {
            link_places[*link].1 = root_com * link_places[*link].1;
        }
        let bodies = groups
            .into_iter()
            .map(|links| Body {
                handle: RigidBodyHandle::invalid(),
                inertial: lumped_inertial(robot, &links, &link_places),
                links,
            })
            .collect();
        Self {
            bodies,
            dofs: Vec::new(),
            link_places,
            colliders: vec![Vec::new(); robot.links.len()],
        }
    }

    fn insert_bodies(
        &mut self,
        world: &mut PhysicsWorld,
        robot: &Robot,
        world_from_root: &Isometry3<f64>,
    ) {
        let poses =
            crate::model::link_poses(robot, world_from_root, &vec![0.0; robot.joints.len()]);
        for body in &mut self.bodies {
            let link = body.links[0];
            let world_from_body = poses[link] * self.link_places[link].1.inverse();
            let builder = RigidBodyBuilder::dynamic()
                .pose(to_pose(&world_from_body))
                .additional_mass_properties(mass_properties(&body.inertial))
                .can_sleep(false);
            body.handle = world.insert_body(builder);
        }
    }

    fn insert_joints(&mut self, world: &mut PhysicsWorld, robot: &Robot) -> Result<(), PlantError> {
        for (index, joint) in robot.joints.iter().enumerate() {
            if joint.kind == JointKind::Fixed {
                continue;
            }
            let (parent, parent_place) = self.link_places[joint.parent];
            let child = self.link_places[joint.child].0;
            let prismatic = joint.kind == JointKind::Prismatic;
            let basis =
                Pose::from_rotation(GenericJoint::complete_ang_frame(to_vector(&joint.axis)));
            let frame_in_parent = to_pose(&(parent_place * joint.origin)) * basis;
            let (mask, axis) = if prismatic {
                (JointAxesMask::LOCKED_PRISMATIC_AXES, JointAxis::LinX)
            } else {
                (JointAxesMask::LOCKED_REVOLUTE_AXES, JointAxis::AngX)
            };
            let mut data = GenericJointBuilder::new(mask)
                .local_frame1(frame_in_parent)
                .local_frame2(basis)
                .contacts_enabled(false);
            if joint.lower.is_finite() && joint.upper.is_finite() {
                data = data.limits(axis, [joint.lower, joint.upper]);
            }
            let handle = world
                .insert_multibody_joint(
                    self.bodies[parent].handle,
                    self.bodies[child].handle,
                    data.build(),
                )
                .ok_or_else(|| PlantError::Loop { joint: joint.name.clone() })?;
            self.dofs.push(Dof { joint: index, parent, child, handle, prismatic, frame_in_parent });
        }
        Ok(())
    }

    fn insert_colliders(
        &mut self,
        world: &mut PhysicsWorld,
        robot: &Robot,
    ) -> Result<(), PlantError> {
        for (index, link) in robot.links.iter().enumerate() {
            let (body, place) = self.link_places[index];
            for geometry in &link.collisions {
                let collider = collider(geometry, &place, &link.name)?.density(0.0);
                let PhysicsWorld { colliders, bodies, .. } = world;
                let handle =
                    colliders.insert_with_parent(collider, self.bodies[body].handle, bodies);
                self.colliders[index].push(handle);
            }
        }
        Ok(())
    }

    /// Compares the tensors that Rapier stores with those of the URDF.
    fn check_tensors(&self, world: &mut PhysicsWorld, robot: &Robot) -> Result<(), PlantError> {
        let PhysicsWorld { bodies, colliders, .. } = world;
        for body in &self.bodies {
            let Some(rigid) = bodies.get_mut(body.handle) else { continue };
            rigid.recompute_mass_properties_from_colliders(colliders);
            let stored = rigid.mass_properties().local_mprops.reconstruct_inertia_matrix();
            let stored = Matrix3::from_columns(
                &[stored.x_axis, stored.y_axis, stored.z_axis].map(super::convert::from_vector),
            );
            let wanted = body.inertial.inertia_in_link;
            let relative_error = (stored - wanted).norm() / wanted.norm();
            if relative_error.is_nan() || relative_error > TENSOR_TOLERANCE {
                return Err(PlantError::Inertia {
                    link: robot.links[body.links[0]].name.clone(),
                    relative_error,
                });
            }
        }
        Ok(())
    }

    /// The multibody, if the vehicle has a moving joint.
    pub fn multibody<'a>(&self, world: &'a PhysicsWorld) -> Option<&'a Multibody> {
        self.dofs
            .first()
            .and_then(|dof| world.multibody_joints.get(dof.handle))
            .map(|(multibody, _)| multibody)
    }

    /// The multibody for changes, if the vehicle has a moving joint.
    pub fn multibody_mut<'a>(&self, world: &'a mut PhysicsWorld) -> Option<&'a mut Multibody> {
        let handle = self.dofs.first()?.handle;
        world.multibody_joints.get_mut(handle).map(|(multibody, _)| multibody)
    }

    /// Places of the joints' rates in the generalised velocity of the multibody, in the order of [`Self::dofs`].
    pub(super) fn columns(&self, world: &PhysicsWorld) -> Vec<usize> {
        let column = |dof: &Dof| {
            let (multibody, link) = world.multibody_joints.get(dof.handle)?;
            multibody.link(link).map(MultibodyLink::assembly_id)
        };
        self.dofs.iter().filter_map(column).collect()
    }

    /// Position and rate of a moving joint (index into [`Self::dofs`]), rad and rad/s or m and m/s.
    pub fn joint_state(&self, world: &PhysicsWorld, dof: usize) -> (f64, f64) {
        let dof = &self.dofs[dof];
        let Some((multibody, link)) = world.multibody_joints.get(dof.handle) else {
            return (0.0, 0.0);
        };
        let Some(link) = multibody.link(link) else { return (0.0, 0.0) };
        let coordinates = link.joint().coords();
        let position = if dof.prismatic { coordinates[0] } else { coordinates[3] };
        (position, multibody.joint_velocity(link)[0])
    }

    /// Moves the joints from zero to `positions`, rad or m, in the order of [`Self::dofs`].
    pub fn set_joint_positions(&self, world: &mut PhysicsWorld, positions: &[f64]) {
        let PhysicsWorld { multibody_joints, bodies, .. } = world;
        let Some(first) = self.dofs.first() else { return };
        let mut displacement = vec![0.0; 6 + self.dofs.len()];
        for (dof, position) in self.dofs.iter().zip(positions) {
            if let Some((multibody, link)) = multibody_joints.get(dof.handle)
                && let Some(link) = multibody.link(link)
            {
                displacement[link.assembly_id()] = *position;
            }
        }
        if let Some((multibody, _)) = multibody_joints.get_mut(first.handle) {
            multibody.apply_displacements(&displacement);
            multibody.forward_kinematics(bodies, true);
            multibody.update_rigid_bodies(bodies, true);
        }
    }

    /// Clears every force and torque that was applied to the bodies.
    pub fn clear_forces(&self, world: &mut PhysicsWorld) {
        for body in &self.bodies {
            if let Some(rigid) = world.bodies.get_mut(body.handle) {
                rigid.reset_forces(false);
                rigid.reset_torques(false);
            }
        }
    }

    /// Applies a joint torque (N m) or force (N) to the child, and the opposite of it to the parent.
    pub fn apply_joint_effort(&self, world: &mut PhysicsWorld, dof: usize, effort: f64) {
        let dof = &self.dofs[dof];
        let (parent, child) = (self.bodies[dof.parent].handle, self.bodies[dof.child].handle);
        let Some(parent_pose) = world.bodies.get(parent).map(|b| *b.position()) else { return };
        let axis = (parent_pose * dof.frame_in_parent).rotation * Vector::X;
        let Some(child_com) = world.bodies.get_mut(child).map(|body| {
            if dof.prismatic {
                body.add_force(axis * effort, true);
            } else {
                body.add_torque(axis * effort, true);
            }
            body.center_of_mass()
        }) else {
            return;
        };
        if let Some(body) = world.bodies.get_mut(parent) {
            if dof.prismatic {
                body.add_force_at_point(-axis * effort, child_com, true);
            } else {
                body.add_torque(-axis * effort, true);
            }
        }
    }

    /// `world_from_link` of link number `link`, m.
    pub fn link_pose(&self, world: &PhysicsWorld, link: usize) -> Isometry3<f64> {
        let (body, place) = self.link_places[link];
        world
            .bodies
            .get(self.bodies[body].handle)
            .map_or(place, |b| from_pose(b.position()) * place)
    }

    /// Joint-space mass matrix `M = sum J^T diag(m, R I R^T) J`, square, in Rapier's order: linear and angular velocity of the root in
    /// the world, then joints. Tests compare it with an independent model.
    pub fn mass_matrix(&self, world: &PhysicsWorld) -> DMatrix<f64> {
        let Some(multibody) = self.multibody(world) else { return DMatrix::zeros(0, 0) };
        let mut m = DMatrix::zeros(multibody.ndofs(), multibody.ndofs());
        for link in multibody.links() {
            let Some(body) = self.bodies.iter().find(|b| b.handle == link.rigid_body_handle())
            else {
                continue;
            };
            let Some(rigid) = world.bodies.get(body.handle) else { continue };
            let jacobian = multibody.body_jacobian(link.link_id());
            let r = rotation_matrix(rigid.position().rotation);
            let (linear, angular) = (jacobian.fixed_rows::<3>(0), jacobian.fixed_rows::<3>(3));
            let inertia = r * body.inertial.inertia_in_link * r.transpose();
            m += linear.transpose() * linear * body.inertial.mass_kg
                + angular.transpose() * (inertia * angular);
        }
        m
    }
}

/// A collider for `geometry` of a link that sits at `place` in its body.
pub(super) fn collider(
    geometry: &Geometry,
    place: &Isometry3<f64>,
    link: &str,
) -> Result<ColliderBuilder, PlantError> {
    use std::f64::consts::FRAC_PI_2;
    let upright = Isometry3::rotation(Vector3::x() * FRAC_PI_2);
    let (builder, turn) = match &geometry.shape {
        Shape::Box { size_m: [x, y, z] } => {
            (ColliderBuilder::cuboid(x * 0.5, y * 0.5, z * 0.5), Isometry3::identity())
        }
        Shape::Sphere { radius_m } => (ColliderBuilder::ball(*radius_m), Isometry3::identity()),
        Shape::Cylinder { radius_m, length_m } => {
            (ColliderBuilder::cylinder(length_m * 0.5, *radius_m), upright)
        }
        Shape::Capsule { radius_m, length_m } => {
            (ColliderBuilder::capsule_z(length_m * 0.5, *radius_m), Isometry3::identity())
        }
        Shape::Mesh { vertices, .. } => {
            let points: Vec<Vector> =
                vertices.iter().map(|v| Vector::new(v[0], v[1], v[2])).collect();
            let hull = ColliderBuilder::convex_hull(&points)
                .ok_or_else(|| PlantError::Hull { link: link.to_owned() })?;
            (hull, Isometry3::identity())
        }
    };
    Ok(builder.position(to_pose(&(place * geometry.origin * turn))))
}
