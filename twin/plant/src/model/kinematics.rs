//! Poses of the links, and the arm that the task and the statics use.

use nalgebra::{Isometry3, Matrix3x2, Translation3, Unit, UnitQuaternion, Vector2, Vector3};

use super::{Joint, JointKind, Robot};
use twin_core::task::ToolKinematics;

/// Most arm joints that have a coordinate in `chi`.
const ARM_JOINTS: usize = 2;

/// `world_from_link` of every link, m. `joint_positions` has one entry for each joint, rad or m. The entry of a mimicking joint is
/// not read; a missing entry counts as zero.
pub fn link_poses(
    robot: &Robot,
    world_from_root: &Isometry3<f64>,
    joint_positions: &[f64],
) -> Vec<Isometry3<f64>> {
    let position = |index: usize| joint_positions.get(index).copied().unwrap_or(0.0);
    let mut poses = vec![*world_from_root; robot.links.len()];
    for (index, joint) in robot.joints.iter().enumerate() {
        let q = joint.mimic.map_or_else(
            || position(index),
            |mimic| mimic.multiplier * position(mimic.joint) + mimic.offset,
        );
        poses[joint.child] = poses[joint.parent] * joint.origin * motion(joint, q);
    }
    poses
}

/// `joint_from_child` at position `q`, rad or m.
fn motion(joint: &Joint, q: f64) -> Isometry3<f64> {
    let axis = Unit::new_unchecked(joint.axis);
    match joint.kind {
        JointKind::Fixed => Isometry3::identity(),
        JointKind::Revolute | JointKind::Continuous => Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&axis, q),
        ),
        JointKind::Prismatic => Translation3::from(joint.axis * q).into(),
    }
}

/// The robot with only the arm joints free: every other joint rests at zero or at its limit nearest to zero.
#[derive(Clone, Debug)]
pub(super) struct Skeleton {
    joints: Vec<SkeletonJoint>,
    /// For each link: the arm joint that carries it (none: the body) and its pose in that joint's moved frame.
    pub(super) links: Vec<(Option<usize>, Isometry3<f64>)>,
}

#[derive(Clone, Debug)]
struct SkeletonJoint {
    parent: Option<usize>,
    /// `parent_from_joint`, where the parent is the moved frame of another arm joint or the body.
    origin: Isometry3<f64>,
    joint: Joint,
}

impl Skeleton {
    /// The skeleton whose free joints are `arm`, in the order of `q1 q2`: indices into `robot.joints`, at most the first two.
    pub(super) fn new(robot: &Robot, arm: &[usize]) -> Self {
        let arm = &arm[..arm.len().min(ARM_JOINTS)];
        let mut links = vec![(None, Isometry3::identity()); robot.links.len()];
        let mut free: Vec<Option<SkeletonJoint>> = vec![None; arm.len()];
        for (index, joint) in robot.joints.iter().enumerate() {
            let (parent, parent_pose) = links[joint.parent];
            let origin = parent_pose * joint.origin;
            links[joint.child] = match arm.iter().position(|&place| place == index) {
                Some(row) => {
                    free[row] = Some(SkeletonJoint { parent, origin, joint: joint.clone() });
                    (Some(row), Isometry3::identity())
                }
                None => (parent, origin * motion(joint, rest(robot, joint))),
            };
        }
        // An index beyond the robot's joints gives no free joint; the list ends there, so that no later joint takes its coordinate.
        Skeleton { joints: free.into_iter().map_while(|joint| joint).collect(), links }
    }

    /// `body_from_frame` of each arm joint's moved frame.
    pub(super) fn frames(&self, q: &Vector2<f64>) -> [Isometry3<f64>; ARM_JOINTS] {
        let mut frames = [Isometry3::identity(); ARM_JOINTS];
        for (row, frame) in frames.iter_mut().enumerate().take(self.joints.len()) {
            *frame = self.frame(row, q);
        }
        frames
    }

    fn frame(&self, row: usize, q: &Vector2<f64>) -> Isometry3<f64> {
        let SkeletonJoint { parent, origin, joint } = &self.joints[row];
        let body_from_parent =
            parent.map_or_else(Isometry3::identity, |parent| self.frame(parent, q));
        body_from_parent * origin * motion(joint, q[row])
    }

    /// Whether arm joint `row` moves the links that `carrier` carries.
    pub(super) fn moves(&self, row: usize, carrier: Option<usize>) -> bool {
        carrier
            .is_some_and(|carrier| carrier == row || self.moves(row, self.joints[carrier].parent))
    }

    /// Velocity in the body frame of a point at `point` (body frame, m) for a unit rate of arm joint `row`.
    pub(super) fn column(
        &self,
        row: usize,
        frames: &[Isometry3<f64>; ARM_JOINTS],
        point: &Vector3<f64>,
    ) -> Vector3<f64> {
        let Some(SkeletonJoint { joint, .. }) = self.joints.get(row) else {
            return Vector3::zeros();
        };
        let axis = frames[row].rotation * joint.axis;
        match joint.kind {
            JointKind::Fixed => Vector3::zeros(),
            JointKind::Revolute | JointKind::Continuous => {
                axis.cross(&(point - frames[row].translation.vector))
            }
            JointKind::Prismatic => axis,
        }
    }
}

/// Position of a joint that is not driven, rad or m.
fn rest(robot: &Robot, joint: &Joint) -> f64 {
    match joint.mimic {
        Some(mimic) => {
            let leader = &robot.joints[mimic.joint];
            mimic.multiplier * 0.0_f64.clamp(leader.lower, leader.upper) + mimic.offset
        }
        None => 0.0_f64.clamp(joint.lower, joint.upper),
    }
}

/// The arm of the task: pose of the tool frame in the body frame, and its Jacobian.
#[derive(Clone, Debug)]
pub struct Arm {
    skeleton: Skeleton,
    carrier: Option<usize>,
    carrier_from_tool: Isometry3<f64>,
}

impl Arm {
    /// The arm that carries link `tool_link`; `joints` are indices into `robot.joints` of `q1 q2`, none to two.
    pub fn new(robot: &Robot, joints: &[usize], tool_link: usize) -> Self {
        let skeleton = Skeleton::new(robot, joints);
        let (carrier, carrier_from_tool) =
            skeleton.links.get(tool_link).copied().unwrap_or((None, Isometry3::identity()));
        Arm { skeleton, carrier, carrier_from_tool }
    }

    /// Jacobian of the tool's position in the body frame, 3 × 2, m/rad.
    pub fn tool_jacobian_in_body(&self, q: &Vector2<f64>) -> Matrix3x2<f64> {
        let frames = self.skeleton.frames(q);
        let tool = self.tool_in_body(q).translation.vector;
        let column = |row| {
            if self.skeleton.moves(row, self.carrier) {
                self.skeleton.column(row, &frames, &tool)
            } else {
                Vector3::zeros()
            }
        };
        Matrix3x2::from_columns(&[column(0), column(1)])
    }
}

impl ToolKinematics for Arm {
    fn tool_in_body(&self, q: &Vector2<f64>) -> Isometry3<f64> {
        let frames = self.skeleton.frames(q);
        match self.carrier {
            Some(row) => frames[row] * self.carrier_from_tool,
            None => self.carrier_from_tool,
        }
    }

    fn tool_velocity_in_body(&self, q: &Vector2<f64>, q_dot: &Vector2<f64>) -> Vector3<f64> {
        self.tool_jacobian_in_body(q) * q_dot
    }
}
