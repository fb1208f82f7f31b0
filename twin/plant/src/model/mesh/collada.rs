//! COLLADA (.dae): triangles and polygons of the scene, node transforms and unit applied.
//!
//! Coordinates are taken as written, and `up_axis` rotates nothing: the ROS viewers do the same. Materials are not read.

use std::collections::HashMap;

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node};

use super::Triangles;
use twin_input::budget::TRIANGLES;

/// Deepest nesting of scene nodes.
const MAX_DEPTH: usize = 64;
/// Most inputs of a corner; exporters write up to six.
const MAX_INPUTS: usize = 64;
/// Most triangles of one file.
const MAX_TRIANGLES: usize = TRIANGLES.most as usize;

pub(super) fn parse(bytes: &[u8]) -> Result<Triangles, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "not UTF-8 text".to_owned())?;
    let document = Document::parse(text).map_err(|error| format!("not XML: {error}"))?;
    if document.root_element().tag_name().name() != "COLLADA" {
        return Err("no <COLLADA>".into());
    }
    let mut reader = Reader {
        by_id: document
            .descendants()
            .filter_map(|node| Some((node.attribute("id")?, node)))
            .collect(),
        mesh: Triangles::default(),
    };
    let meter = document.descendants().find(|node| is(*node, "unit"));
    let meter = meter.and_then(|unit| unit.attribute("meter")).map_or(Ok(1.0), str::parse);
    let meter: f64 = meter.map_err(|_| "<unit meter> is not a number".to_owned())?;
    let transform = Matrix4::new_scaling(meter);
    let scene = document.descendants().find(|node| is(*node, "instance_visual_scene"));
    match scene {
        Some(scene) => reader.nodes(reader.target(scene, "url")?, &transform, 0)?,
        None => {
            for geometry in document.descendants().filter(|node| is(*node, "geometry")) {
                reader.geometry(geometry, &transform)?;
            }
        }
    }
    Ok(reader.mesh)
}

struct Reader<'n, 'i> {
    by_id: HashMap<&'n str, Node<'n, 'i>>,
    mesh: Triangles,
}

impl<'n, 'i> Reader<'n, 'i> {
    fn target(&self, node: Node<'_, '_>, attribute: &str) -> Result<Node<'n, 'i>, String> {
        let reference = node.attribute(attribute).unwrap_or("");
        let found = self.by_id.get(reference.trim_start_matches('#')).copied();
        found.ok_or_else(|| {
            format!("<{}> names the unknown id {reference:?}", node.tag_name().name())
        })
    }

    fn nodes(
        &mut self,
        parent: Node<'n, 'i>,
        transform: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), String> {
        if depth > MAX_DEPTH {
            return Err(format!("scene nodes nested deeper than {MAX_DEPTH}"));
        }
        for child in parent.children().filter(Node::is_element) {
            match child.tag_name().name() {
                "node" => self.nodes(child, &(transform * local_transform(child)?), depth + 1)?,
                "instance_geometry" => self.geometry(self.target(child, "url")?, transform)?,
                other @ ("instance_node" | "instance_controller") => {
                    return Err(format!("<{other}> is not read, apply it before the export"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn geometry(&mut self, geometry: Node<'n, 'i>, transform: &Matrix4<f64>) -> Result<(), String> {
        let primitives = geometry
            .descendants()
            .filter(|node| matches!(node.tag_name().name(), "triangles" | "polylist" | "polygons"));
        for primitive in primitives {
            self.primitive(primitive, transform)?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        primitive: Node<'n, 'i>,
        transform: &Matrix4<f64>,
    ) -> Result<(), String> {
        let inputs = primitive.children().filter(|node| is(*node, "input"));
        let (mut width, mut vertex) = (1, None);
        for input in inputs {
            let offset = input.attribute("offset").unwrap_or("0").parse().ok();
            let offset: usize = offset
                .filter(|offset| *offset < MAX_INPUTS)
                .ok_or("an <input offset> that is not a small whole number")?;
            width = width.max(offset + 1);
            if input.attribute("semantic") == Some("VERTEX") {
                vertex = Some((input, offset));
            }
        }
        let (vertex, vertex_offset) = vertex.ok_or("a primitive without VERTEX input")?;

        let first = self.mesh.vertices.len();
        let positions = self.positions(self.target(vertex, "source")?)?;
        let place = |point: &[f64; 3]| -> [f64; 3] {
            transform.transform_point(&Point3::from(*point)).into()
        };
        self.mesh.vertices.extend(positions.iter().map(place));

        let counts: Option<Vec<usize>> =
            primitive.children().find(|node| is(*node, "vcount")).map(numbers).transpose()?;
        for list in primitive.children().filter(|node| is(*node, "p")) {
            let all: Vec<usize> = numbers(list)?;
            let corners: Vec<usize> =
                all.chunks_exact(width).map(|corner| corner[vertex_offset]).collect();
            if corners.iter().any(|corner| *corner >= positions.len()) {
                return Err("a face names a vertex that does not exist".into());
            }
            match (&counts, primitive.tag_name().name()) {
                (_, "polygons") => self.fan(first, &corners)?,
                (Some(counts), _) => {
                    let mut rest = &corners[..];
                    for &count in counts {
                        let (face, others) = rest
                            .split_at_checked(count)
                            .ok_or("fewer corners than <vcount> says")?;
                        self.fan(first, face)?;
                        rest = others;
                    }
                }
                (None, _) => {
                    corners.chunks_exact(3).try_for_each(|face| self.fan(first, face))?;
                }
            }
        }
        Ok(())
    }

    fn fan(&mut self, first: usize, corners: &[usize]) -> Result<(), String> {
        if self.mesh.triangles.len() + corners.len() > MAX_TRIANGLES {
            return Err(format!("more than {MAX_TRIANGLES} triangles"));
        }
        let index = |corner: usize| (first + corner) as u32;
        let pairs = corners.windows(2).skip(1);
        let fan = pairs.map(|pair| [index(corners[0]), index(pair[0]), index(pair[1])]);
        self.mesh.triangles.extend(fan);
        Ok(())
    }

    /// The positions that a `<vertices>` element stands for.
    fn positions(&self, vertices: Node<'n, 'i>) -> Result<Vec<[f64; 3]>, String> {
        let position = vertices
            .children()
            .find(|node| is(*node, "input") && node.attribute("semantic") == Some("POSITION"));
        let source = self.target(position.ok_or("<vertices> without POSITION")?, "source")?;
        let array = source.children().find(|node| is(*node, "float_array"));
        let values: Vec<f64> = numbers(array.ok_or("a <source> without <float_array>")?)?;
        let accessor = source.descendants().find(|node| is(*node, "accessor"));
        let stride = accessor.and_then(|accessor| accessor.attribute("stride")).unwrap_or("3");
        let stride: usize = stride.parse().map_err(|_| "<accessor stride> is not a number")?;
        if stride < 3 {
            return Err("positions that are not x y z".into());
        }
        if self.mesh.vertices.len() + values.len() > MAX_TRIANGLES * 3 {
            return Err(format!("more than {} vertices", MAX_TRIANGLES * 3));
        }
        Ok(values.chunks_exact(stride).map(|point| [point[0], point[1], point[2]]).collect())
    }
}

/// A node's own transforms, in the order in which they are written.
fn local_transform(node: Node<'_, '_>) -> Result<Matrix4<f64>, String> {
    let mut transform = Matrix4::identity();
    for child in node.children().filter(Node::is_element) {
        let name = child.tag_name().name();
        if !matches!(name, "matrix" | "translate" | "rotate" | "scale" | "lookat" | "skew") {
            continue;
        }
        let values: Vec<f64> = numbers(child)?;
        transform *= match (name, &values[..]) {
            ("matrix", all) if all.len() == 16 => Matrix4::from_row_slice(all),
            ("translate", &[x, y, z]) => Matrix4::new_translation(&Vector3::new(x, y, z)),
            ("scale", &[x, y, z]) => Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z)),
            ("rotate", &[x, y, z, degrees]) => {
                let axis = Unit::try_new(Vector3::new(x, y, z), 1e-12);
                axis.map_or_else(Matrix4::identity, |axis| {
                    Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
                })
            }
            _ => return Err(format!("<{name}> with {} numbers is not read", values.len())),
        };
    }
    Ok(transform)
}

fn numbers<T: std::str::FromStr>(node: Node<'_, '_>) -> Result<Vec<T>, String> {
    let words = node.text().unwrap_or("").split_whitespace();
    let parse = |word: &str| {
        word.parse().map_err(|_| format!("{word:?} in <{}> is no number", node.tag_name().name()))
    };
    words.map(parse).collect()
}

fn is(node: Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quad in centimetres, lifted by 5 and turned by 90° about z, then shifted by its parent.
    const QUAD: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="12">0 0 0 100 0 0 100 200 0 0 200 0</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="1"/>
<vcount>4</vcount><p>0 9 1 9 2 9 3 9</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node><matrix>1 0 0 1000 0 1 0 0 0 0 1 0 0 0 0 1</matrix>
<node><translate>0 0 5</translate><rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"##;

    /// A rotation by 90° in f64 is exact to a few roundings.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn transforms_unit_and_polygons_are_applied() {
        let mesh = parse(QUAD.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        let oracle = [[10.0, 0.0, 0.05], [10.0, 1.0, 0.05], [8.0, 1.0, 0.05], [8.0, 0.0, 0.05]];
        for (vertex, oracle) in mesh.vertices.iter().zip(oracle) {
            assert!(
                (Vector3::from(*vertex) - Vector3::from(oracle)).norm() < ROUNDING,
                "{vertex:?}"
            );
        }
    }

    #[test]
    fn triangles_and_polygons_hold_the_same_faces() {
        let polygons = QUAD.replace("polylist", "polygons").replace("<vcount>4</vcount>", "");
        assert_eq!(parse(polygons.as_bytes()), parse(QUAD.as_bytes()));
        let triangles = QUAD
            .replace("polylist", "triangles")
            .replace("<vcount>4</vcount><p>0 9 1 9 2 9 3 9", "<p>0 9 1 9 2 9 0 9 2 9 3 9");
        assert_eq!(parse(triangles.as_bytes()), parse(QUAD.as_bytes()));
    }

    #[test]
    fn broken_files_are_refused() {
        for end in (0..QUAD.len()).step_by(7) {
            assert!(parse(&QUAD.as_bytes()[..end]).is_err(), "accepted {end} bytes");
        }
        for (from, to, words) in [
            ("3 9</p>", "7 9</p>", "does not exist"),
            ("<vcount>4", "<vcount>5", "fewer corners"),
            ("<vcount>4", "<vcount>-4", "no number"),
            ("url=\"#g\"", "url=\"#h\"", "unknown id \"#h\""),
            ("stride=\"3\"", "stride=\"0\"", "not x y z"),
            ("offset=\"1\"", "offset=\"18446744073709551615\"", "small whole number"),
            ("<translate>0 0 5", "<translate>0 5", "2 numbers"),
            ("<instance_geometry", "<instance_controller", "is not read"),
        ] {
            let text = QUAD.replacen(from, to, 1);
            assert_ne!(text, QUAD);
            let found = parse(text.as_bytes()).expect_err(words);
            assert!(found.contains(words), "{words}: {found}");
        }
    }
}
