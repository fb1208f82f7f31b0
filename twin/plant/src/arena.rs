//! The arena: floor, box, table and cube. It also gives the heights of surfaces for the ground effect.

use nalgebra::{Isometry3, Vector3};
use rapier3d_f64::prelude::*;

use super::articulation::collider;
use super::convert::{to_pose, to_vector};
use super::{ArenaSettings, PayloadSettings, PlantError};
use crate::model::{Robot, Shape, link_poses};

/// Half edge of the floor slab, m.
const FLOOR_HALF_M: f64 = 20.0;

/// A horizontal surface.
#[derive(Clone, Copy, Debug)]
struct Surface {
    low: [f64; 2],
    high: [f64; 2],
    height_m: f64,
}

/// Everything that stands around the vehicle.
#[derive(Clone, Debug, Default)]
pub(super) struct Arena {
    surfaces: Vec<Surface>,
    /// The cube, if there is one.
    pub(super) payload: Option<RigidBodyHandle>,
    /// Its collider.
    pub(super) payload_collider: Option<ColliderHandle>,
    /// Colliders of floor and objects.
    pub(super) fixed: Vec<ColliderHandle>,
}

impl Arena {
    /// Inserts floor, objects (already loaded, in the order of the settings) and the cube at `payload_pose`.
    pub(super) fn build(
        world: &mut PhysicsWorld,
        settings: &ArenaSettings,
        objects: &[Robot],
        payload: &PayloadSettings,
        payload_pose: &Isometry3<f64>,
    ) -> Result<Self, PlantError> {
        let mut this = Self::default();
        let floor = ColliderBuilder::cuboid(FLOOR_HALF_M, FLOOR_HALF_M, 0.5)
            .translation(Vector::new(0.0, 0.0, -0.5))
            .friction(settings.friction);
        this.fixed.push(world.colliders.insert(floor));
        this.surfaces.push(Surface {
            low: [-FLOOR_HALF_M; 2],
            high: [FLOOR_HALF_M; 2],
            height_m: 0.0,
        });
        for (object, robot) in settings.objects.iter().zip(objects) {
            this.add_object(world, robot, &Vector3::from(object.position_m), settings.friction)?;
        }
        if payload.mass_kg > 0.0 {
            this.add_payload(world, payload, payload_pose);
        }
        Ok(this)
    }

    fn add_object(
        &mut self,
        world: &mut PhysicsWorld,
        robot: &Robot,
        position: &Vector3<f64>,
        friction: f64,
    ) -> Result<(), PlantError> {
        let world_from_root = Isometry3::translation(position.x, position.y, position.z);
        let poses = link_poses(robot, &world_from_root, &vec![0.0; robot.joints.len()]);
        for (link, pose) in robot.links.iter().zip(&poses) {
            for geometry in &link.collisions {
                let builder = collider(geometry, pose, &link.name)?.friction(friction);
                self.fixed.push(world.colliders.insert(builder));
                if let Shape::Box { size_m: [x, y, z] } = geometry.shape {
                    let centre = (pose * geometry.origin).translation.vector;
                    self.surfaces.push(Surface {
                        low: [centre.x - 0.5 * x, centre.y - 0.5 * y],
                        high: [centre.x + 0.5 * x, centre.y + 0.5 * y],
                        height_m: centre.z + 0.5 * z,
                    });
                }
            }
        }
        Ok(())
    }

    fn add_payload(
        &mut self,
        world: &mut PhysicsWorld,
        payload: &PayloadSettings,
        pose: &Isometry3<f64>,
    ) {
        let half = 0.5 * payload.size_m;
        let body = RigidBodyBuilder::dynamic()
            .pose(to_pose(pose))
            .additional_mass_properties(cube_mass(payload))
            .can_sleep(false);
        let cube =
            ColliderBuilder::cuboid(half, half, half).density(0.0).friction(payload.friction);
        let (body, cube) = world.insert(body, cube);
        (self.payload, self.payload_collider) = (Some(body), Some(cube));
    }

    /// Changes the mass of the cube between two steps.
    pub(super) fn set_payload(&self, world: &mut PhysicsWorld, payload: &PayloadSettings) {
        if let Some(body) = self.payload.and_then(|handle| world.bodies.get_mut(handle)) {
            body.set_additional_mass_properties(cube_mass(payload), true);
        }
    }

    /// Whether the vehicle touches something or is about to.
    pub(super) fn vehicle_touches(&self, world: &PhysicsWorld) -> bool {
        let other =
            |collider| self.fixed.contains(&collider) || Some(collider) == self.payload_collider;
        world.contact_pairs().any(|pair| {
            pair.has_any_active_contact() && !(other(pair.collider1) && other(pair.collider2))
        })
    }

    /// Height of the highest surface below `point`, m.
    pub(super) fn height_below(&self, point: &Vector3<f64>) -> f64 {
        let over = |s: &&Surface| {
            point.x >= s.low[0]
                && point.x <= s.high[0]
                && point.y >= s.low[1]
                && point.y <= s.high[1]
        };
        self.surfaces
            .iter()
            .filter(over)
            .map(|s| s.height_m)
            .filter(|height| *height <= point.z)
            .fold(0.0, f64::max)
    }
}

/// The moments of inertia of a homogeneous cube, `I = m a² / 6`, about the centre of mass, wherever that is.
fn cube_mass(payload: &PayloadSettings) -> MassProperties {
    let i = payload.mass_kg * payload.size_m * payload.size_m / 6.0;
    let com = to_vector(&Vector3::from(payload.centre_of_mass_m));
    MassProperties::new(com, payload.mass_kg, to_vector(&Vector3::repeat(i)))
}
