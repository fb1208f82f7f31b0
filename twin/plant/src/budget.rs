//! Sums the forces on the vehicle over a tick, and compares them with the motion of its mass.
//!
//! In: the forces of each step, Rapier's contacts, poses before and after the last step of a tick. Out: a [`ForceBudget`]. State: the sums
//! and the velocities at the end of the tick before.
//!
//! A velocity is the difference of two positions, so the motion does not depend on the forces that were given to Rapier.

use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d_f64::prelude::*;

use super::STEP_S;
use super::arena::Arena;
use super::articulation::Body;
use super::convert::{from_pose, from_vector};
use twin_core::force_budget::ForceBudget;
use twin_core::notation::{GRAVITY_M_S2, TICK_S};

/// Origin of the root link and centre of mass of the vehicle, or their velocities; m or m/s in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    origin: Vector3<f64>,
    com: Vector3<f64>,
}

impl Pair {
    const ZERO: Self =
        Self { origin: Vector3::new(0.0, 0.0, 0.0), com: Vector3::new(0.0, 0.0, 0.0) };

    fn minus(&self, other: &Self, per: f64) -> Self {
        Self { origin: (self.origin - other.origin) / per, com: (self.com - other.com) / per }
    }
}

/// The budget of the tick under way and of the one before.
#[derive(Clone, Debug)]
pub(super) struct Budget {
    sum: ForceBudget,
    before_last_step: Option<Pair>,
    velocity: Pair,
    /// The budget of the last whole tick.
    pub(super) last: Option<ForceBudget>,
}

impl Budget {
    /// The budget of a vehicle at rest.
    pub(super) fn new() -> Self {
        Self {
            sum: ForceBudget::default(),
            before_last_step: None,
            velocity: Pair::ZERO,
            last: None,
        }
    }

    /// Adds the applied forces of a step; `add` writes them into the sums.
    pub(super) fn add(&mut self, add: impl FnOnce(&mut ForceBudget)) {
        add(&mut self.sum);
    }

    /// Keeps the places of the masses before the last step of a tick. `root` is the pose of the root link.
    pub(super) fn before_last_step(
        &mut self,
        world: &PhysicsWorld,
        bodies: &[Body],
        root: &Isometry3<f64>,
    ) {
        self.before_last_step = Some(places(world, bodies, root));
    }

    /// Adds Rapier's contacts of a step.
    pub(super) fn add_contacts(&mut self, world: &PhysicsWorld, arena: &Arena) {
        for pair in world.contact_pairs() {
            let is_payload = |c| Some(c) == arena.payload_collider;
            let is_other = |c| is_payload(c) || arena.fixed.contains(&c);
            let (a, b) = (pair.collider1, pair.collider2);
            let sign = match (is_other(a), is_other(b)) {
                (true, false) => 1.0,
                (false, true) => -1.0,
                _ => continue,
            };
            let force = force_on_second(pair) * sign;
            if is_payload(a) || is_payload(b) {
                self.sum.payload += force;
            } else {
                self.sum.contact += force;
            }
        }
    }

    /// Ends a tick with `root` as the pose of the root link.
    pub(super) fn end_tick(
        &mut self,
        world: &PhysicsWorld,
        bodies: &[Body],
        root: &Isometry3<f64>,
    ) {
        let Some(before) = self.before_last_step.take() else { return };
        let velocity = places(world, bodies, root).minus(&before, STEP_S);
        let acceleration = velocity.minus(&self.velocity, TICK_S);
        self.velocity = velocity;
        let mass_kg: f64 = bodies.iter().map(|body| body.inertial.mass_kg).sum();
        let mut budget = std::mem::take(&mut self.sum).scaled(STEP_S / TICK_S);
        budget.inertia = acceleration.origin * mass_kg;
        budget.gravity = Vector3::new(0.0, 0.0, -mass_kg * GRAVITY_M_S2);
        budget.arm = (acceleration.origin - acceleration.com) * mass_kg;
        self.last = Some(budget.closed());
    }
}

/// Places of the root link's origin and of the vehicle's centre of mass.
fn places(world: &PhysicsWorld, bodies: &[Body], root: &Isometry3<f64>) -> Pair {
    let mut com = Vector3::zeros();
    let mut mass_kg = 0.0;
    for body in bodies {
        let Some(rigid) = world.bodies.get(body.handle) else { continue };
        let place = from_pose(rigid.position()) * Point3::from(body.inertial.com_in_link);
        com += place.coords * body.inertial.mass_kg;
        mass_kg += body.inertial.mass_kg;
    }
    Pair { origin: root.translation.vector, com: com / mass_kg }
}

/// Force on the second collider of a pair in the last step, N: normal and friction.
fn force_on_second(pair: &ContactPair) -> Vector3<f64> {
    let mut impulse = Vector3::zeros();
    for manifold in pair.solver_manifolds() {
        let normal = from_vector(manifold.data.normal);
        for contact in &manifold.data.solver_contacts {
            let Some(point) = manifold.points.get(contact.contact_indices()[0] as usize) else {
                continue;
            };
            impulse +=
                normal * point.data.impulse - from_vector(point.data.warmstart_tangent_world);
        }
    }
    impulse / STEP_S
}
