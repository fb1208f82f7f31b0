//! A free rigid body: a vehicle alone in Rapier's world under a given wrench, without ground, air, rotors, sensors and noise.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use rapier3d_f64::prelude::*;

use super::convert::{from_pose, from_vector, rotation_matrix, to_pose, to_vector};
use super::lump::{lumped_inertial, mass_properties};
use super::{STEP_S, STEPS_PER_TICK};
use crate::model::{Inertial, Robot, link_poses};
use twin_core::notation::GRAVITY_M_S2;

/// Pose and velocity of the root link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Origin of the root link in the world, m.
    pub position: Vector3<f64>,
    /// `world_from_body`.
    pub rotation: Matrix3<f64>,
    /// Velocity of the root link's origin in the world, m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity in the body, rad/s.
    pub body_rate: Vector3<f64>,
}

/// Force and torque that act on the body during a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrench {
    /// Acts at the origin of the root link; the body turns freely.
    Free {
        /// Force and torque in the body frame, N and N m. Their axes turn with the body.
        in_body: [Vector3<f64>; 2],
        /// Force in the world, N.
        in_world: Vector3<f64>,
    },
    /// Force in the world, N. The body keeps its attitude.
    Held(Vector3<f64>),
}

/// Mass, centre of mass and inertia of the whole `robot` in its root link, with its joints locked at `angles` (one for each joint,
/// rad or m).
pub fn locked(robot: &Robot, angles: &[f64]) -> Inertial {
    let poses = link_poses(robot, &Isometry3::identity(), angles);
    let places: Vec<_> = poses.into_iter().map(|pose| (0, pose)).collect();
    lumped_inertial(robot, &(0..robot.links.len()).collect::<Vec<_>>(), &places)
}

/// One rigid body alone in Rapier's world.
pub struct FreeBody {
    world: PhysicsWorld,
    handle: RigidBodyHandle,
    com_in_root: Vector3<f64>,
}

impl FreeBody {
    /// A body with this mass, centre of mass and inertia in the root link.
    pub fn new(inertial: &Inertial) -> Self {
        let mut world = PhysicsWorld {
            gravity: Vector::new(0.0, 0.0, -GRAVITY_M_S2),
            ..PhysicsWorld::default()
        };
        world.integration_parameters.dt = STEP_S;
        world.integration_parameters.num_solver_iterations = 1;
        let builder = RigidBodyBuilder::dynamic()
            .additional_mass_properties(mass_properties(inertial))
            .can_sleep(false);
        let handle = world.insert_body(builder);
        Self { world, handle, com_in_root: inertial.com_in_link }
    }

    /// Sets pose and velocity of the body.
    pub fn put(&mut self, motion: &Motion) {
        let Self { world, handle, com_in_root } = self;
        let PhysicsWorld { bodies, colliders, .. } = world;
        let Some(body) = bodies.get_mut(*handle) else { return };
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
            motion.rotation,
        ));
        body.set_position(to_pose(&Isometry3::from_parts(motion.position.into(), rotation)), true);
        let omega = motion.rotation * motion.body_rate;
        let com_velocity = motion.velocity + omega.cross(&(motion.rotation * *com_in_root));
        body.set_linvel(to_vector(&com_velocity), true);
        body.set_angvel(to_vector(&omega), true);
        body.recompute_mass_properties_from_colliders(colliders);
    }

    /// Advances the body by one tick, ten steps of 1 ms, under `wrench`.
    pub fn tick(&mut self, wrench: &Wrench) {
        let held = matches!(wrench, Wrench::Held(_));
        for _ in 0..STEPS_PER_TICK {
            let motion = self.motion();
            let Some(body) = self.world.bodies.get_mut(self.handle) else { return };
            body.reset_forces(true);
            body.reset_torques(true);
            if held {
                body.set_angvel(Vector::ZERO, true);
            }
            match wrench {
                Wrench::Held(force) => body.add_force(to_vector(force), true),
                Wrench::Free { in_body, in_world } => {
                    // The wrench is constant in the world during a step. Its direction is that of the attitude in the middle of the step.
                    let middle = Rotation3::new(motion.body_rate * (0.5 * STEP_S));
                    let rotation = motion.rotation * middle.matrix();
                    let force = rotation * in_body[0] + in_world;
                    body.add_force_at_point(to_vector(&force), to_vector(&motion.position), true);
                    body.add_torque(to_vector(&(rotation * in_body[1])), true);
                }
            }
            let before = [body.linvel(), body.angvel()];
            self.world.step();
            self.centre(before);
        }
    }

    /// Ends a step that began with the velocity and the angular velocity `before`. Rapier moves a body by its velocities at the end of the
    /// step; this function takes those of the middle, so the method is second order.
    fn centre(&mut self, before: [Vector; 2]) {
        let Some(body) = self.world.bodies.get_mut(self.handle) else { return };
        let change = |after: Vector, before: Vector| from_vector(after - before) * (-0.5 * STEP_S);
        let shift = change(body.linvel(), before[0]);
        let turn = Rotation3::new(change(body.angvel(), before[1]));
        let mut pose = from_pose(body.position());
        let com = pose * Point3::from(self.com_in_root);
        pose.append_rotation_wrt_point_mut(&turn.into(), &com);
        pose.append_translation_mut(&shift.into());
        body.set_position(to_pose(&pose), true);
    }

    /// Pose and velocity of the body now.
    pub fn motion(&self) -> Motion {
        let identity = Motion {
            position: Vector3::zeros(),
            rotation: Matrix3::identity(),
            velocity: Vector3::zeros(),
            body_rate: Vector3::zeros(),
        };
        let Some(body) = self.world.bodies.get(self.handle) else { return identity };
        let rotation = rotation_matrix(body.position().rotation);
        let omega = from_vector(body.angvel());
        Motion {
            position: from_vector(body.position().translation),
            rotation,
            velocity: from_vector(body.linvel()) - omega.cross(&(rotation * self.com_in_root)),
            body_rate: rotation.transpose() * omega,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MASS_KG: f64 = 2.0;
    const INERTIA_KG_M2: f64 = 0.02;

    fn body(com_in_link: Vector3<f64>) -> FreeBody {
        let inertia_in_link = Matrix3::identity() * INERTIA_KG_M2;
        FreeBody::new(&Inertial { mass_kg: MASS_KG, com_in_link, inertia_in_link })
    }

    fn start() -> Motion {
        Motion {
            position: Vector3::new(1.0, 2.0, 3.0),
            rotation: Matrix3::identity(),
            velocity: Vector3::new(0.5, -0.2, 0.1),
            body_rate: Vector3::zeros(),
        }
    }

    /// A second-order method is exact for a constant force; a thousand steps round.
    const ROUNDING_M: f64 = 1e-9;

    /// Rapier turns a body by the normalised quaternion `1 + w h / 2`, whose angle is off by `(w h)³ / 12`: 3e-9 rad in a thousand steps.
    const TURN_RAD: f64 = 1e-8;

    #[test]
    fn it_falls_as_newton_says_whether_its_attitude_is_held_or_free() {
        let mut motion = start();
        motion.rotation = *Rotation3::from_euler_angles(0.3, -0.2, 1.0).matrix();
        let push = Vector3::new(3.0, 0.0, 4.0);
        let a = push / MASS_KG - Vector3::z() * GRAVITY_M_S2;
        let wanted = motion.position + motion.velocity + a * 0.5;
        let free = Wrench::Free {
            in_body: [motion.rotation.transpose() * push, Vector3::zeros()],
            in_world: Vector3::zeros(),
        };
        for wrench in [free, Wrench::Held(push)] {
            let mut body = body(Vector3::zeros());
            body.put(&motion);
            (0..100).for_each(|_| body.tick(&wrench));
            let found = body.motion();
            assert!((found.position - wanted).norm() < ROUNDING_M, "{found:?} {wanted:?}");
            assert!((found.rotation - motion.rotation).norm() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn a_torque_turns_it_and_an_eccentric_mass_tumbles_about_its_centre() {
        let mut turned = body(Vector3::zeros());
        turned.put(&start());
        let torque = Vector3::new(0.01, 0.0, 0.0);
        let wrench =
            Wrench::Free { in_body: [Vector3::zeros(), torque], in_world: Vector3::zeros() };
        (0..100).for_each(|_| turned.tick(&wrench));
        let motion = turned.motion();
        let alpha = torque.x / INERTIA_KG_M2;
        assert!((motion.body_rate.x - alpha).abs() < 1e-6, "{motion:?}");
        let turn = Rotation3::from_matrix_unchecked(motion.rotation);
        assert!((turn.angle() - 0.5 * alpha).abs() < TURN_RAD, "{motion:?}");
        let com = Vector3::new(0.1, 0.0, 0.0);
        let mut tumbling = body(com);
        let motion = Motion { body_rate: Vector3::new(0.0, 0.0, 2.0), ..start() };
        tumbling.put(&motion);
        assert!((tumbling.motion().velocity - motion.velocity).norm() < 1e-12);
        let lift = Wrench::Held(Vector3::z() * MASS_KG * GRAVITY_M_S2);
        tumbling.tick(&lift);
        // A body that keeps its attitude does not turn, whatever its initial rate was.
        assert!(tumbling.motion().body_rate.norm() < 1e-12);
        assert!((tumbling.motion().rotation - motion.rotation).norm() < 1e-12);
    }
}
