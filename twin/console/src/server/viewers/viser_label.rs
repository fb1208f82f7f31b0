//! Words in viser's scene. They hang on what they name, move with it and are hidden with it.

use rmpv::Value;

use crate::server::viewers::drawing::{Drawing, GHOST, ROOT};
use crate::server::viewers::pack::map;
use crate::server::viewers::viser_frame::Batch;
use crate::server::viewers::viser_move::position;

/// How far a word stands off the origin of what it names, m: vehicle and reference coincide in good flight, so one is named
/// above and the other below.
const ABOVE_M: f64 = 0.22;
const PAYLOAD_M: f64 = 0.09;

/// Path, words, height in the frame of its parent in m, and which point of the word stands there.
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

/// Writes the labels.
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
            // A word that something stands before would tell nothing.
            "depth_test" => false,
            "anchor" => anchor,
        },
    }
}
