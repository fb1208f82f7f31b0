//! Words in viser's scene.

use rmpv::Value;

use crate::server::viewers::pack::map;

/// Path of the label of the reference.
pub(super) const LABEL: &str = "/twin/reference/label";

/// Names the pale vehicle; it moves with it and is hidden with it.
pub(super) fn reference() -> Value {
    map! {
        "type" => "LabelMessage",
        "name" => LABEL,
        "owner" => "",
        "virtual" => false,
        "props" => map! {
            "text" => "reference",
            "font_size_mode" => "screen",
            "font_screen_scale" => 0.8,
            "font_scene_height" => 0.075,
            "depth_test" => true,
            "anchor" => "top-left",
        },
    }
}
