//! Moves the velocity-dependent inertial forces to the middle of a substep.
//!
//! Rapier takes Coriolis, centrifugal and gyroscopic forces `b(v)` of a multibody at the end of a substep (semi-implicit), which is first
//! order. In the middle they are `(b(v-) + b(v+)) / 2`, so Rapier's differ by `(b(v+) - b(v-)) / 2`. This file computes that difference
//! from the change of the velocities in the last step.

use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

use super::articulation::{Articulation, Dof};
use super::convert::{from_vector, rotation_matrix, to_vector};
use super::velocities::Velocities;

/// Angular velocity of a body, and the accelerations that velocities alone cause, in the world.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// Angular velocity, rad/s.
    omega: Vector3<f64>,
    /// Angular acceleration, rad/s².
    alpha: Vector3<f64>,
    /// Acceleration of the centre of mass, m/s².
    acceleration: Vector3<f64>,
}

impl Motion {
    /// The motion of a point of the same body at `offset` from this one.
    fn carried(&self, offset: &Vector3<f64>) -> Self {
        let centrifugal = self.omega.cross(&self.omega.cross(offset));
        let acceleration = self.acceleration + self.alpha.cross(offset) + centrifugal;
        Self { acceleration, ..*self }
    }

    /// The motion of the child of a sliding joint: the centre of mass of the child stands at `offset` from that of the parent.
    fn slid(&self, along: &Vector3<f64>, offset: &Vector3<f64>) -> Self {
        let mut child = self.carried(offset);
        child.acceleration += 2.0 * self.omega.cross(along);
        child
    }

    /// The motion of the child of a turning joint, whose pivot lies between the two centres of mass.
    fn turned(
        &self,
        about: &Vector3<f64>,
        to_pivot: &Vector3<f64>,
        from_pivot: &Vector3<f64>,
    ) -> Self {
        let pivot = self.carried(to_pivot);
        let omega = self.omega + about;
        let alpha = self.alpha + self.omega.cross(about);
        Self { omega, alpha, ..pivot }.carried(from_pivot)
    }
}

/// Motions of all bodies for two sets of velocities.
struct Pair([Motion; 2]);

impl Pair {
    fn child(
        &self,
        world: &PhysicsWorld,
        articulation: &Articulation,
        dof: &Dof,
        rates: [f64; 2],
    ) -> Self {
        let body = |index: usize| world.bodies.get(articulation.bodies[index].handle);
        let (Some(parent), Some(child)) = (body(dof.parent), body(dof.child)) else {
            return Self(self.0);
        };
        let joint = *parent.position() * dof.frame_in_parent;
        let axis = from_vector(joint.rotation * Vector::X);
        let (from, to) = (parent.center_of_mass(), child.center_of_mass());
        let to_pivot = from_vector(joint.translation - from);
        let from_pivot = from_vector(to - joint.translation);
        let offset = from_vector(to - from);
        Self(std::array::from_fn(|set| {
            let along = axis * rates[set];
            if dof.prismatic {
                self.0[set].slid(&along, &offset)
            } else {
                self.0[set].turned(&along, &to_pivot, &from_pivot)
            }
        }))
    }
}

/// Adds `share` of `b(v + change) - b(v)` to the forces on the bodies of a multibody.
pub(super) fn centre(
    world: &mut PhysicsWorld,
    articulation: &Articulation,
    v: &Velocities,
    change: &Velocities,
    share: f64,
) {
    if articulation.dofs.is_empty() {
        return;
    }
    let omega = |part: &Velocities| part.root.fixed_rows::<3>(3).into_owned();
    let root = [omega(v), omega(v) + omega(change)];
    let mut pairs = Vec::with_capacity(articulation.bodies.len());
    pairs.push(Pair(root.map(|omega| Motion { omega, ..Motion::default() })));
    // A joint makes the next body, and parents stand before their children.
    for (index, dof) in articulation.dofs.iter().enumerate() {
        let rates = [v.joints[index], v.joints[index] + change.joints[index]];
        let parent: &Pair = &pairs[dof.parent];
        pairs.push(parent.child(world, articulation, dof, rates));
    }
    for (body, Pair([before, after])) in articulation.bodies.iter().zip(&pairs) {
        let Some(rigid) = world.bodies.get_mut(body.handle) else { continue };
        let r = rotation_matrix(rigid.position().rotation);
        let tensor = r * body.inertial.inertia_in_link * r.transpose();
        // Newton and Euler: m a, and I alpha + omega x I omega.
        let force = (after.acceleration - before.acceleration) * body.inertial.mass_kg;
        let gyroscopic = |m: &Motion| tensor * m.alpha + m.omega.cross(&(tensor * m.omega));
        let torque = gyroscopic(after) - gyroscopic(before);
        rigid.add_force(to_vector(&(force * share)), true);
        rigid.add_torque(to_vector(&(torque * share)), true);
    }
}
