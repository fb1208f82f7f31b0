//! Ticks as the `foxglove.*` messages that Foxglove, Lichtblick and Rerun draw unaided.

use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, CylinderPrimitive, Duration, FrameTransform,
    FrameTransforms, JointState, JointStates, Log, Point3, Pose, Quaternion, SceneEntity,
    SceneUpdate, SpherePrimitive, Timestamp, TriangleListPrimitive, Vector3, log,
};
use nalgebra::UnitQuaternion;

use crate::scene::{Scene, SceneBody, ShapeInfo};
use twin_core::tick::{self, Contact, EventKind, Tick};
use twin_plant::model::Shape;

/// The frame that is the root of all frames.
const WORLD: &str = "world";

/// Length of a contact arrow, m/N.
const ARROW_M_PER_N: f64 = 0.02;

/// Weakest contact that is drawn, N.
const SMALLEST_ARROW_N: f64 = 0.01;

/// World-from-body transforms of the moving bodies at `tick`.
pub(super) fn transforms(scene: &Scene, tick: &Tick) -> FrameTransforms {
    transforms_at(scene, tick.measurement.t_s, scene.poses_at(tick))
}

/// World-from-body transforms of the moving bodies at `poses`, in the order of the scene; a body whose pose is `None` is left out.
pub fn transforms_at(
    scene: &Scene,
    t_s: f64,
    poses: impl IntoIterator<Item = Option<tick::Pose>>,
) -> FrameTransforms {
    let transforms = scene
        .moving()
        .zip(poses)
        .filter_map(|(body, pose)| Some((body, pose?)))
        .filter(|(_, pose)| {
            pose.position.iter().chain(&pose.quaternion_wxyz).all(|v| v.is_finite())
        })
        .map(|(body, pose)| FrameTransform {
            timestamp: Some(timestamp(t_s)),
            parent_frame_id: WORLD.to_owned(),
            child_frame_id: body.name.clone(),
            translation: Some(vector(pose.position)),
            rotation: Some(quaternion(pose.quaternion_wxyz)),
        })
        .collect();
    FrameTransforms { transforms }
}

/// Arm joints with their measured angles and rates, and the torques that were commanded.
pub(super) fn joint_states(names: &[String], tick: &Tick) -> JointStates {
    let joints = [0, 1].map(|index| Joint {
        position_rad: Some(tick.measurement.chi[6 + index]).filter(|v| v.is_finite()),
        velocity_rad_s: Some(tick.measurement.chi_dot[6 + index]).filter(|v| v.is_finite()),
        torque_n_m: Some(tick.actuators.joint_torque_n_m[index]),
    });
    joint_states_at(names, tick.measurement.t_s, joints)
}

/// State of an arm joint; `None` is unknown.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// Measured angle, rad.
    pub position_rad: Option<f64>,
    /// Measured rate, rad/s.
    pub velocity_rad_s: Option<f64>,
    /// Commanded torque, N m.
    pub torque_n_m: Option<f64>,
}

/// A message of the state of the arm joints at `t_s`.
pub fn joint_states_at(names: &[String], t_s: f64, joints: [Joint; 2]) -> JointStates {
    let joints = names
        .iter()
        .zip(joints)
        .map(|(name, joint)| JointState {
            name: name.clone(),
            position: joint.position_rad,
            velocity: joint.velocity_rad_s,
            acceleration: None,
            effort: joint.torque_n_m,
        })
        .collect();
    JointStates { timestamp: Some(timestamp(t_s)), joints }
}

/// Every body of the scene: a moving body in its own frame, the others in the world.
pub(super) fn bodies(scene: &Scene, tick: &Tick) -> SceneUpdate {
    bodies_at(scene, tick.measurement.t_s)
}

/// Every body of the scene at the time `t_s`: a moving body in its own frame, the others in the world.
pub fn bodies_at(scene: &Scene, t_s: f64) -> SceneUpdate {
    SceneUpdate {
        deletions: Vec::new(),
        entities: scene.bodies.iter().map(|body| entity(body, t_s)).collect(),
    }
}

/// Contact forces as arrows; the message without contacts removes the arrows that were drawn before.
pub(super) fn contacts(tick: &Tick) -> SceneUpdate {
    let contacts = tick.truth.as_ref().map_or(&[][..], |truth| &truth.contacts);
    contacts_at(tick.measurement.t_s, contacts.iter().copied())
}

/// Contact forces as arrows at the time `t_s`.
pub fn contacts_at(t_s: f64, contacts: impl Iterator<Item = Contact>) -> SceneUpdate {
    let entity = SceneEntity {
        timestamp: Some(timestamp(t_s)),
        frame_id: WORLD.to_owned(),
        id: "contacts".to_owned(),
        arrows: contacts.filter_map(|contact| arrow(&contact)).collect(),
        ..SceneEntity::default()
    };
    SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
}

/// The events of a tick as log lines.
pub(super) fn logs(tick: &Tick) -> impl Iterator<Item = Log> {
    tick.events.iter().map(|event| log_line(tick.measurement.t_s, event.kind, &event.text))
}

/// An event as a log line.
pub fn log_line(t_s: f64, kind: EventKind, text: &str) -> Log {
    Log {
        timestamp: Some(timestamp(t_s)),
        level: match kind {
            EventKind::Fault => log::Level::Error,
            EventKind::Retry | EventKind::Disturbance | EventKind::Saturation => {
                log::Level::Warning
            }
            _ => log::Level::Info,
        } as i32,
        message: text.to_owned(),
        name: format!("{kind:?}").to_lowercase(),
        file: String::new(),
        line: 0,
    }
}

fn entity(body: &SceneBody, t_s: f64) -> SceneEntity {
    let mut entity = SceneEntity {
        timestamp: Some(timestamp(t_s)),
        frame_id: if body.moving { body.name.clone() } else { WORLD.to_owned() },
        id: body.name.clone(),
        lifetime: Some(Duration::new(0, 0)),
        frame_locked: true,
        ..SceneEntity::default()
    };
    for shape in &body.shapes {
        let pose = if body.moving { shape_pose(shape) } else { compose(&body.pose, shape) };
        draw(&mut entity, shape, pose);
    }
    entity
}

fn draw(entity: &mut SceneEntity, shape: &ShapeInfo, pose: Pose) {
    let color = color(shape.rgba);
    let cylinder = |radius_m: f64, length_m: f64, pose: Pose| CylinderPrimitive {
        pose: Some(pose),
        size: Some(vector([2.0 * radius_m, 2.0 * radius_m, length_m])),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    };
    let sphere = |radius_m: f64, pose: Pose| SpherePrimitive {
        pose: Some(pose),
        size: Some(vector([2.0 * radius_m; 3])),
        color: Some(color),
    };
    match &shape.shape {
        Shape::Box { size_m } => {
            entity.cubes.push(CubePrimitive {
                pose: Some(pose),
                size: Some(vector(*size_m)),
                color: Some(color),
            });
        }
        Shape::Cylinder { radius_m, length_m } => {
            entity.cylinders.push(cylinder(*radius_m, *length_m, pose));
        }
        Shape::Sphere { radius_m } => entity.spheres.push(sphere(*radius_m, pose)),
        Shape::Capsule { radius_m, length_m } => {
            entity.cylinders.push(cylinder(*radius_m, *length_m, pose));
            for end in [-0.5, 0.5] {
                entity.spheres.push(sphere(*radius_m, along_z(&pose, end * length_m)));
            }
        }
        Shape::Mesh { vertices, triangles } => entity.triangles.push(TriangleListPrimitive {
            pose: Some(pose),
            points: vertices.iter().map(|&[x, y, z]| Point3 { x, y, z }).collect(),
            color: Some(color),
            colors: Vec::new(),
            indices: triangles.iter().flatten().copied().collect(),
        }),
    }
}

fn arrow(contact: &Contact) -> Option<ArrowPrimitive> {
    let force = nalgebra::Vector3::from(contact.force_in_world_n);
    let size_n = force.norm();
    if !size_n.is_finite() || size_n < SMALLEST_ARROW_N {
        return None;
    }
    // An arrow points along +x. The rotation between opposite vectors is not unique, so any half turn will do; this one is about z.
    let turn =
        UnitQuaternion::rotation_between(&nalgebra::Vector3::x(), &force).unwrap_or_else(|| {
            UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), std::f64::consts::PI)
        });
    Some(ArrowPrimitive {
        pose: Some(Pose {
            position: Some(vector(contact.point_in_world)),
            orientation: Some(quaternion([turn.w, turn.i, turn.j, turn.k])),
        }),
        shaft_length: size_n * ARROW_M_PER_N,
        shaft_diameter: 0.008,
        head_length: 0.02,
        head_diameter: 0.016,
        color: Some(color([0.835, 0.369, 0.0, 1.0])),
    })
}

fn shape_pose(shape: &ShapeInfo) -> Pose {
    Pose {
        position: Some(vector(shape.position)),
        orientation: Some(quaternion(shape.quaternion_wxyz)),
    }
}

fn compose(world_from_body: &tick::Pose, shape: &ShapeInfo) -> Pose {
    let outer = rotation(world_from_body.quaternion_wxyz);
    let position = outer * nalgebra::Vector3::from(shape.position)
        + nalgebra::Vector3::from(world_from_body.position);
    let turn = outer * rotation(shape.quaternion_wxyz);
    Pose {
        position: Some(vector(position.into())),
        orientation: Some(quaternion([turn.w, turn.i, turn.j, turn.k])),
    }
}

fn along_z(pose: &Pose, distance_m: f64) -> Pose {
    let q = pose.orientation.unwrap_or_default();
    let p = pose.position.unwrap_or_default();
    let shifted = nalgebra::Vector3::new(p.x, p.y, p.z)
        + rotation([q.w, q.x, q.y, q.z]) * nalgebra::Vector3::new(0.0, 0.0, distance_m);
    Pose { position: Some(vector(shifted.into())), orientation: Some(q) }
}

fn rotation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z))
}

fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

fn quaternion([w, x, y, z]: [f64; 4]) -> Quaternion {
    Quaternion { x, y, z, w }
}

fn color(rgba: [f32; 4]) -> Color {
    let [r, g, b, a] = rgba.map(f64::from);
    Color { r, g, b, a }
}

fn timestamp(t_s: f64) -> Timestamp {
    Timestamp::saturating_from_epoch_secs_f64(t_s.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rotations and a sum of numbers near one give far less than a thousand roundings.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn an_arrow_points_where_the_force_points_also_straight_back() {
        for force in [[3.0, 4.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 9.0], [-1.0, 1e-9, 0.0]] {
            let contact = Contact { point_in_world: [1.0, 2.0, 3.0], force_in_world_n: force };
            let drawn = arrow(&contact).unwrap();
            let q = drawn.pose.unwrap().orientation.unwrap();
            let tip = rotation([q.w, q.x, q.y, q.z]) * nalgebra::Vector3::x();
            let wanted = nalgebra::Vector3::from(force).normalize();
            assert!((tip - wanted).norm() < 1e-8, "{force:?} {tip:?}");
            assert!(
                (drawn.shaft_length - nalgebra::Vector3::from(force).norm() * ARROW_M_PER_N).abs()
                    < ROUNDING
            );
        }
    }

    #[test]
    fn no_arrow_for_no_force_or_a_broken_one() {
        for force in [[0.0; 3], [f64::NAN, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
            assert!(
                arrow(&Contact { point_in_world: [0.0; 3], force_in_world_n: force }).is_none()
            );
        }
    }

    #[test]
    fn a_capsule_is_a_cylinder_with_a_sphere_at_each_end_of_its_turned_axis() {
        let shape = ShapeInfo {
            shape: Shape::Capsule { radius_m: 0.1, length_m: 2.0 },
            position: [0.0, 0.0, 1.0],
            // A quarter turn about y lays the axis along x.
            quaternion_wxyz: [0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0],
            rgba: [1.0; 4],
        };
        let mut entity = SceneEntity::default();
        draw(&mut entity, &shape, shape_pose(&shape));
        assert_eq!((entity.cylinders.len(), entity.spheres.len()), (1, 2));
        let ends: Vec<f64> =
            entity.spheres.iter().map(|s| s.pose.unwrap().position.unwrap().x).collect();
        assert!((ends[0] + 1.0).abs() < ROUNDING && (ends[1] - 1.0).abs() < ROUNDING, "{ends:?}");
    }
}
