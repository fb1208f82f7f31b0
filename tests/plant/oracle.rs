//! An independent implementation of the vehicle's equations of motion: recursive Newton-Euler in the world frame, from the URDF.
//!
//! Generalised velocity `[v_com omega | joint rates]`: velocity of the centre of mass of the root body (the root link and the links
//! fixed to it) and angular velocity, both in the world, then the moving joints in the order of the [`Robot`].

use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3,
};
use twin_plant::model::{Joint, JointKind, Robot};

/// Standard gravity of the twin, m/s².
pub(super) const GRAVITY_M_S2: f64 = 9.81;

/// Configuration and generalised velocity.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// Centre of mass of the root body in the world, m.
    pub com: Vector3<f64>,
    /// `world_from_root`.
    pub rotation: UnitQuaternion<f64>,
    /// Positions of the moving joints, rad or m.
    pub joints: DVector<f64>,
    /// Generalised velocity.
    pub velocity: DVector<f64>,
}

/// Effort besides gravity: force through the origin of the root link and moment, in the body frame, and joint efforts.
#[derive(Clone, Debug)]
pub(super) struct Effort {
    /// Force, N.
    pub force_in_body: Vector3<f64>,
    /// Moment, N m.
    pub moment_in_body: Vector3<f64>,
    /// Joint efforts, N m or N.
    pub joints: DVector<f64>,
}

/// Motion of one link: pose, angular velocity, velocity of the origin and their rates, in the world.
#[derive(Clone, Copy)]
struct Motion {
    pose: Isometry3<f64>,
    omega: Vector3<f64>,
    velocity: Vector3<f64>,
    alpha: Vector3<f64>,
    acceleration: Vector3<f64>,
}

/// The equations of motion of a [`Robot`].
pub(super) struct Oracle<'a> {
    robot: &'a Robot,
    /// Moving joints, indices into the robot's joints.
    pub moving: Vec<usize>,
    /// Centre of mass of the root body in the root link's frame, m.
    pub com_in_root: Vector3<f64>,
    /// Rotor inertia of each moving joint, kg m².
    pub armature: DVector<f64>,
    /// Viscous damping of each moving joint, N m s/rad.
    pub damping: DVector<f64>,
}

impl<'a> Oracle<'a> {
    /// The equations of `robot`, without armature and damping.
    pub(super) fn new(robot: &'a Robot) -> Self {
        let moving: Vec<usize> =
            (0..robot.joints.len()).filter(|&j| robot.joints[j].kind != JointKind::Fixed).collect();
        let zeros = DVector::zeros(moving.len());
        Self {
            robot,
            moving,
            com_in_root: root_com(robot),
            armature: zeros.clone(),
            damping: zeros,
        }
    }

    /// Number of degrees of freedom.
    pub(super) fn dofs(&self) -> usize {
        6 + self.moving.len()
    }

    /// Inertia matrix: column `k` is the effort of a unit acceleration at rest without gravity.
    pub(super) fn mass_matrix(&self, state: &State) -> DMatrix<f64> {
        let n = self.dofs();
        let rest = State { velocity: DVector::zeros(n), ..state.clone() };
        let mut m = DMatrix::zeros(n, n);
        for k in 0..n {
            let mut unit = DVector::zeros(n);
            unit[k] = 1.0;
            m.set_column(k, &self.inverse_dynamics(&rest, &unit, 0.0));
        }
        for (row, armature) in self.armature.iter().enumerate() {
            m[(6 + row, 6 + row)] += armature;
        }
        m
    }

    /// Generalised acceleration under `effort`.
    pub(super) fn acceleration(&self, state: &State, effort: &Effort) -> DVector<f64> {
        let n = self.dofs();
        let bias = self.inverse_dynamics(state, &DVector::zeros(n), GRAVITY_M_S2);
        let force = state.rotation * effort.force_in_body;
        let lever = -(state.rotation * self.com_in_root);
        let moment = state.rotation * effort.moment_in_body + lever.cross(&force);
        let mut tau = DVector::zeros(n);
        tau.fixed_rows_mut::<3>(0).copy_from(&force);
        tau.fixed_rows_mut::<3>(3).copy_from(&moment);
        for row in 0..self.moving.len() {
            tau[6 + row] = effort.joints[row] - self.damping[row] * state.velocity[6 + row];
        }
        self.mass_matrix(state)
            .cholesky()
            .expect("an inertia matrix is positive definite")
            .solve(&(tau - bias))
    }

    /// One Runge-Kutta step of order 4 under constant `effort`.
    pub(super) fn step(&self, state: &State, effort: &Effort, h: f64) -> State {
        let k1 = self.derivative(state, effort);
        let k2 = self.derivative(&advance(state, &k1, 0.5 * h), effort);
        let k3 = self.derivative(&advance(state, &k2, 0.5 * h), effort);
        let k4 = self.derivative(&advance(state, &k3, h), effort);
        let mean = (k1 + k2 * 2.0 + k3 * 2.0 + k4) / 6.0;
        advance(state, &mean, h)
    }

    /// Rates of `[com | quaternion | joints | velocity]`.
    fn derivative(&self, state: &State, effort: &Effort) -> DVector<f64> {
        let v = &state.velocity;
        let omega = Vector3::new(v[3], v[4], v[5]);
        let turn = nalgebra::Quaternion::from_imag(omega) * state.rotation.quaternion() * 0.5;
        let rates = v.iter().take(3).copied().chain([turn.i, turn.j, turn.k, turn.w]);
        let rates = rates.chain(v.iter().skip(6).copied());
        let all: Vec<f64> = rates.chain(self.acceleration(state, effort).iter().copied()).collect();
        DVector::from_vec(all)
    }

    /// Effort that gives `acceleration`, by recursion over the links.
    pub(super) fn inverse_dynamics(
        &self,
        state: &State,
        acceleration: &DVector<f64>,
        gravity: f64,
    ) -> DVector<f64> {
        let motions = self.motions(state, acceleration);
        let robot = self.robot;
        let mut forces: Vec<Vector3<f64>> = Vec::new();
        let mut moments: Vec<Vector3<f64>> = Vec::new();
        for (link, motion) in robot.links.iter().zip(&motions) {
            let (force, moment) = newton_euler(&link.inertial, motion, gravity);
            forces.push(force);
            moments.push(moment);
        }
        let mut tau = DVector::zeros(self.dofs());
        for (index, joint) in robot.joints.iter().enumerate().rev() {
            let (force, moment) = (forces[joint.child], moments[joint.child]);
            if let Some(row) = self.moving.iter().position(|&moving| moving == index) {
                let axis = motions[joint.child].pose.rotation * joint.axis;
                tau[6 + row] =
                    axis.dot(if joint.kind == JointKind::Prismatic { &force } else { &moment });
            }
            let lever = origin(&motions[joint.child]) - origin(&motions[joint.parent]);
            forces[joint.parent] += force;
            moments[joint.parent] += moment + lever.cross(&force);
        }
        let lever = -(state.rotation * self.com_in_root);
        tau.fixed_rows_mut::<3>(0).copy_from(&forces[robot.root]);
        tau.fixed_rows_mut::<3>(3)
            .copy_from(&(moments[robot.root] + lever.cross(&forces[robot.root])));
        tau
    }

    fn motions(&self, state: &State, acceleration: &DVector<f64>) -> Vec<Motion> {
        let (v, a) = (&state.velocity, acceleration);
        let omega = Vector3::new(v[3], v[4], v[5]);
        let alpha = Vector3::new(a[3], a[4], a[5]);
        // The lever arm from the centre of mass back to the origin of the root link.
        let lever = -(state.rotation * self.com_in_root);
        let root = Motion {
            pose: Isometry3::from_parts((state.com + lever).into(), state.rotation),
            omega,
            velocity: Vector3::new(v[0], v[1], v[2]) + omega.cross(&lever),
            alpha,
            acceleration: Vector3::new(a[0], a[1], a[2])
                + alpha.cross(&lever)
                + omega.cross(&omega.cross(&lever)),
        };
        let mut motions = vec![root; self.robot.links.len()];
        for (index, joint) in self.robot.joints.iter().enumerate() {
            let row = self.moving.iter().position(|&moving| moving == index);
            let (q, qd, qdd) =
                row.map_or((0.0, 0.0, 0.0), |row| (state.joints[row], v[6 + row], a[6 + row]));
            motions[joint.child] = child_motion(&motions[joint.parent], joint, q, qd, qdd);
        }
        motions
    }
}

fn child_motion(parent: &Motion, joint: &Joint, q: f64, qd: f64, qdd: f64) -> Motion {
    let slides = joint.kind == JointKind::Prismatic;
    let moved = if slides {
        Isometry3::from_parts(Translation3::from(joint.axis * q), UnitQuaternion::identity())
    } else {
        Isometry3::rotation(joint.axis * q)
    };
    let pose = parent.pose * joint.origin * moved;
    let axis = pose.rotation * joint.axis;
    let lever = pose.translation.vector - origin(parent);
    let w = parent.omega;
    let carried_velocity = parent.velocity + w.cross(&lever);
    let carried = parent.acceleration + parent.alpha.cross(&lever) + w.cross(&w.cross(&lever));
    if slides {
        return Motion {
            pose,
            omega: w,
            velocity: carried_velocity + axis * qd,
            alpha: parent.alpha,
            acceleration: carried + w.cross(&axis) * (2.0 * qd) + axis * qdd,
        };
    }
    Motion {
        pose,
        omega: w + axis * qd,
        velocity: carried_velocity,
        alpha: parent.alpha + w.cross(&axis) * qd + axis * qdd,
        acceleration: carried,
    }
}

/// Force on a link, and moment about its origin, that its motion requires, in the world.
fn newton_euler(
    inertial: &twin_plant::model::Inertial,
    motion: &Motion,
    gravity: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let r: Matrix3<f64> = *motion.pose.rotation.to_rotation_matrix().matrix();
    let com = r * inertial.com_in_link;
    let w = motion.omega;
    let acceleration = motion.acceleration + motion.alpha.cross(&com) + w.cross(&w.cross(&com));
    let force = (acceleration + Vector3::z() * gravity) * inertial.mass_kg;
    let inertia = r * inertial.inertia_in_link * r.transpose();
    let moment = inertia * motion.alpha + w.cross(&(inertia * w));
    (force, moment + com.cross(&force))
}

fn origin(motion: &Motion) -> Vector3<f64> {
    motion.pose.translation.vector
}

/// Centre of mass of the root link and all links fixed to it, in the root link's frame.
fn root_com(robot: &Robot) -> Vector3<f64> {
    let mut places = vec![None; robot.links.len()];
    places[robot.root] = Some(Isometry3::identity());
    for joint in robot.joints.iter().filter(|joint| joint.kind == JointKind::Fixed) {
        places[joint.child] =
            places[joint.parent].map(|place: Isometry3<f64>| place * joint.origin);
    }
    let (mut mass, mut moment) = (0.0, Vector3::zeros());
    for (link, place) in robot.links.iter().zip(places) {
        let Some(place) = place else { continue };
        mass += link.inertial.mass_kg;
        moment += (place * Point3::from(link.inertial.com_in_link)).coords * link.inertial.mass_kg;
    }
    moment / mass
}

/// `state + h * rates`.
fn advance(state: &State, rates: &DVector<f64>, h: f64) -> State {
    let joints = state.joints.len();
    let q = state.rotation.quaternion();
    let turned = nalgebra::Quaternion::new(
        q.w + h * rates[6],
        q.i + h * rates[3],
        q.j + h * rates[4],
        q.k + h * rates[5],
    );
    State {
        com: state.com + Vector3::new(rates[0], rates[1], rates[2]) * h,
        rotation: UnitQuaternion::new_normalize(turned),
        joints: &state.joints + rates.rows(7, joints) * h,
        velocity: &state.velocity + rates.rows(7 + joints, 6 + joints) * h,
    }
}
