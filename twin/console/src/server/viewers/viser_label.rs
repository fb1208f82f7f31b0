//! Labels in viser's scene. A label is a child of the node that it names, so it moves with this node and is hidden with it.

use rmpv::Value;

use crate::server::viewers::drawing::{Drawing, GHOST, ROOT};
use crate::server::viewers::pack::map;
use crate::server::viewers::viser_frame::Batch;
use crate::server::viewers::viser_move::position;

/// Distance of a label from the origin of its node, m. In good flight vehicle and reference coincide, so the label of the vehicle
/// stands above and the label of the reference below.
const ABOVE_M: f64 = 0.22;
const PAYLOAD_M: f64 = 0.09;

/// Path, text, height in the frame of its parent in m, and the point of the text that stands at this height.
type Label = (String, &'static str, f64, &'static str);

/// The labels of a drawing.
fn labels(drawing: &Drawing) -> Vec<Label> {
    let mut labels = vec![(format!("{GHOST}/label"), "reference", -ABOVE_M, "top-center")];
    if let Some(root) = &drawing.base {
        labels.push((format!("{root}/label"), "vehicle", ABOVE_M, "bottom-center"));
    }
    let payload = format!("{ROOT}/payload");
    if drawing.moving.contains(&payload) {
        labels.push((format!("{payload}/label"), "payload", -PAYLOAD_M, "top-center"));
    }
    labels
}

/// Paths of all labels.
pub(super) fn paths(drawing: &Drawing) -> impl Iterator<Item = String> {
    labels(drawing).into_iter().map(|(path, ..)| path)
}

/// Adds the messages that draw the labels.
pub(super) fn draw(drawing: &Drawing, batch: &mut Batch) {
    for (path, text, height_m, anchor) in labels(drawing) {
        batch.push(&label(&path, text, anchor));
        batch.push(&position(&path, [0.0, 0.0, height_m]));
    }
}

fn label(path: &str, text: &str, anchor: &str) -> Value {
    map! {
        "type" => "LabelMessage",
        "name" => path,
        "owner" => "",
        "virtual" => false,
        "props" => map! {
            "text" => text,
            "font_size_mode" => "screen",
            "font_screen_scale" => 0.8,
            "font_scene_height" => 0.075,
            // Without the depth test a body in front of the label does not hide it.
            "depth_test" => false,
            "anchor" => anchor,
        },
    }
}
