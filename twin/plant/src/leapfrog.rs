//! Rapier's step as the leapfrog method, which is second order at the cost of Euler's.
//!
//! Rapier cuts a step of length h into n substeps. Each substep adds `a(x) h/n` to the velocity and then moves the bodies with the new
//! velocity. Read as Euler's method, this is first order: its velocity lags by half a substep. Read as the leapfrog method (Verlet 1967),
//! the velocity belongs to the instant `lag = h / 2n` before the instant of the position, and the method is second order in all forces
//! that depend on positions and time. Two rules follow:
//! - the velocity at the instant of the position is the stored one plus the acceleration of the last step times the lag;
//! - an input that is constant between two steps acts in the interval of the velocities, so that a share of the previous input remains.
//!
//! Rapier takes the viscous damping of a joint at the end of a substep. This file lowers the joint's armature by `d h / 2n`, which moves
//! the damping to the middle of the substep; [`super::coriolis`] does the same for inertial forces.

use nalgebra::Vector6;
use rapier3d_f64::prelude::*;

use super::STEP_S;
use super::articulation::Articulation;
use super::convert::{from_vector, to_vector};
use super::coriolis;
use super::velocities::Velocities;

/// Substeps of the first step. The velocity of a start belongs to the instant of its position, so the lag must be small.
const FIRST_SUBSTEPS: usize = 32;

/// Largest share of a joint's inertia by which its armature is lowered. Beyond it, damping stays at the end of the substep, which never
/// oscillates.
const LARGEST_SHARE: f64 = 0.5;

/// A joint in the multibody.
#[derive(Clone, Copy, Debug)]
struct Joint {
    /// Its place in the generalised velocity.
    column: usize,
    /// Armature as the vehicle has it, kg m² or kg.
    armature: f64,
    /// Damping that acts in the middle of a substep, N m s/rad or N s/m.
    damping: f64,
}

/// The lag of Rapier's velocities, and how they changed in the last step.
#[derive(Clone, Debug)]
pub(super) struct Leapfrog {
    substeps: usize,
    joints: Vec<Joint>,
    /// Change of the stored velocities in the last step.
    change: Velocities,
}

impl Leapfrog {
    /// The method for a vehicle at the start of a flight.
    pub(super) fn new(world: &mut PhysicsWorld, articulation: &Articulation) -> Self {
        let joints = joints(world, articulation);
        let change = Velocities { root: Vector6::zeros(), joints: vec![0.0; joints.len()] };
        let mut this = Self { substeps: 1, joints, change };
        this.set_substeps(world, articulation, FIRST_SUBSTEPS);
        this
    }

    /// Lag of the velocity as a share of a step. This is also the share of the previous input in the next step.
    pub(super) fn lag(&self) -> f64 {
        0.5 / self.substeps as f64
    }

    /// Lets Rapier step, and keeps the change of the velocities.
    pub(super) fn step(&mut self, world: &mut PhysicsWorld, articulation: &Articulation) {
        let before = self.stored(world, articulation);
        coriolis::centre(world, articulation, &before, &self.change, self.lag());
        world.step();
        self.change = self.stored(world, articulation).plus(&before, -1.0);
    }

    /// Velocities at the instant of the positions.
    pub(super) fn velocities(
        &self,
        world: &PhysicsWorld,
        articulation: &Articulation,
    ) -> Velocities {
        self.stored(world, articulation).plus(&self.change, self.lag())
    }

    /// Ends the first step: sets the number of substeps of all further steps, and moves the velocities to the instant that belongs to it.
    /// A vehicle that touches something keeps them, because an impact is over when it has changed them.
    pub(super) fn start(
        &mut self,
        world: &mut PhysicsWorld,
        articulation: &Articulation,
        substeps: usize,
        touching: bool,
    ) {
        let old = self.lag();
        self.set_substeps(world, articulation, substeps);
        if !touching {
            let now = self.stored(world, articulation);
            self.store(world, articulation, &now.plus(&self.change, old - self.lag()));
        }
    }

    fn set_substeps(
        &mut self,
        world: &mut PhysicsWorld,
        articulation: &Articulation,
        substeps: usize,
    ) {
        self.substeps = substeps;
        world.integration_parameters.num_solver_iterations = substeps;
        let Some(multibody) = articulation.multibody_mut(world) else { return };
        for joint in &self.joints {
            let middle = joint.damping * self.lag() * STEP_S;
            multibody.armature_mut()[joint.column] = joint.armature - middle;
        }
    }

    /// The velocities that Rapier stores.
    fn stored(&self, world: &PhysicsWorld, articulation: &Articulation) -> Velocities {
        if let Some(multibody) = articulation.multibody(world) {
            let all = multibody.generalized_velocity();
            Velocities {
                root: all.fixed_rows::<6>(0).into_owned(),
                joints: self.joints.iter().map(|joint| all[joint.column]).collect(),
            }
        } else {
            let body = world.bodies.get(articulation.bodies[0].handle);
            let root = body.map_or_else(Vector6::zeros, |body| {
                let (v, omega) = (from_vector(body.linvel()), from_vector(body.angvel()));
                Vector6::new(v.x, v.y, v.z, omega.x, omega.y, omega.z)
            });
            Velocities { root, joints: Vec::new() }
        }
    }

    /// Replaces the velocities that Rapier stores.
    fn store(&self, world: &mut PhysicsWorld, articulation: &Articulation, new: &Velocities) {
        if let Some(multibody) = articulation.multibody_mut(world) {
            let mut all = multibody.generalized_velocity_mut();
            all.fixed_rows_mut::<6>(0).copy_from(&new.root);
            for (joint, rate) in self.joints.iter().zip(&new.joints) {
                all[joint.column] = *rate;
            }
        } else if let Some(body) = world.bodies.get_mut(articulation.bodies[0].handle) {
            let part = |first| to_vector(&new.root.fixed_rows::<3>(first).into_owned());
            body.set_linvel(part(0), true);
            body.set_angvel(part(3), true);
        }
    }
}

/// The joints of the vehicle. A damping acts in the middle of a substep if it is small enough for whole steps.
fn joints(world: &mut PhysicsWorld, articulation: &Articulation) -> Vec<Joint> {
    let columns = articulation.columns(world);
    let PhysicsWorld { multibody_joints, bodies, .. } = world;
    let Some(first) = articulation.dofs.first() else { return Vec::new() };
    let Some((multibody, _)) = multibody_joints.get_mut(first.handle) else { return Vec::new() };
    let mobility = multibody.dof_inverse_inertia(bodies);
    let joint = |column: usize| {
        let damping = multibody.damping()[column];
        let small = 0.5 * damping * STEP_S * mobility[column] <= LARGEST_SHARE;
        let armature = multibody.armature()[column];
        Joint { column, armature, damping: if small { damping } else { 0.0 } }
    };
    columns.into_iter().map(joint).collect()
}
