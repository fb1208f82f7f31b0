//! A vehicle that nothing drives keeps its energy and its momentum, however it tumbles.

use nalgebra::{DVector, Rotation3, UnitQuaternion, Vector2, Vector3};
use twin_core::notation::{MAX_ROTORS, body_rate_from_euler_rate};
use twin_core::source::Source;
use twin_core::tick::{ActuatorCommand, Truth};
use twin_plant::model::Robot;

use super::oracle::{Oracle, State};
use super::rig::{aerial_manipulator, any_setpoint};
use super::trajectory::{OpenLoop, built, command, settings, simplified};

/// Steps of 1 ms in which rotors and joints drive the vehicle.
const DRIVEN_STEPS: u32 = 600;

/// Ticks of 10 ms that it tumbles on without them.
const FREE_TICKS: u32 = 1000;

/// Largest change of the energy in ten seconds, as a share of it; measured 3.1e-3.
const ENERGY_TOLERANCE: f64 = 4e-3;

/// Largest change of the angular momentum in ten seconds, as a share of it; measured 1.7e-3.
const MOMENTUM_TOLERANCE: f64 = 2.2e-3;

fn driven_then_free(step: u32) -> ActuatorCommand {
    if step < DRIVEN_STEPS {
        return command(step);
    }
    ActuatorCommand {
        rotor_thrust_n: [0.0; MAX_ROTORS],
        joint_torque_n_m: Vector2::zeros(),
        saturated: false,
    }
}

/// The true state in the coordinates of the oracle.
fn state(oracle: &Oracle<'_>, truth: &Truth) -> State {
    let (chi, chi_dot) = (truth.chi, truth.chi_dot);
    let eta = Vector3::new(chi[3], chi[4], chi[5]);
    let rotation =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_euler_angles(eta.x, eta.y, eta.z));
    let rates = body_rate_from_euler_rate(&eta) * chi_dot.fixed_rows::<3>(3);
    let omega = rotation * rates;
    let lever = rotation * oracle.com_in_root;
    let com_velocity = chi_dot.fixed_rows::<3>(0) + omega.cross(&lever);
    let velocity = [com_velocity, omega].into_iter().flat_map(|v| [v.x, v.y, v.z]);
    let velocity: Vec<f64> = velocity.chain([chi_dot[6], chi_dot[7]]).collect();
    State {
        com: chi.fixed_rows::<3>(0) + lever,
        rotation,
        joints: DVector::from_column_slice(&[chi[6], chi[7]]),
        velocity: DVector::from_vec(velocity),
    }
}

/// Energy (J) and angular momentum (N m s) of the motion about the vehicle's own centre of mass, which gravity does not change.
fn internal(robot: &Robot, oracle: &Oracle<'_>, state: &State) -> (f64, Vector3<f64>) {
    let mass_matrix = oracle.mass_matrix(state);
    let momentum = &mass_matrix * &state.velocity;
    let energy = 0.5 * state.velocity.dot(&momentum);
    let linear = momentum.fixed_rows::<3>(0).into_owned();
    let mass_kg = robot.total_mass_kg();
    // The rows of the angular velocity hold the moment of momentum about the centre of mass of the root body. A unit angular velocity
    // moves all mass by the offset of the common centre of mass, which the matrix shows as `m [offset]x`.
    let block = mass_matrix.fixed_view::<3, 3>(3, 0) / mass_kg;
    let offset = Vector3::new(block[(2, 1)], block[(0, 2)], block[(1, 0)]);
    let angular = momentum.fixed_rows::<3>(3) - offset.cross(&linear);
    (energy - 0.5 * linear.norm_squared() / mass_kg, angular)
}

#[test]
fn a_tumbling_vehicle_keeps_its_energy_and_angular_momentum() {
    let mut robot = simplified(aerial_manipulator());
    for joint in &mut robot.joints {
        (joint.damping, joint.lower, joint.upper) = (0.0, f64::NEG_INFINITY, f64::INFINITY);
    }
    let settings = settings(&robot);
    let mut oracle = Oracle::new(&robot);
    oracle.armature.fill(settings.vehicle.joint_armature_kg_m2);
    let mut vehicle = built(&robot, &settings);
    let (setpoint, mut inner) = (any_setpoint(), OpenLoop(0, &driven_then_free));
    let mut tick = |ticks: u32| {
        for _ in 0..ticks {
            vehicle.advance(&setpoint, &mut inner);
        }
        let truth = vehicle.truth().expect("it is simulated");
        internal(&robot, &oracle, &state(&oracle, &truth))
    };
    let (energy_j, momentum) = tick(DRIVEN_STEPS / 10 + 1);
    assert!(energy_j > 0.1 && momentum.norm() > 0.01, "it tumbles: {energy_j} J, {momentum}");
    for second in 1..=FREE_TICKS / 100 {
        let (later_j, later) = tick(100);
        let lost = (later_j - energy_j).abs() / energy_j;
        let turned = (later - momentum).norm() / momentum.norm();
        assert!(lost < ENERGY_TOLERANCE, "{lost:.2e} of the energy after {second} s");
        assert!(turned < MOMENTUM_TOLERANCE, "{turned:.2e} of the momentum after {second} s");
    }
}
