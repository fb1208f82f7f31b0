//! Inertia matrix, accelerations and mass properties at single instants.

use nalgebra::{DVector, Isometry3, Matrix3, Matrix4, Vector3};
use rapier3d_f64::prelude::*;
use twin_core::elementary::sin;
use twin_plant::model::{JointKind, Robot};
use twin_plant::{Articulation, new_world};

use super::oracle::{Effort, Oracle, State};
use super::rig::{aerial_manipulator, awkward, quiet_settings, random_state};

/// Relative error of two orders of summation of some hundred products of f64; measured 1e-13.
const MASS_TOLERANCE: f64 = 1e-9;

/// At rest, no term of Rapier's step depends on its length, so the error is the rounding of `delta v / dt`.
const REST_TOLERANCE: f64 = 1e-6;

/// The extrapolation of two steps to length zero has an error of their square (1e-6 s times a few 10 /s, squared), and rounding.
const MOVING_TOLERANCE: f64 = 1e-7;

/// Step of the acceleration tests, s.
const SHORT_STEP_S: f64 = 1e-6;

/// The robot in Rapier with the pose and velocity of `state`.
fn placed(robot: &Robot, oracle: &Oracle<'_>, state: &State) -> (PhysicsWorld, Articulation) {
    let mut world = new_world(&quiet_settings().contact);
    let position = state.com - state.rotation * oracle.com_in_root;
    let pose = Isometry3::from_parts(position.into(), state.rotation);
    let articulation = Articulation::build(&mut world, robot, &pose).expect("the robot is built");
    articulation.set_joint_positions(&mut world, state.joints.as_slice());
    let multibody = articulation.multibody_mut(&mut world).expect("it has moving joints");
    multibody.generalized_velocity_mut().copy_from(&state.velocity);
    (world, articulation)
}

fn effort(dofs: usize, seed: u64) -> Effort {
    let wave = |k: f64| sin(1.7 * seed as f64 + k);
    Effort {
        force_in_body: Vector3::new(3.0 * wave(0.0), 2.0 * wave(1.0), 30.0 + 5.0 * wave(2.0)),
        moment_in_body: Vector3::new(0.4 * wave(3.0), 0.3 * wave(4.0), 0.2 * wave(5.0)),
        joints: DVector::from_fn(
            dofs - 6,
            |row, _| if row < 2 { 1.5 } else { 0.3 } * wave(6.0 + row as f64),
        ),
    }
}

/// `delta v / dt` over one step of Rapier.
fn stepped(
    robot: &Robot,
    oracle: &Oracle<'_>,
    state: &State,
    effort: &Effort,
    dt: f64,
) -> DVector<f64> {
    let (mut world, articulation) = placed(robot, oracle, state);
    world.integration_parameters.dt = dt;
    let force = state.rotation * effort.force_in_body;
    let moment = state.rotation * effort.moment_in_body;
    let origin = state.com - state.rotation * oracle.com_in_root;
    let vector = |v: &Vector3<f64>| Vector::new(v.x, v.y, v.z);
    let root = world.bodies.get_mut(articulation.bodies[0].handle).expect("the root body");
    root.add_force_at_point(vector(&force), vector(&origin), true);
    root.add_torque(vector(&moment), true);
    for (dof, effort) in effort.joints.iter().enumerate() {
        articulation.apply_joint_effort(&mut world, dof, *effort);
    }
    world.step();
    let multibody = articulation.multibody(&world).expect("it has moving joints");
    (multibody.generalized_velocity() - &state.velocity) / dt
}

#[test]
fn the_inertia_matrix_is_the_oracles_at_random_postures() {
    for robot in [aerial_manipulator(), awkward()] {
        let oracle = Oracle::new(&robot);
        for seed in 0..50 {
            let state = random_state(&robot, &oracle, seed, 0.0);
            let (world, articulation) = placed(&robot, &oracle, &state);
            let wanted = oracle.mass_matrix(&state);
            let error = (articulation.mass_matrix(&world) - &wanted).norm() / wanted.norm();
            assert!(error <= MASS_TOLERANCE, "seed {seed}: relative error {error:.1e}");
        }
    }
}

#[test]
fn accelerations_from_rest_are_the_oracles() {
    for robot in [aerial_manipulator(), awkward()] {
        let oracle = Oracle::new(&robot);
        for seed in 0..20 {
            let state = random_state(&robot, &oracle, seed, 0.0);
            let effort = effort(oracle.dofs(), seed);
            let wanted = oracle.acceleration(&state, &effort);
            let found = stepped(&robot, &oracle, &state, &effort, SHORT_STEP_S);
            let error = (&found - &wanted).amax();
            assert!(error <= REST_TOLERANCE, "seed {seed}: {error:.1e} of {:.1}", wanted.amax());
        }
    }
}

#[test]
fn accelerations_in_motion_are_the_oracles_but_for_the_length_of_the_step() {
    for robot in [aerial_manipulator(), awkward()] {
        let oracle = Oracle::new(&robot);
        for seed in 0..20 {
            let state = random_state(&robot, &oracle, seed, 4.0);
            let effort = effort(oracle.dofs(), seed);
            let wanted = oracle.acceleration(&state, &effort);
            let long = stepped(&robot, &oracle, &state, &effort, SHORT_STEP_S);
            let short = stepped(&robot, &oracle, &state, &effort, 0.5 * SHORT_STEP_S);
            let error = (short * 2.0 - long - &wanted).amax() / wanted.amax();
            assert!(error <= MOVING_TOLERANCE, "seed {seed}: {error:.1e} of {:.1}", wanted.amax());
        }
    }
}

/// Second moments of mass of all links that are fixed together, `sum of m [c; 1] [c; 1]^T` plus spread, in the frame of `links[0]`.
fn second_moments(robot: &Robot, links: &[usize]) -> Matrix4<f64> {
    let mut places = vec![None; robot.links.len()];
    places[links[0]] = Some(Isometry3::<f64>::identity());
    for joint in robot.joints.iter().filter(|joint| joint.kind == JointKind::Fixed) {
        if let Some(place) = places[joint.parent] {
            places[joint.child] = Some(place * joint.origin);
        }
    }
    links.iter().fold(Matrix4::zeros(), |sum, &link| {
        let inertial = &robot.links[link].inertial;
        let i = inertial.inertia_in_link;
        let spread = Matrix3::identity() * (0.5 * i.trace()) - i;
        let mut moments = Matrix4::zeros();
        moments.fixed_view_mut::<3, 3>(0, 0).copy_from(&spread);
        let c = inertial.com_in_link.push(1.0);
        moments += c * c.transpose() * inertial.mass_kg;
        let place =
            places[link].expect("the links of a body are fixed to its first").to_homogeneous();
        sum + place * moments * place.transpose()
    })
}

#[test]
fn rapier_stores_the_mass_and_tensor_of_the_links_of_each_body() {
    for robot in [aerial_manipulator(), awkward()] {
        let oracle = Oracle::new(&robot);
        let state = random_state(&robot, &oracle, 3, 0.0);
        let (world, articulation) = placed(&robot, &oracle, &state);
        let mut seen = 0;
        for body in &articulation.bodies {
            let rigid = world.bodies.get(body.handle).expect("the body");
            let stored = rigid.mass_properties().local_mprops;
            let moments = second_moments(&robot, &body.links);
            let mass = moments[(3, 3)];
            let com = moments.fixed_view::<3, 1>(0, 3) / mass;
            let about_com = moments.fixed_view::<3, 3>(0, 0) - com * com.transpose() * mass;
            let wanted = Matrix3::identity() * about_com.trace() - about_com;
            let tensor = stored.reconstruct_inertia_matrix();
            let tensor = Matrix3::from_fn(|row, column| tensor.col(column)[row]);
            let name = &robot.links[body.links[0]].name;
            assert!(
                (rigid.mass() - mass).abs() <= MASS_TOLERANCE * mass,
                "{name}: {} kg",
                rigid.mass()
            );
            assert!(
                (tensor - wanted).norm() <= MASS_TOLERANCE * wanted.norm(),
                "{name}: {tensor} for {wanted}"
            );
            seen += body.links.len();
        }
        assert_eq!(seen, robot.links.len(), "every link is part of one body");
    }
}
