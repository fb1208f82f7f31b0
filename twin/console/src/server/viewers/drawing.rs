//! The drawing of a scene for both viewers: nodes (frames), and parts (shapes) that are fixed to them.

use std::f64::consts::{PI, TAU};

use crate::server::telemetry::Picture;
use twin_core::elementary::{cos, sin};
use twin_plant::model::Shape;
use twin_record::scene::Scene;

/// Path of the root of the drawing.
pub(super) const ROOT: &str = "/twin";

/// Path of the reference, which is drawn together with the estimate.
pub(super) const GHOST: &str = "/twin/reference";

const GHOST_RGBA: [f32; 4] = [0.0, 0.62, 0.45, 0.35];
const ROTOR_RGBA: [f32; 4] = [0.34, 0.71, 0.91, 0.35];
const ROTOR_THICKNESS_M: f64 = 0.004;

/// Number of sides of round shapes that are drawn as triangles; even.
const SIDES: u32 = 24;

/// A surface: corners in m, and triangles as indices of corners, counter-clockwise seen from outside.
pub(super) type Surface = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A frame to which parts are fixed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    /// Unique path.
    pub path: String,
    /// `[x y z w x y z]` in the world at the start, m.
    pub pose: [f32; 7],
    /// Whether the node moves, that is, has a pose in [`Drawing::poses`].
    pub moving: bool,
}

/// One shape.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    /// Unique path, below that of its node.
    pub path: String,
    /// Origin in the node's frame, m.
    pub position: [f64; 3],
    /// Node-from-part quaternion, `[w x y z]`.
    pub quaternion_wxyz: [f64; 4],
    /// Form and size. It is never a capsule, because the pinned viewers have none.
    pub shape: Shape,
    /// Colour and opacity, 0 to 1.
    pub rgba: [f32; 4],
}

/// All nodes and parts of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Drawing {
    /// Frames.
    pub nodes: Vec<Node>,
    /// Shapes.
    pub parts: Vec<Part>,
    /// Paths of the moving nodes in the order of [`Drawing::poses`].
    pub moving: Vec<String>,
    /// Path of the node of the vehicle's root body; `None` if the scene has no vehicle.
    pub base: Option<String>,
}

impl Drawing {
    /// The drawing of a scene: its bodies, rotor discs on the vehicle's root, and a second root as the reference.
    pub(super) fn new(scene: &Scene) -> Self {
        let mut drawing = Self::default();
        for (index, body) in scene.bodies.iter().enumerate() {
            let path = format!("{ROOT}/{}", segment(&body.name, index));
            drawing.add_shapes(&path, body.shapes.iter().map(|part| (part, part.rgba)));
            let (p, q) = (body.pose.position, body.pose.quaternion_wxyz);
            let pose = [p[0], p[1], p[2], q[0], q[1], q[2], q[3]].map(|value| value as f32);
            if body.name == scene.base_body {
                drawing.add_rotors(&path, scene, ROTOR_RGBA);
                drawing.base = Some(path.clone());
            }
            if body.moving {
                drawing.moving.push(path.clone());
            }
            drawing.nodes.push(Node { path, pose, moving: body.moving });
        }
        if let Some(base) = scene.bodies.iter().find(|body| body.name == scene.base_body) {
            drawing.add_shapes(GHOST, base.shapes.iter().map(|part| (part, GHOST_RGBA)));
            drawing.add_rotors(GHOST, scene, GHOST_RGBA);
        }
        let pose = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        drawing.nodes.push(Node { path: GHOST.to_owned(), pose, moving: true });
        drawing.moving.push(GHOST.to_owned());
        drawing
    }

    /// Paths and poses of the moving nodes, `[x y z w x y z]` in the world, m; NaN where unknown.
    pub(super) fn poses<'a>(
        &'a self,
        picture: &'a Picture,
    ) -> impl Iterator<Item = (&'a str, [f32; 7])> {
        let poses = picture.poses.iter().chain([&picture.ghost]).copied();
        self.moving.iter().map(String::as_str).zip(poses)
    }

    fn add_shapes<'a>(
        &mut self,
        node: &str,
        shapes: impl Iterator<Item = (&'a twin_record::scene::ShapeInfo, [f32; 4])>,
    ) {
        for (index, (part, rgba)) in shapes.enumerate() {
            let shape = match part.shape {
                Shape::Capsule { radius_m, length_m } => {
                    let (vertices, triangles) = capsule(radius_m, length_m);
                    Shape::Mesh { vertices, triangles }
                }
                ref other => other.clone(),
            };
            self.parts.push(Part {
                path: format!("{node}/shape{index}"),
                position: part.position,
                quaternion_wxyz: part.quaternion_wxyz,
                shape,
                rgba,
            });
        }
    }

    fn add_rotors(&mut self, node: &str, scene: &Scene, rgba: [f32; 4]) {
        for (index, rotor) in scene.rotors.iter().enumerate() {
            self.parts.push(Part {
                path: format!("{node}/rotor{}", index + 1),
                position: rotor.position_in_body,
                quaternion_wxyz: [1.0, 0.0, 0.0, 0.0],
                shape: Shape::Cylinder { radius_m: rotor.radius_m, length_m: ROTOR_THICKNESS_M },
                rgba,
            });
        }
    }
}

/// Poses that a client has got, in the order of the moving nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct SentPoses(Vec<[f32; 7]>);

impl SentPoses {
    /// Index and pose of each node that has moved. The caller must send them, because they count as sent. A node with an unknown
    /// pose stays in place.
    pub(super) fn news<'a>(
        &mut self,
        poses: impl Iterator<Item = (&'a str, [f32; 7])>,
    ) -> impl Iterator<Item = (usize, [f32; 7])> {
        poses.enumerate().filter_map(|(place, (_, pose))| {
            if self.0.len() <= place {
                self.0.resize(place + 1, [f32::NAN; 7]);
            }
            let told = &mut self.0[place];
            let known = pose.iter().all(|value| value.is_finite());
            let moved = known && pose.map(f32::to_bits) != told.map(f32::to_bits);
            moved.then(|| *told = pose).map(|()| (place, pose))
        })
    }
}

/// A body's name as one segment of a path; `body` and its index if the name does not fit into a path or is taken.
fn segment(name: &str, index: usize) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    let taken = matches!(name, "" | "reference" | "trails" | "forces");
    if !taken && name.chars().all(plain) { name.to_owned() } else { format!("body{index}") }
}

/// Red, green and blue of a colour, 0 to 255.
pub(super) fn rgb(rgba: [f32; 4]) -> [u8; 3] {
    [rgba[0], rgba[1], rgba[2]].map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// The surface of a capsule along z: one ring of corners per angle from the lower to the upper pole, and two at the equator.
fn capsule(radius_m: f64, length_m: f64) -> Surface {
    let quarter = SIDES / 4;
    let lower = (0..=quarter).map(|k| (k, -0.5));
    let upper = (quarter..=2 * quarter).map(|k| (k, 0.5));
    let mut vertices = Vec::new();
    for (k, side) in lower.chain(upper) {
        let angle = PI * f64::from(k) / f64::from(2 * quarter) - PI / 2.0;
        for step in 0..SIDES {
            let around = TAU * f64::from(step) / f64::from(SIDES);
            let ring = radius_m * cos(angle);
            let z = radius_m * sin(angle) + side * length_m;
            vertices.push([ring * cos(around), ring * sin(around), z]);
        }
    }
    let rings = 2 * quarter + 2;
    let mut triangles = Vec::new();
    for ring in 0..rings - 1 {
        for step in 0..SIDES {
            let next = (step + 1) % SIDES;
            let [a, b] = [step, next].map(|k| ring * SIDES + k);
            let [c, d] = [a + SIDES, b + SIDES];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use twin_core::elementary::powi;
    use twin_record::fixture;

    #[test]
    fn a_capsule_encloses_its_volume_and_every_corner_lies_on_it() {
        let (radius, length) = (0.2, 0.5);
        let (vertices, triangles) = capsule(radius, length);
        for [x, y, z] in &vertices {
            let from_axis = (z.abs() - length / 2.0).max(0.0);
            let distance = (x * x + y * y + from_axis * from_axis).sqrt();
            assert!((distance - radius).abs() < 1e-12, "{distance}");
        }
        // By the divergence theorem the volume is positive only if the triangles are counter-clockwise seen from outside.
        let volume: f64 = triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|k| nalgebra::Vector3::from(vertices[k as usize]));
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum();
        let round = PI * radius * radius * length + 4.0 / 3.0 * PI * powi(radius, 3);
        // A circle with 24 flat sides has about 1.1 % less area, and such a sphere about 2 % less volume.
        assert!(volume < round && volume > 0.96 * round, "{volume} {round}");
    }

    #[test]
    fn a_pose_is_told_once_and_one_that_is_unknown_not_at_all() {
        let mut told = SentPoses::default();
        let at = |x: f32| [x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        let mut news = |poses: [[f32; 7]; 2]| {
            told.news(poses.into_iter().map(|pose| ("", pose))).collect::<Vec<_>>()
        };
        assert_eq!(news([at(f32::NAN), at(1.0)]), [(1, at(1.0))]);
        assert_eq!(news([at(0.0), at(1.0)]), [(0, at(0.0))]);
        assert!(news([at(0.0), at(f32::NAN)]).is_empty());
        assert_eq!(news([at(-0.0), at(2.0)]), [(0, at(-0.0)), (1, at(2.0))]);
    }

    #[test]
    fn paths_are_unique_and_every_part_hangs_on_a_node() {
        let scene = fixture::scene();
        let drawing = Drawing::new(&scene);
        let mut paths: Vec<&str> = drawing.nodes.iter().map(|node| node.path.as_str()).collect();
        for part in &drawing.parts {
            let (node, _) = part.path.rsplit_once('/').expect("a path");
            assert!(drawing.nodes.iter().any(|known| known.path == node), "{node}");
            assert!(!matches!(part.shape, Shape::Capsule { .. }));
        }
        paths.extend(drawing.parts.iter().map(|part| part.path.as_str()));
        let count = paths.len();
        paths.sort_unstable();
        paths.dedup();
        assert_eq!(paths.len(), count);
        assert_eq!(drawing.moving.len(), scene.moving().count() + 1);
        for name in ["", "a/b", "reference", "trails", "forces", "..\u{0}"] {
            assert_eq!(segment(name, 3), "body3");
        }
    }
}
