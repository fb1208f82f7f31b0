//! The commands of MeshCat that draw nothing: deleting, properties, and the controls of its panel.

use rmpv::Value;

use crate::server::protocol::GainInfo;
use crate::server::viewers::pack::map;

/// Removes a path with all below it.
pub(super) fn delete(path: &str) -> Value {
    map! { "type" => "delete", "path" => path }
}

/// Sets a property of a path.
pub(super) fn set_property(path: &str, property: &str, value: Value) -> Value {
    map! { "type" => "set_property", "path" => path, "property" => property, "value" => value }
}

/// A button that sends its name, also when `key` is pressed; the viewer of the wheel knows no keys.
pub(super) fn button(name: &str, key: Option<&str>) -> Value {
    let event = serde_json::json!({ "type": "button", "name": name });
    push_button(name, format!("() => this.connection.send(msgpack.encode({event}))"), key)
}

fn push_button(name: &str, callback: String, key: Option<&str>) -> Value {
    let mut fields = vec![
        (Value::from("type"), Value::from("set_control")),
        ("name".into(), name.into()),
        ("callback".into(), callback.into()),
    ];
    fields.extend(key.map(|key| ("keycode1".into(), key.into())));
    Value::Map(fields)
}

/// Opens the chart of Drake's page; other viewers ignore it.
pub(super) fn show_realtime_rate() -> Value {
    map! { "type" => "show_realtime_rate", "show" => true }
}

/// A value of that chart: simulated seconds per second.
pub(super) fn realtime_rate(rate: f64) -> Value {
    map! { "type" => "realtime_rate", "rate" => rate }
}

/// A slider that sends its name and its value.
pub(super) fn slider(gain: &GainInfo) -> Value {
    let name = serde_json::json!(gain.name);
    let event = format!("{{type: \"slider\", name: {name}, value: value}}");
    let callback = format!("(value) => this.connection.send(msgpack.encode({event}))");
    scale(&gain.name, callback, [gain.value, gain.min, gain.max, gain.step])
}

fn scale(name: &str, callback: String, [value, min, max, step]: [f64; 4]) -> Value {
    map! {
        "type" => "set_control",
        "name" => name,
        "callback" => callback,
        "value" => value,
        "min" => min,
        "max" => max,
        "step" => step,
    }
}

/// Moves a slider without telling us about it.
pub(super) fn set_control_value(name: &str, value: f64) -> Value {
    map! {
        "type" => "set_control_value",
        "name" => name,
        "value" => value,
        "invoke_callback" => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::viewers::meshcat_object::tests::reference;
    use crate::server::viewers::pack::{encode, numbers};

    #[test]
    fn commands_have_the_bytes_of_meshcat_python() {
        let push =
            "() => viewer.connection.send(JSON.stringify({'type':'control','name':'reset'}))";
        let slide = "(value) => viewer.connection.send(JSON.stringify({'type':'control','name':'kp','value':value}))";
        let camera = "/Cameras/default/rotated/<object>";
        for (name, command) in [
            ("delete", delete("/meshcat/box")),
            ("set_property_visible", set_property("/meshcat/box", "visible", false.into())),
            (
                "set_property_color",
                set_property("/meshcat/box", "color", numbers([1.0, 0.0, 0.5, 0.5])),
            ),
            ("set_property_position", set_property(camera, "position", numbers([2.0, 0.0, 0.0]))),
            (
                "set_property_background",
                set_property("/Background", "top_color", numbers([0.1, 0.1, 0.1])),
            ),
            ("set_control_button", push_button("reset", push.to_owned(), None)),
            ("set_control_slider", scale("kp", slide.to_owned(), [1.0, 0.0, 10.0, 0.1])),
            ("set_control_value", set_control_value("kp", 2.5)),
        ] {
            let Some(wanted) = reference(name) else { continue };
            assert_eq!(encode(&command), wanted, "{name}");
        }
    }

    #[test]
    fn what_drake_added_has_the_bytes_that_drake_sends() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../shared/fixtures/meshcat/drake_1.51.1_capture.json");
        let Ok(text) = std::fs::read_to_string(&path) else {
            return eprintln!("skipped: no {}", path.display());
        };
        let captured: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let callback = "\n() => this.connection.send(msgpack.encode({\n  'type': 'button',\n  'name': 'reset'\n}))";
        for (call, command) in [
            ("on_connect", show_realtime_rate()),
            ("set_realtime_rate", realtime_rate(0.97)),
            ("add_button", push_button("reset", callback.to_owned(), Some("KeyR"))),
        ] {
            let sent = captured.as_array().expect("a list").iter();
            let wanted: Vec<&str> = sent
                .filter(|sent| sent["call"] == call)
                .filter_map(|sent| sent["hex"].as_str())
                .collect();
            let bytes = encode(&command);
            let found = bytes.iter().fold(String::new(), |hex, byte| format!("{hex}{byte:02x}"));
            assert!(wanted.contains(&found.as_str()), "{call}: {found}");
        }
    }
}
