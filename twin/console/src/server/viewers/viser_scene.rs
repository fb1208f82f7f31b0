//! The scene for viser: a frame for each node, meshes and solids below it, poses as position and orientation.

use rmpv::Value;

use crate::server::viewers::drawing::{Drawing, Part, ROOT, rgb};
use crate::server::viewers::forces::{ARROWS, Arrow, FORCES};
use crate::server::viewers::pack::{f32_bytes, map, numbers, u32_bytes};
use crate::server::viewers::trail::{LINES, TRAILS};
use crate::server::viewers::viser_frame::Batch;
use crate::server::viewers::viser_label as label;
use crate::server::viewers::viser_move::{Mover, position};
use twin_plant::model::Shape;

/// Orientation `[w x y z]` of our world in the y-up world of three.js: our z axis points up.
const WORLD_WXYZ: [f64; 4] = [0.5, -0.5, 0.5, 0.5];

/// Width of a trail, pixels.
const LINE_PX: f64 = 2.0;

/// Radius of an arrow's shaft, m. The sizes of shaft and head are those of the console.
const SHAFT_RADIUS_M: f64 = 0.004;
const HEAD_RADIUS_M: f64 = 0.012;
const HEAD_LENGTH_M: f64 = 0.035;

/// Path of the attitude marks.
const MARKS: &str = "/twin/trails/attitude";

/// Draws all nodes at their poses of the start.
pub(super) fn draw(drawing: &Drawing, batch: &mut Batch) {
    batch.push(&orientation("", WORLD_WXYZ));
    batch.push(&grid());
    batch.push(&frame(ROOT));
    for node in &drawing.nodes {
        batch.push(&frame(&node.path));
        Mover::new(&node.path).place(node.pose, batch);
    }
    for part in &drawing.parts {
        add(part, batch);
        batch.push(&position(&part.path, part.position));
        batch.push(&orientation(&part.path, part.quaternion_wxyz));
    }
    batch.push(&frame(TRAILS));
    for (path, _, rgb) in LINES {
        add_line(path, rgb, batch);
    }
    label::draw(drawing, batch);
}

/// Adds the arrows and the attitude marks, which are updated in flight. A viser recording has neither.
pub(super) fn draw_live(batch: &mut Batch) {
    batch.push(&frame(FORCES));
    for (path, _, rgb, _) in ARROWS {
        let points = batch.array("<f4", f32_bytes([0.0; 6]));
        let colors = batch.array("|u1", rgb.to_vec());
        let props = map! {
            "points" => points,
            "colors" => colors,
            "shaft_radius" => SHAFT_RADIUS_M,
            "head_radius" => HEAD_RADIUS_M,
            "head_length" => HEAD_LENGTH_M,
            "scale" => 1.0,
        };
        batch.push(&node("ArrowMessage", path, props));
    }
    let [wxyzs, positions] = [(); 2].map(|()| batch.array("<f4", Vec::new()));
    let props = map! {
        "batched_wxyzs" => wxyzs,
        "batched_positions" => positions,
        "batched_scales" => Value::Nil,
        "axes_length" => 0.08,
        "axes_radius" => 0.003,
        "scale" => 1.0,
    };
    batch.push(&node("BatchedAxesMessage", MARKS, props));
}

/// Updates the arrows.
pub(super) fn update_arrows(arrows: [Arrow; ARROWS.len()], batch: &mut Batch) {
    for ((path, ..), arrow) in ARROWS.iter().zip(arrows) {
        let points = batch.array("<f4", f32_bytes(arrow.into_iter().flatten()));
        batch.push(&change(path, map! { "points" => points }));
    }
}

/// Replaces all attitude marks by these poses `[x y z w x y z]` in the world, m.
pub(super) fn update_marks<'a>(
    marks: impl Iterator<Item = &'a [f32; 7]> + Clone,
    batch: &mut Batch,
) {
    let turns = marks.clone().flat_map(|[.., w, x, y, z]| [*w, *x, *y, *z]);
    let wxyzs = batch.array("<f4", f32_bytes(turns));
    let positions = batch.array("<f4", f32_bytes(marks.flat_map(|[x, y, z, ..]| [*x, *y, *z])));
    batch.push(&change(MARKS, map! { "batched_wxyzs" => wxyzs, "batched_positions" => positions }));
}

/// Switches the viewer's lamps off. Its environment light suffices, and the lamps in addition would bleach the colours of the URDF.
pub(super) fn light() -> Value {
    map! { "type" => "EnableLightsMessage", "enabled" => false, "cast_shadow" => false }
}

/// Removes all nodes of the drawing one by one, because viser does not remove the children of a removed node.
pub(super) fn erase(drawing: &Drawing, batch: &mut Batch) {
    let labels: Vec<String> = label::paths(drawing).collect();
    let names = labels.iter().chain(drawing.parts.iter().map(|part| &part.path));
    let names = names.chain(drawing.nodes.iter().map(|node| &node.path)).map(String::as_str);
    let lines = LINES.iter().map(|(path, ..)| *path).chain([MARKS, TRAILS]);
    let arrows = ARROWS.iter().map(|(path, ..)| *path).chain([FORCES]);
    for name in names.chain(lines).chain(arrows) {
        batch.push(&map! { "type" => "RemoveSceneNodeMessage", "name" => name, "owner" => "" });
    }
}

/// Replaces the segments of a line. `ends` has two ends `[x y z]` for each segment, in the world, m.
pub(super) fn update_line(path: &str, rgb: [u8; 3], ends: Vec<f32>, batch: &mut Batch) {
    let [points, colors] = line(rgb, ends, batch);
    batch.push(&change(path, map! { "points" => points, "colors" => colors }));
}

/// The message that sets some properties of a node.
fn change(path: &str, updates: Value) -> Value {
    let kind = "SceneNodeUpdateMessage";
    map! { "type" => kind, "name" => path, "updates" => updates, "owner" => "" }
}

/// Shows or hides a node with all below it.
pub(super) fn show(path: &str, visible: bool) -> Value {
    let kind = "SetSceneNodeVisibilityMessage";
    map! { "type" => kind, "name" => path, "visible" => visible, "owner" => "" }
}

/// Buffers of the ends of N segments, shape (N, 2, 3), and of the colour of each end, of the same shape.
fn line(rgb: [u8; 3], ends: Vec<f32>, batch: &mut Batch) -> [Value; 2] {
    let colors = rgb.repeat(ends.len() / 3);
    [batch.array("<f4", f32_bytes(ends)), batch.array("|u1", colors)]
}

/// Adds a line of zero length, which [`update_line`] replaces.
fn add_line(path: &str, rgb: [u8; 3], batch: &mut Batch) {
    let [points, colors] = line(rgb, vec![0.0; 6], batch);
    let props = map! {
        "points" => points,
        "thickness" => LINE_PX,
        "colors" => colors,
        "scale" => 1.0,
        "thickness_units" => "screen",
    };
    batch.push(&node("LineSegmentsMessage", path, props));
}

fn orientation(name: &str, wxyz: [f64; 4]) -> Value {
    map! { "type" => "SetOrientationMessage", "name" => name, "wxyz" => numbers(wxyz), "owner" => "" }
}

fn node(kind: &str, name: &str, props: Value) -> Value {
    map! { "type" => kind, "name" => name, "owner" => "", "virtual" => false, "props" => props }
}

fn frame(path: &str) -> Value {
    let props = map! {
        "show_axes" => false,
        "axes_length" => 0.1,
        "axes_radius" => 0.004,
        "origin_radius" => 0.008,
        "origin_color" => colour([236, 236, 0]),
        "scale" => 1.0,
    };
    node("FrameMessage", path, props)
}

fn grid() -> Value {
    let props = map! {
        "width" => 20.0,
        "height" => 20.0,
        "plane" => "xy",
        "cell_color" => colour([200, 200, 200]),
        "cell_thickness" => 1.0,
        "cell_size" => 0.5,
        "section_color" => colour([140, 140, 140]),
        "section_thickness" => 1.0,
        "section_size" => 1.0,
        "infinite_grid" => false,
        "fade_distance" => 20.0,
        "fade_strength" => 1.0,
        "fade_from" => "camera",
        "shadow_opacity" => 0.0,
        "plane_color" => colour([255, 255, 255]),
        "plane_opacity" => 0.0,
        "scale" => 1.0,
    };
    node("GridMessage", "/grid", props)
}

fn add(part: &Part, batch: &mut Batch) {
    let (kind, mut props) = match &part.shape {
        Shape::Box { size_m } => ("BoxMessage", vec![("dimensions", numbers(*size_m))]),
        Shape::Sphere { radius_m } => (
            "IcosphereMessage",
            vec![("radius", Value::F64(*radius_m)), ("subdivisions", Value::from(3))],
        ),
        Shape::Cylinder { radius_m, length_m } | Shape::Capsule { radius_m, length_m } => (
            "CylinderMessage",
            vec![
                ("radius", Value::F64(*radius_m)),
                ("height", Value::F64(*length_m)),
                ("radial_segments", Value::from(48)),
            ],
        ),
        Shape::Mesh { vertices, triangles } => {
            let corners = f32_bytes(vertices.iter().flatten().map(|&value| value as f32));
            let vertices = batch.array("<f4", corners);
            let faces = batch.array("<u4", u32_bytes(triangles.iter().flatten().copied()));
            ("MeshMessage", vec![("vertices", vertices), ("faces", faces)])
        }
    };
    props.extend(look(part));
    let props = props.into_iter().map(|(key, value)| (Value::from(key), value)).collect();
    batch.push(&node(kind, &part.path, Value::Map(props)));
}

fn look(part: &Part) -> [(&'static str, Value); 9] {
    let alpha = part.rgba[3];
    let opaque = alpha >= 1.0;
    [
        ("color", colour(rgb(part.rgba))),
        ("wireframe", Value::Boolean(false)),
        ("opacity", if opaque { Value::Nil } else { Value::F64(f64::from(alpha)) }),
        ("flat_shading", Value::Boolean(false)),
        ("side", Value::from("double")),
        ("material", Value::from("standard")),
        ("cast_shadow", Value::Boolean(false)),
        ("receive_shadow", Value::Boolean(false)),
        ("scale", Value::F64(1.0)),
    ]
}

fn colour(rgb: [u8; 3]) -> Value {
    Value::Array(rgb.into_iter().map(Value::from).collect())
}
