//! The true state of the simulation, read from Rapier once a tick.

use nalgebra::Vector3;
use rapier3d_f64::prelude::*;

use super::STEP_S;
use super::convert::{from_pose, from_vector, view_pose};
use super::estimator::stack;
use super::sensors::KinematicState;
use super::vehicle::SimulatedVehicle;
use twin_core::elementary::acos;
use twin_core::notation::{Coords, euler_from_rotation, euler_rate_from_body_rate, wrap_angle};
use twin_core::tick::{Contact, Truth};

/// Weakest contact that is recorded, N.
const FAINTEST_N: f64 = 0.02;

/// The truth of a tick.
pub(super) fn truth(vehicle: &SimulatedVehicle) -> Truth {
    let state = vehicle.state();
    let (chi, chi_dot) = true_coordinates(&state);
    let links = (0..vehicle.robot.links.len())
        .map(|link| vehicle.articulation.link_pose(&vehicle.world, link));
    let mut poses: Vec<_> = links.map(|pose| view_pose(&pose)).collect();
    let payload = vehicle.arena.payload.and_then(|handle| vehicle.world.bodies.get(handle));
    let mut payload_position = Vector3::zeros();
    let (mut payload_tilt_rad, mut payload_speed_m_s) = (0.0, 0.0);
    let mut payload_in_palm = Vector3::zeros();
    if let Some(body) = payload {
        let pose = from_pose(body.position());
        poses.push(view_pose(&pose));
        payload_position = pose.translation.vector;
        payload_tilt_rad = acos((pose.rotation * Vector3::z()).z.clamp(-1.0, 1.0));
        payload_speed_m_s = from_vector(body.linvel()).norm();
        if let Some(gripper) = &vehicle.gripper {
            let palm = vehicle.articulation.link_pose(&vehicle.world, gripper.palm);
            payload_in_palm = (palm.inverse() * pose).translation.vector;
        }
    }
    let mut found = Contacts::default();
    found.collect(vehicle);
    Truth {
        chi,
        chi_dot,
        poses,
        payload_position,
        payload_tilt_rad,
        payload_speed_m_s,
        payload_in_palm,
        grip_force_n: found.grip_force_n,
        collision_force_n: found.collision_force_n,
        wind_in_world: vehicle.wind_now.at(&state.position),
        rotor_thrust_n: vehicle.propulsion.thrust_n,
        contacts: found.points,
        budget: vehicle.budget.last,
    }
}

/// True coordinates and their rates; yaw lies in (-π, π].
fn true_coordinates(state: &KinematicState) -> (Coords, Coords) {
    let mut eta = euler_from_rotation(&state.rotation);
    // The sum turns a yaw of -0.0 into 0.0; the two hash differently.
    eta.z = 0.0 + wrap_angle(eta.z);
    let eta_dot = euler_rate_from_body_rate(&eta) * state.omega;
    (stack(&state.position, &eta, &state.joint), stack(&state.velocity, &eta_dot, &state.joint_dot))
}

/// Contacts of this step with their forces.
#[derive(Default)]
struct Contacts {
    points: Vec<Contact>,
    grip_force_n: f64,
    collision_force_n: f64,
}

impl Contacts {
    fn collect(&mut self, vehicle: &SimulatedVehicle) {
        let world = &vehicle.world;
        let payload = vehicle.arena.payload_collider;
        let pads: &[ColliderHandle] = vehicle.gripper.as_ref().map_or(&[], |g| &g.pads);
        for pair in world.contact_pairs() {
            let magnitude = pair.total_impulse_magnitude() / STEP_S;
            if magnitude < FAINTEST_N {
                continue;
            }
            let (a, b) = (pair.collider1, pair.collider2);
            let is_payload = |c| Some(c) == payload;
            let is_pad = |c| pads.contains(&c);
            if (is_payload(a) && is_pad(b)) || (is_payload(b) && is_pad(a)) {
                self.grip_force_n += magnitude;
            } else if !(is_payload(a) || is_payload(b) || is_pad(a) || is_pad(b)) {
                self.collision_force_n += magnitude;
            }
            // The normal points out of collider1: the force on collider2 is along it.
            let receives_first =
                is_payload(a) || (!is_payload(b) && !vehicle.arena.fixed.contains(&a));
            self.add_points(world, pair, if receives_first { -1.0 } else { 1.0 });
        }
    }

    fn add_points(&mut self, world: &PhysicsWorld, pair: &ContactPair, sign: f64) {
        for manifold in pair.solver_manifolds() {
            for contact in &manifold.data.solver_contacts {
                let Some(point) = manifold.points.get(contact.contact_indices()[0] as usize) else {
                    continue;
                };
                let force_n = point.data.impulse / STEP_S;
                if force_n < FAINTEST_N {
                    continue;
                }
                let (on_first, on_second) =
                    manifold.data.solver_contact_world_points(contact, &world.bodies);
                let middle = (from_vector(on_first) + from_vector(on_second)) * 0.5;
                let force = from_vector(manifold.data.normal) * (sign * force_n);
                self.points.push(Contact {
                    point_in_world: middle.into(),
                    force_in_world_n: force.into(),
                });
            }
        }
    }
}
