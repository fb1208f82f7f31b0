//! The simulated vehicle and one step of its world, 1 ms.

use std::sync::Arc;

use nalgebra::{Rotation3, Vector2, Vector3};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rapier3d_f64::prelude::*;

use super::aero::{Aero, Flow, PartLoads};
use super::arena::Arena;
use super::budget::Budget;
use super::command_link::{CommandLink, lateness};
use super::convert::{from_vector, rotation_matrix, to_vector};
use super::estimator::{Estimator, stack};
use super::gripper::Gripper;
use super::leapfrog::Leapfrog;
use super::propulsion::{Propulsion, RotorWrench};
use super::sensors::{KinematicState, Sensors};
use super::servo::Servos;
use super::setup::{BuiltWorld, Start, rig};
use super::wind::{Wind, WindNow};
use super::world::World;
use super::{Articulation, PlantError, PlantSettings, STEP_S, STEPS_PER_TICK};
use crate::model::{Robot, Statics};
use twin_core::control::delays::RESIDUAL_CORNER_HZ;
use twin_core::elementary::{atan2, squared};
use twin_core::filter::Butterworth;
use twin_core::notation::{Coords, GRAVITY_M_S2, MAX_ROTORS, N, body_rate_from_euler_rate};
use twin_core::tick::{ActuatorCommand, PayloadReading, Setpoint};

/// Separates the random numbers of the command link from those of wind and sensors.
const LINK_STREAM: u64 = 0x1117_0c0d;

/// Drag coefficient of a cube.
const CUBE_DRAG: f64 = 1.05;

/// Failures of the vehicle other than those of sensors and rotors.
#[derive(Clone, Debug, Default)]
pub(super) struct Failures {
    /// The actuators keep their last command.
    pub(super) stalled: bool,
    /// Velocity that is added to the wind, m/s.
    pub(super) gust: Vector3<f64>,
    /// Friction coefficients of the grip before the failure.
    pub(super) healthy_friction: Vec<(ColliderHandle, f64)>,
}

/// What acts on the vehicle from one step to the next: actuators and pushes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Inputs {
    /// Force and moment of all rotors.
    rotors: RotorWrench,
    /// Force of a push in the world, N.
    push: Vector3<f64>,
    /// Torques of the arm's joints, N m.
    torque: Vector2<f64>,
}

impl Inputs {
    /// `share` of `before` and the rest of `self`.
    fn after(&self, before: &Self, share: f64) -> Self {
        let rest = 1.0 - share;
        Self {
            rotors: self.rotors.after(&before.rotors, share),
            push: before.push * share + self.push * rest,
            torque: before.torque * share + self.torque * rest,
        }
    }
}

/// The vehicle, its arena, its sensors.
#[derive(Clone)]
pub struct SimulatedVehicle {
    pub(super) world: World,
    pub(super) robot: Arc<Robot>,
    pub(super) articulation: Articulation,
    pub(super) leapfrog: Leapfrog,
    inputs: Option<Inputs>,
    pub(super) arena: Arena,
    pub(super) gripper: Option<Gripper>,
    pub(super) settings: PlantSettings,
    pub(super) arm: Vec<usize>,
    /// Columns of the arm's joints in the generalised velocity.
    arm_columns: Vec<usize>,
    pub(super) propulsion: Propulsion,
    pub(super) servos: Servos,
    pub(super) budget: Budget,
    pub(super) wind_now: WindNow,
    pub(super) failures: Failures,
    pub(super) sensors: Sensors,
    pub(super) aero: Aero,
    pub(super) wind: Wind,
    pub(super) estimator: Estimator,
    pub(super) payload_seen: Option<PayloadReading>,
    rng: Pcg64,
    link_rng: Pcg64,
    joint_link: CommandLink<Vector2<f64>>,
    pub(super) command: ActuatorCommand,
    filter_chi_ddot: Butterworth<N>,
    filter_tau: Butterworth<N>,
    pub(super) push: Option<(Vector3<f64>, f64)>,
    hover_speed_rad_s: f64,
    pub(super) step: u64,
    pub(super) inner_steps: u64,
}

impl SimulatedVehicle {
    /// The vehicle of `settings` (URDFs already loaded) at `start`; all random numbers follow from `seed`.
    ///
    /// # Errors
    /// [`PlantError`] for names that do not exist, for tensors or meshes that Rapier cannot represent, and for too few or too many rotors.
    pub fn new(
        robot: Robot,
        objects: &[Robot],
        settings: PlantSettings,
        start: &Start,
        seed: u64,
    ) -> Result<Self, PlantError> {
        let vehicle = &settings.vehicle;
        vehicle.check_rotors()?;
        let mut rng = Pcg64::seed_from_u64(seed);
        let BuiltWorld { mut world, articulation, arm, gripper, arena } =
            rig(&robot, objects, &settings, start, &mut rng)?;
        let leapfrog = Leapfrog::new(&mut world, &articulation);
        let arm_joints: Vec<usize> = arm.iter().map(|dof| articulation.dofs[*dof].joint).collect();
        let payload_kg = if start.grasped.is_some() { settings.payload.mass_kg } else { 0.0 };
        let hover_n =
            (robot.total_mass_kg() + payload_kg) * GRAVITY_M_S2 / vehicle.rotors.len() as f64;
        let columns = articulation.columns(&world);
        let chi = stack(&start.position, &Vector3::zeros(), &start.joints);
        let statics = Statics::new(&robot, &arm_joints);
        let mut filter_tau = Butterworth::new(RESIDUAL_CORNER_HZ, STEP_S);
        filter_tau.settle(&statics.gravity(&chi));
        let estimator = Estimator::new(
            start.position,
            nalgebra::Matrix3::identity(),
            start.joints,
            &settings.sensors,
            STEP_S,
        );
        Ok(Self {
            arm_columns: arm.iter().map(|dof| columns[*dof]).collect(),
            propulsion: Propulsion::new(vehicle, hover_n, seed, STEP_S),
            servos: Servos::new(&vehicle.servo, &robot, &arm_joints, STEP_S),
            budget: Budget::new(),
            aero: Aero::new(&settings.aero),
            wind: Wind::new(&settings.wind),
            wind_now: WindNow::CALM,
            failures: Failures::default(),
            sensors: Sensors::new(&settings.sensors, seed, STEP_S),
            link_rng: Pcg64::seed_from_u64(seed ^ LINK_STREAM),
            joint_link: CommandLink::new(vehicle.joint_delay_s, STEP_S, Vector2::zeros()),
            command: ActuatorCommand {
                rotor_thrust_n: [0.0; MAX_ROTORS],
                joint_torque_n_m: Vector2::zeros(),
                saturated: false,
            },
            filter_chi_ddot: Butterworth::new(RESIDUAL_CORNER_HZ, STEP_S),
            hover_speed_rad_s: (hover_n / vehicle.rotor.thrust_coefficient_n_s2).sqrt(),
            payload_seen: None,
            push: None,
            step: 0,
            inner_steps: start.inner_steps.max(1),
            filter_tau,
            inputs: None,
            world: World(world),
            robot: Arc::new(robot),
            articulation,
            leapfrog,
            arena,
            gripper,
            arm,
            estimator,
            rng,
            settings,
        })
    }

    /// The true state that the sensors measure.
    pub(super) fn state(&self) -> KinematicState {
        let root = self.articulation.link_pose(&self.world, self.robot.root);
        let rotation = *root.rotation.to_rotation_matrix().matrix();
        let body = self.world.bodies.get(self.articulation.bodies[0].handle);
        let velocities = self.leapfrog.velocities(&self.world, &self.articulation);
        let com_velocity = velocities.root.fixed_rows::<3>(0).into_owned();
        let omega_world = velocities.root.fixed_rows::<3>(3).into_owned();
        let com = body.map_or_else(Vector3::zeros, |b| from_vector(b.center_of_mass()));
        let position = root.translation.vector;
        let mut joint = Vector2::zeros();
        let mut joint_dot = Vector2::zeros();
        for (row, dof) in self.arm.iter().enumerate() {
            joint[row] = self.articulation.joint_state(&self.world, *dof).0;
            joint_dot[row] = velocities.joints[*dof];
        }
        let payload =
            self.arena.payload.and_then(|handle| self.world.bodies.get(handle)).map(|b| {
                let r = rotation_matrix(b.position().rotation);
                PayloadReading {
                    position_in_world: from_vector(b.position().translation),
                    yaw_rad: atan2(r[(1, 0)], r[(0, 0)]),
                }
            });
        KinematicState {
            rotation,
            position,
            velocity: com_velocity + omega_world.cross(&(position - com)),
            omega: rotation.transpose() * omega_world,
            joint,
            joint_dot,
            payload,
        }
    }

    /// Sends the command in force to rotors and joints.
    pub(super) fn send_command(&mut self) {
        let link = &self.settings.vehicle.link;
        let late = lateness(link, STEP_S, &mut self.link_rng);
        self.propulsion.rotors.command(self.command.rotor_thrust_n, late);
        let late = lateness(link, STEP_S, &mut self.link_rng);
        self.joint_link.send(self.command.joint_torque_n_m, late);
    }

    /// Advances the world by 1 ms under the command in force.
    pub(super) fn step_world(&mut self, state: &KinematicState, setpoint: &Setpoint) {
        let last_of_tick = (self.step + 1).is_multiple_of(STEPS_PER_TICK);
        if last_of_tick {
            let root = self.articulation.link_pose(&self.world, self.robot.root);
            self.budget.before_last_step(&self.world, &self.articulation.bodies, &root);
        }
        self.articulation.clear_forces(&mut self.world);
        let flow = self.flow(state);
        let lag = self.leapfrog.lag();
        let now = self.inputs_now(state, &flow);
        let inputs = now.after(&self.inputs.replace(now).unwrap_or(now), lag);
        self.push_base(&inputs, &flow, state);
        self.servos.resist(
            &mut self.world,
            &self.articulation,
            &self.arm_columns,
            &state.joint_dot,
        );
        for (row, dof) in self.arm.iter().enumerate() {
            self.articulation.apply_joint_effort(&mut self.world, *dof, inputs.torque[row]);
        }
        self.push_parts();
        if let Some(gripper) = &mut self.gripper {
            gripper.drive(&mut self.world, &self.articulation, setpoint.gripper);
        }
        self.leapfrog.step(&mut self.world, &self.articulation);
        self.budget.add_contacts(&self.world, &self.arena);
        if last_of_tick {
            let root = self.articulation.link_pose(&self.world, self.robot.root);
            self.budget.end_tick(&self.world, &self.articulation.bodies, &root);
        }
        if self.step == 0 {
            let touching = self.arena.vehicle_touches(&self.world);
            let substeps = self.settings.contact.iterations;
            self.leapfrog.start(&mut self.world, &self.articulation, substeps, touching);
        }
        self.step += 1;
    }

    /// Pose and motion of the base, and the wind, which advances by a step. Rapier keeps a force constant in the world during a step, so
    /// the attitude is that in the middle of the interval of the velocities.
    fn flow(&mut self, state: &KinematicState) -> Flow {
        let t_s = self.step as f64 * STEP_S;
        let (speed, altitude) = (state.velocity.norm(), state.position.z);
        let wind = self.wind.step(t_s, speed, altitude, STEP_S, &mut self.rng);
        self.wind_now = wind.plus(&self.failures.gust);
        let middle = Rotation3::new(state.omega * ((0.5 - self.leapfrog.lag()) * STEP_S));
        Flow {
            rotation: state.rotation * middle.matrix(),
            position: state.position,
            velocity: state.velocity,
            omega: state.omega,
            wind: self.wind_now,
        }
    }

    /// What actuators and pushes do in this step.
    fn inputs_now(&mut self, state: &KinematicState, flow: &Flow) -> Inputs {
        let torque = self.servos.torque(self.joint_link.step(), &state.joint_dot);
        Inputs {
            rotors: self.propulsion.step(
                self.command.rotor_thrust_n,
                flow,
                &self.arena,
                &self.aero.settings,
            ),
            push: self.take_push(),
            torque: torque.component_mul(&self.propulsion.mismatch.ratios().joint_torque),
        }
    }

    /// Applies the forces and moments on the base.
    fn push_base(&mut self, inputs: &Inputs, flow: &Flow, state: &KinematicState) {
        let rotation = flow.rotation;
        let middle_in_world = rotation * state.rotation.transpose();
        let air = self.aero.step(flow, STEP_S, &mut self.rng);
        let rotors = &inputs.rotors;
        let force = rotation * rotors.force() + air.drag + air.wind + air.unsteady + inputs.push;
        let moment = rotation * (rotors.moment + air.moment);
        if let Some(root) = self.world.bodies.get_mut(self.articulation.bodies[0].handle) {
            let com = root.center_of_mass();
            let lever = middle_in_world * (state.position - from_vector(com));
            root.add_force_at_point(to_vector(&force), com + to_vector(&lever), true);
            root.add_torque(to_vector(&moment), true);
        }
        let axis = rotation.column(2);
        self.budget.add(|sum| {
            sum.thrust += axis * rotors.thrust_n;
            sum.inflow += axis * rotors.inflow_n;
            sum.ground += axis * rotors.ground_n;
            sum.drag += rotation * rotors.drag + air.drag;
            sum.wind += rotation * rotors.wind + air.wind;
            sum.unsteady += air.unsteady;
            sum.push += inputs.push;
        });
    }

    fn take_push(&mut self) -> Vector3<f64> {
        match &mut self.push {
            Some((force, left_s)) if *left_s > 0.0 => {
                *left_s -= STEP_S;
                *force
            }
            _ => Vector3::zeros(),
        }
    }

    /// Applies the forces of wake and wind to arm links and payload.
    fn push_parts(&mut self) {
        let area = self.settings.aero.link_drag_area_m2;
        for row in 0..self.arm.len() {
            let child = self.articulation.dofs[self.arm[row]].child;
            let handle = self.articulation.bodies[child].handle;
            let Some(loads) = self.part_loads(handle, area) else { continue };
            if let Some(body) = self.world.bodies.get_mut(handle) {
                let com = body.center_of_mass();
                body.add_force_at_point(to_vector(&loads.sum()), com, true);
            }
            self.budget.add(|sum| {
                sum.drag += loads.drag;
                sum.wind += loads.wind;
                sum.wake += loads.wake;
            });
        }
        let Some(handle) = self.arena.payload else { return };
        let drag_area = CUBE_DRAG * squared(self.settings.payload.size_m);
        let Some(loads) = self.part_loads(handle, drag_area) else { return };
        if let Some(body) = self.world.bodies.get_mut(handle) {
            body.reset_forces(false);
            body.add_force(to_vector(&loads.sum()), true);
        }
    }

    /// Forces of the air on a body with drag area `drag_area_m2`.
    fn part_loads(&self, handle: RigidBodyHandle, drag_area_m2: f64) -> Option<PartLoads> {
        let body = self.world.bodies.get(handle)?;
        let com = from_vector(body.center_of_mass());
        let wind = self.wind_now.at(&com);
        let wake = if self.aero.settings.downwash {
            self.propulsion.wake.at(&com, &wind)
        } else {
            Vector3::zeros()
        };
        Some(self.aero.part(drag_area_m2, &from_vector(body.linvel()), &wind, &wake))
    }

    /// Updates sensors, estimator and the filter pair `H` after a step.
    pub(super) fn sense(&mut self, state: &KinematicState) -> (Coords, Coords) {
        let speeds = std::array::from_fn(|i| self.propulsion.rotors.speed_rad_s(i));
        let imu = self.sensors.imu(state, &speeds, self.hover_speed_rad_s);
        self.estimator.predict(&imu);
        if let Some(mocap) = self.sensors.mocap(state) {
            self.estimator.correct(&mocap);
            self.payload_seen = mocap.payload;
        }
        let (joint, joint_dot, fresh) = self.sensors.encoders(state);
        self.estimator.encoders(joint, joint_dot, fresh);
        let tau = self.modelled_force();
        (self.filter_chi_ddot.step(&self.estimator.chi_ddot()), self.filter_tau.step(&tau))
    }

    /// `tau = [R e3 T ; E^T m ; tau_q]` from the modelled rotor thrusts and the measured attitude.
    fn modelled_force(&self) -> Coords {
        let (collective, moment) = self.propulsion.rotors.modelled_wrench();
        let force = self.estimator.rotation() * Vector3::new(0.0, 0.0, collective);
        let tau_eta = body_rate_from_euler_rate(&self.estimator.eta()).transpose() * moment;
        stack(&force, &tau_eta, &self.command.joint_torque_n_m)
    }
}
