//! Rapier's world as something that can be copied, so that a flight can be copied whole.
//!
//! The copy has everything that lasts from one step to the next: bodies, colliders, joints, islands, the tree of bounding boxes, and the
//! contacts with the impulses from which the next solution starts. The pipelines are working memory, which each world makes for itself.

use std::ops::{Deref, DerefMut};

use rapier3d_f64::prelude::*;

/// The world of one simulated vehicle.
pub(super) struct World(pub(super) PhysicsWorld);

impl Clone for World {
    fn clone(&self) -> Self {
        let PhysicsWorld {
            gravity,
            integration_parameters,
            physics_pipeline: _,
            collision_pipeline: _,
            islands,
            broad_phase,
            narrow_phase,
            bodies,
            colliders,
            impulse_joints,
            multibody_joints,
            soft_bodies,
            ccd_solver,
        } = &self.0;
        Self(PhysicsWorld {
            gravity: *gravity,
            integration_parameters: *integration_parameters,
            physics_pipeline: PhysicsPipeline::new(),
            collision_pipeline: CollisionPipeline::new(),
            islands: islands.clone(),
            broad_phase: broad_phase.clone(),
            narrow_phase: narrow_phase.clone(),
            bodies: bodies.clone(),
            colliders: colliders.clone(),
            impulse_joints: impulse_joints.clone(),
            multibody_joints: multibody_joints.clone(),
            soft_bodies: soft_bodies.clone(),
            ccd_solver: ccd_solver.clone(),
        })
    }
}

impl Deref for World {
    type Target = PhysicsWorld;

    fn deref(&self) -> &PhysicsWorld {
        &self.0
    }
}

impl DerefMut for World {
    fn deref_mut(&mut self) -> &mut PhysicsWorld {
        &mut self.0
    }
}
