//! The commands of MeshCat that draw nothing. They delete paths, set properties and create the controls of its panel.

use rmpv::Value;

use crate::server::protocol::GainInfo;
use crate::server::viewers::controls::slider_keys;
use crate::server::viewers::pack::{map, numbers};

/// Removes a path with all below it.
pub(super) fn delete(path: &str) -> Value {
    map! { "type" => "delete", "path" => path }
}

/// Sets a property of a path.
pub(super) fn set_property(path: &str, property: &str, value: Value) -> Value {
    map! { "type" => "set_property", "path" => path, "property" => property, "value" => value }
}

/// Sets the point about which the camera turns, in the y-up frame of three.js, m.
pub(super) fn set_target(y_up: [f64; 3]) -> Value {
    map! { "type" => "set_target", "value" => numbers(y_up) }
}

/// A button with which the viewer saves a picture of its scene; it sends nothing.
pub(super) fn picture_button() -> Value {
    let callback = "() => this.handle_command({type: \"save_image\"})";
    push_button("Save picture", callback.to_owned(), None)
}

/// A button that sends its name. Pressing `key` presses the button; the viewer of meshcat-python ignores keys.
pub(super) fn button(name: &str, key: Option<&str>) -> Value {
    let event = serde_json::json!({ "type": "button", "name": name });
    push_button(name, format!("() => this.connection.send(msgpack.encode({event}))"), key)
}

fn push_button(name: &str, callback: String, key: Option<&str>) -> Value {
    let fields = vec![
        (Value::from("type"), Value::from("set_control")),
        ("name".into(), name.into()),
        ("callback".into(), callback.into()),
    ];
    with_keys(fields, key)
}

/// Adds keys to a control, as browsers name keys: one key for a button, or two for a slider (down and up).
fn with_keys<'a>(
    mut fields: Vec<(Value, Value)>,
    keys: impl IntoIterator<Item = &'a str>,
) -> Value {
    let named = ["keycode1", "keycode2"].into_iter().zip(keys);
    fields.extend(named.map(|(field, key)| (field.into(), key.into())));
    Value::Map(fields)
}

/// Opens the chart of the real-time factor on Drake's page; other viewers ignore this command.
pub(super) fn show_realtime_rate() -> Value {
    map! { "type" => "show_realtime_rate", "show" => true }
}

/// Adds a value to that chart: the real-time factor, simulated seconds per second.
pub(super) fn realtime_rate(rate: f64) -> Value {
    map! { "type" => "realtime_rate", "rate" => rate }
}

/// A slider for a gain. It sends its name and its value when the operator moves it or presses one of its two keys.
pub(super) fn slider(gain: &GainInfo) -> Value {
    let name = serde_json::json!(gain.name);
    let event = format!("{{type: \"slider\", name: {name}, value: value}}");
    let callback = format!("(value) => this.connection.send(msgpack.encode({event}))");
    let numbers = [gain.value, gain.min, gain.max, gain.step];
    scale(&gain.name, callback, numbers, slider_keys(&gain.name))
}

fn scale(name: &str, callback: String, numbers: [f64; 4], keys: Option<[&str; 2]>) -> Value {
    let mut fields: Vec<(Value, Value)> = vec![
        ("type".into(), "set_control".into()),
        ("name".into(), name.into()),
        ("callback".into(), callback.into()),
    ];
    let named = ["value", "min", "max", "step"].into_iter().zip(numbers);
    fields.extend(named.map(|(field, number)| (field.into(), number.into())));
    with_keys(fields, keys.into_iter().flatten())
}

/// Moves a slider; the viewer sends no event for this move.
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
    use crate::server::viewers::pack::encode;

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
            ("set_control_slider", scale("kp", slide.to_owned(), [1.0, 0.0, 10.0, 0.1], None)),
            ("set_target", set_target([0.0, 0.5, 0.0])),
            ("set_control_value", set_control_value("kp", 2.5)),
        ] {
            let Some(wanted) = reference(name) else { continue };
            assert_eq!(encode(&command), wanted, "{name}");
        }
    }

    #[test]
    fn what_drake_added_has_the_bytes_that_drake_sends() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../../shared/fixtures/meshcat/drake_1.51.1_capture.json");
        let Ok(text) = std::fs::read_to_string(&path) else {
            return eprintln!("skipped: no {}", path.display());
        };
        let captured: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let callback = "\n() => this.connection.send(msgpack.encode({\n  'type': 'button',\n  'name': 'reset'\n}))";
        let slide = "\n(value) => this.connection.send(msgpack.encode({\n  'type': 'slider',\n  'name': 'kp',\n  'value': value\n}))";
        let arrows = Some(["ArrowLeft", "ArrowRight"]);
        for (call, command) in [
            ("on_connect", show_realtime_rate()),
            ("set_realtime_rate", realtime_rate(0.97)),
            ("add_button", push_button("reset", callback.to_owned(), Some("KeyR"))),
            ("add_slider", scale("kp", slide.to_owned(), [1.0, 0.0, 10.0, 0.1], arrows)),
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
