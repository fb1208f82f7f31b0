//! The commands `set_object` and `set_transform` of MeshCat. A part is an object of the JSON format of the three.js loader, encoded
//! in `MessagePack`.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};
use rmpv::Value;

use crate::server::viewers::drawing::{Part, rgb};
use crate::server::viewers::pack::{encode, f32_bytes, map, numbers, u32_bytes};
use twin_plant::model::Shape;

/// Type of the `MessagePack` extension for a `Uint32Array`.
const U32_ARRAY: i8 = 0x16;

/// Type of the `MessagePack` extension for a `Float32Array`.
const F32_ARRAY: i8 = 0x17;

/// The command that draws a part at its path.
pub(super) fn set_object(part: &Part) -> Value {
    let ids = ["geometry", "material", "mesh"].map(|kind| format!("{}/{kind}", part.path));
    set_object_as(part, ids)
}

/// [`set_object`] with given identifiers of geometry, material and mesh.
fn set_object_as(part: &Part, [geometry, material, mesh]: [String; 3]) -> Value {
    let object = map! {
        "metadata" => map! { "version" => 4.5, "type" => "Object" },
        "geometries" => Value::Array(vec![shape(&part.shape, &geometry)]),
        "materials" => Value::Array(vec![paint(part.rgba, &material)]),
        "object" => map! {
            "uuid" => mesh,
            "type" => "Mesh",
            "geometry" => geometry,
            "material" => material,
            "matrix" => numbers(own_matrix(part)),
        },
    };
    map! { "type" => "set_object", "object" => object, "path" => part.path.as_str() }
}

/// The command that draws line segments at a path. `ends` has two ends `[x y z]` for each segment, in the parent's frame, m.
pub(super) fn set_line_segments(path: &str, rgb: [u8; 3], ends: Vec<f32>) -> Value {
    let ids = ["geometry", "material", "line"].map(|kind| format!("{path}/{kind}"));
    set_line_segments_as(path, rgb, ends, ids)
}

/// Radius of an arrow at its foot, m; it ends in a point.
const NEEDLE_RADIUS_M: f64 = 0.01;

/// The command that draws an arrow at a path. The arrow has length one and points along y from the origin; [`needle_matrix`] turns
/// and stretches it.
pub(super) fn set_needle(path: &str, rgb: [u8; 3]) -> Value {
    let [geometry, material, mesh] =
        ["geometry", "material", "mesh"].map(|kind| format!("{path}/{kind}"));
    let cone = map! {
        "uuid" => geometry.as_str(),
        "type" => "CylinderGeometry",
        "radiusTop" => 0.0,
        "radiusBottom" => NEEDLE_RADIUS_M,
        "height" => 1.0,
        "radialSegments" => 16,
    };
    let foot = column_major(&Matrix4::new_translation(&Vector3::new(0.0, 0.5, 0.0)));
    let object = map! {
        "metadata" => map! { "version" => 4.5, "type" => "Object" },
        "geometries" => Value::Array(vec![cone]),
        "materials" => Value::Array(vec![material_of("MeshPhongMaterial", rgb, 1.0, &material)]),
        "object" => map! {
            "uuid" => mesh,
            "type" => "Mesh",
            "geometry" => geometry,
            "material" => material,
            "matrix" => numbers(foot),
        },
    };
    map! { "type" => "set_object", "object" => object, "path" => path }
}

/// Length of the shortest arrow, m. An arrow of zero length would have a singular matrix, which the viewer cannot decompose.
const SHORTEST_M: f64 = 1e-3;

/// The matrix that turns and stretches an arrow so that it reaches from foot to tip, m; column-major.
pub(super) fn needle_matrix([foot, tip]: [[f32; 3]; 2]) -> [f32; 16] {
    let [foot, tip] = [foot, tip].map(|point| Vector3::from(point.map(f64::from)));
    let way = tip - foot;
    let turn = UnitQuaternion::rotation_between(&Vector3::y(), &way)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI));
    let pose = Isometry3::from_parts(Translation3::from(foot), turn).to_homogeneous();
    let stretch = Vector3::new(1.0, way.norm().max(SHORTEST_M), 1.0);
    column_major(&(pose * Matrix4::new_nonuniform_scaling(&stretch))).map(|value| value as f32)
}

/// [`set_line_segments`] with given identifiers of geometry, material and line.
fn set_line_segments_as(
    path: &str,
    rgb: [u8; 3],
    ends: Vec<f32>,
    [geometry, material, line]: [String; 3],
) -> Value {
    let shape = map! {
        "uuid" => geometry.as_str(),
        "type" => "BufferGeometry",
        "data" => map! {
            "attributes" => map! {
                "position" => array("Float32Array", Value::Ext(F32_ARRAY, f32_bytes(ends))),
            },
        },
    };
    let object = map! {
        "metadata" => map! { "version" => 4.5, "type" => "Object" },
        "geometries" => Value::Array(vec![shape]),
        "materials" => Value::Array(vec![material_of("LineBasicMaterial", rgb, 1.0, &material)]),
        "object" => map! {
            "uuid" => line,
            "type" => "LineSegments",
            "geometry" => geometry,
            "material" => material,
            "matrix" => numbers(column_major(&Matrix4::identity())),
        },
    };
    map! { "type" => "set_object", "object" => object, "path" => path }
}

fn shape(shape: &Shape, id: &str) -> Value {
    match shape {
        Shape::Box { size_m: [x, y, z] } => map! {
            "uuid" => id, "type" => "BoxGeometry", "width" => *x, "height" => *y, "depth" => *z,
        },
        Shape::Sphere { radius_m } => map! {
            "uuid" => id,
            "type" => "SphereGeometry",
            "radius" => *radius_m,
            "widthSegments" => 20,
            "heightSegments" => 20,
        },
        Shape::Cylinder { radius_m, length_m } | Shape::Capsule { radius_m, length_m } => map! {
            "uuid" => id,
            "type" => "CylinderGeometry",
            "radiusTop" => *radius_m,
            "radiusBottom" => *radius_m,
            "height" => *length_m,
            "radialSegments" => 50,
        },
        Shape::Mesh { vertices, triangles } => {
            let corners = f32_bytes(vertices.iter().flatten().map(|&value| value as f32));
            let indices = u32_bytes(triangles.iter().flatten().copied());
            map! {
                "uuid" => id,
                "type" => "BufferGeometry",
                "data" => map! {
                    "attributes" => map! {
                        "position" => array("Float32Array", Value::Ext(F32_ARRAY, corners)),
                    },
                    "index" => array("Uint32Array", Value::Ext(U32_ARRAY, indices)),
                },
            }
        }
    }
}

fn array(kind: &str, values: Value) -> Value {
    map! { "itemSize" => 3, "type" => kind, "array" => values, "normalized" => false }
}

fn paint(rgba: [f32; 4], id: &str) -> Value {
    material_of("MeshPhongMaterial", rgb(rgba), rgba[3], id)
}

fn material_of(kind: &str, rgb: [u8; 3], opacity: f32, id: &str) -> Value {
    let [r, g, b] = rgb.map(u32::from);
    map! {
        "uuid" => id,
        "type" => kind,
        "color" => r << 16 | g << 8 | b,
        "reflectivity" => 0.5,
        "side" => 2,
        "transparent" => opacity < 1.0,
        "opacity" => f64::from(opacity),
        "linewidth" => 1.0,
        "wireframe" => false,
        "wireframeLinewidth" => 1.0,
        "vertexColors" => 0,
    }
}

/// Node-from-shape transform, column-major. three.js draws cylinders along y, and ours lie along z.
fn own_matrix(part: &Part) -> [f64; 16] {
    let mut pose = isometry(part.position, part.quaternion_wxyz);
    if matches!(part.shape, Shape::Cylinder { .. } | Shape::Capsule { .. }) {
        let quarter = std::f64::consts::FRAC_PI_2;
        pose *= UnitQuaternion::from_axis_angle(&Vector3::x_axis(), quarter);
    }
    column_major(&pose.to_homogeneous())
}

/// The command that moves a node: `[x y z w x y z]` in the world, m.
pub(super) fn set_transform(path: &str, pose: [f32; 7]) -> Value {
    set_matrix(path, matrix_of(pose))
}

fn set_matrix(path: &str, matrix: [f32; 16]) -> Value {
    let bytes = f32_bytes(matrix);
    map! { "type" => "set_transform", "path" => path, "matrix" => Value::Ext(F32_ARRAY, bytes) }
}

/// The matrix of a pose `[x y z w x y z]`, m; column-major.
fn matrix_of(pose: [f32; 7]) -> [f32; 16] {
    let [x, y, z, qw, qx, qy, qz] = pose.map(f64::from);
    let matrix = column_major(&isometry([x, y, z], [qw, qx, qy, qz]).to_homogeneous());
    matrix.map(|value| value as f32)
}

/// The encoded command that moves a node. From pose to pose only the matrix at the end of its bytes changes.
#[derive(Clone, Debug)]
pub(super) struct Mover(Vec<u8>);

impl Mover {
    /// The command for the node at a path.
    pub(super) fn new(path: &str) -> Self {
        Self(encode(&set_matrix(path, [0.0; 16])))
    }

    /// Moves the node to the pose `[x y z w x y z]` in the world, m.
    pub(super) fn to(&self, pose: [f32; 7]) -> Vec<u8> {
        self.to_matrix(matrix_of(pose))
    }

    /// Moves the node by a matrix, column-major, which may scale.
    pub(super) fn to_matrix(&self, matrix: [f32; 16]) -> Vec<u8> {
        let mut bytes = self.0.clone();
        let start = bytes.len() - size_of_val(&matrix);
        bytes[start..].copy_from_slice(&f32_bytes(matrix));
        bytes
    }
}

fn isometry(position: [f64; 3], [w, x, y, z]: [f64; 4]) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(position), rotation)
}

fn column_major(matrix: &Matrix4<f64>) -> [f64; 16] {
    std::array::from_fn(|k| matrix[(k % 4, k / 4)])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn part(path: &str, shape: Shape, rgba: [f32; 4]) -> Part {
        let (position, quaternion_wxyz) = ([0.0; 3], [1.0, 0.0, 0.0, 0.0]);
        Part { path: path.to_owned(), position, quaternion_wxyz, shape, rgba }
    }

    fn ids(first: u32) -> [String; 3] {
        std::array::from_fn(|k| format!("00000000-0000-0000-0000-{:012x}", first as usize + k))
    }

    /// The bytes that meshcat-python sent for the same command; `None` outside of a full checkout.
    pub(in crate::server::viewers) fn reference(name: &str) -> Option<Vec<u8>> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/fixtures/meshcat");
        let bytes = std::fs::read(format!("{folder}/{name}.bin")).ok();
        if bytes.is_none() {
            eprintln!("SKIPPED: the reference bytes {name} are not here");
        }
        bytes
    }

    #[test]
    fn spheres_and_meshes_have_the_bytes_of_meshcat_python() {
        let ball = part("/meshcat/sphere", Shape::Sphere { radius_m: 0.3 }, [0.0, 1.0, 0.0, 0.5]);
        let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Shape::Mesh { vertices: corners, triangles: vec![[0, 1, 2]] };
        // The colour is 0x112233 as fractions.
        let sheet = part("/meshcat/tri", mesh, [17.0 / 255.0, 34.0 / 255.0, 0.2, 1.0]);
        for (name, part, first) in
            [("set_object_sphere", ball, 5), ("set_object_trimesh", sheet, 0x0e)]
        {
            let Some(wanted) = reference(name) else { continue };
            assert_eq!(encode(&set_object_as(&part, ids(first))), wanted, "{name}");
        }
    }

    #[test]
    fn a_line_has_the_bytes_of_meshcat_python() {
        let ends = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let line = set_line_segments_as("/meshcat/line", [255, 0, 0], ends, ids(0x14));
        let Some(wanted) = reference("set_object_linesegments") else { return };
        assert_eq!(encode(&line), wanted);
    }

    #[test]
    fn boxes_and_cylinders_have_the_geometry_of_meshcat_python() {
        // meshcat-python uses another material and another axis, so only the geometry must be equal.
        let brick = Shape::Box { size_m: [1.0, 0.5, 0.25] };
        let tube = Shape::Cylinder { radius_m: 0.1, length_m: 1.0 };
        for (name, solid, id) in [("set_object_box", brick, 2), ("set_object_cylinder", tube, 8)] {
            let Some(wanted) = reference(name) else { continue };
            let made = encode(&shape(&solid, &ids(id)[0]));
            assert!(wanted.windows(made.len()).any(|bytes| bytes == made), "{name}");
        }
    }

    #[test]
    fn a_transform_has_the_bytes_of_the_reference_but_for_zeros() {
        // The pose is a quarter turn about z at (0.5, -1, 2). Some elements are 6e-17 in the reference and another tiny number here.
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let pose = [0.5, -1.0, 2.0, half, 0.0, 0.0, half];
        let bytes = encode(&set_transform("/meshcat/box", pose));
        assert_eq!(Mover::new("/meshcat/box").to(pose), bytes);
        let Some(wanted) = reference("set_transform_f32ext") else { return };
        assert_eq!(bytes.len(), wanted.len());
        assert_eq!(bytes[..bytes.len() - 64], wanted[..wanted.len() - 64]);
        let numbers = |bytes: &[u8]| -> Vec<f32> {
            let tail = &bytes[bytes.len() - 64..];
            tail.chunks(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect()
        };
        for (made, wanted) in numbers(&bytes).into_iter().zip(numbers(&wanted)) {
            // The tolerance is a few roundings of f32 numbers up to 2.
            assert!((made - wanted).abs() < 1e-6, "{made} {wanted}");
        }
    }

    #[test]
    fn a_needle_reaches_from_foot_to_tip_and_is_nowhere_thicker() {
        // The tolerance is a few roundings of f32. An arrow of zero force is one millimetre long.
        let whole = 1e-6;
        for (tip, room) in [
            ([0.3, -0.2, 0.9], whole),
            ([0.0, -1.0, 0.0], whole),
            ([0.5, 0.1, 0.2], whole),
            ([0.1, 0.1, 0.2], 1.1 * SHORTEST_M),
        ] {
            let foot = [0.1_f32, 0.1, 0.2];
            let m = needle_matrix([foot, tip]).map(f64::from);
            let column = |k: usize| Vector3::new(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
            let reached = column(3) + column(1);
            let wanted = Vector3::from(tip.map(f64::from));
            assert!((reached - wanted).norm() < room, "{tip:?}: {reached}");
            for k in [0, 2] {
                assert!((column(k).norm() - 1.0).abs() < 1e-6, "{tip:?}");
                assert!(column(k).dot(&column(1)).abs() < 1e-6, "{tip:?}");
            }
        }
    }

    #[test]
    fn a_cylinder_along_z_is_turned_from_the_y_axis_of_three_js() {
        let shape = Shape::Cylinder { radius_m: 0.1, length_m: 1.0 };
        let matrix = own_matrix(&part("/x", shape, [1.0; 4]));
        // The second column is the image of the y axis: the z axis.
        for (found, wanted) in matrix[4..7].iter().zip([0.0, 0.0, 1.0]) {
            assert!((found - wanted).abs() < 1e-12);
        }
    }
}
