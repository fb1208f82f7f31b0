//! The format of a scenario as JSON Schema, for editors. It is derived from the text of the defaults (the schema for reading files), from
//! the ranges in the registry of quantities, and from the allowed words of each key's type.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::document::{Entry, Node, Origin};
use super::merge::Schema;
use super::settings::Settings;
use twin_core::notation::COORDINATE_NAMES;
use twin_core::quantity;

/// The JSON Schema as text.
pub fn json_schema() -> String {
    let Ok(mut defaults) = Entry::parse(super::DEFAULTS, Origin::Default) else {
        return String::new();
    };
    let root = Schema::new(&mut defaults).into_root();
    let writer = Writer { all: root.to_toml(), lines: super::DEFAULTS.lines().collect() };
    let mut schema = writer.of(&root, &mut Vec::new());
    schema["$schema"] = json!("http://json-schema.org/draft-07/schema#");
    schema["title"] = json!("A scenario of twin");
    let text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    format!("{text}\n")
}

struct Writer {
    /// A tree with every key; it is a valid scenario.
    all: toml::Value,
    lines: Vec<&'static str>,
}

impl Writer {
    fn of(&self, entry: &Entry, path: &mut Vec<String>) -> Value {
        let mut schema = match &entry.node {
            Node::Table(table) => self.table(table, path),
            Node::List(list) => {
                let first = list.first().map(|first| {
                    path.push("0".to_owned());
                    let items = self.of(first, path);
                    path.pop();
                    items
                });
                // A list without elements in defaults and example contains texts.
                json!({ "type": "array", "items": first.unwrap_or(json!({ "type": "string" })) })
            }
            Node::Whole(_) => with_range("integer", path),
            Node::Number(_) => with_range("number", path),
            Node::Text(_) => match self.words(path) {
                words if words.is_empty() => json!({ "type": "string" }),
                words => json!({ "enum": words }),
            },
            Node::Switch(_) => json!({ "type": "boolean" }),
            Node::Date(_) => json!({}),
        };
        if let (Some(text), Value::Object(schema)) = (self.comment(entry), &mut schema) {
            schema.insert("description".to_owned(), json!(text));
        }
        schema
    }

    fn table(
        &self,
        table: &std::collections::BTreeMap<String, Entry>,
        path: &mut Vec<String>,
    ) -> Value {
        let mut properties = Map::new();
        for (key, entry) in table {
            path.push(key.clone());
            properties.insert(key.clone(), self.of(entry, path));
            path.pop();
        }
        match properties.remove("*") {
            Some(any) => json!({ "type": "object", "additionalProperties": any }),
            None => {
                json!({ "type": "object", "properties": properties, "additionalProperties": false })
            }
        }
    }

    /// The allowed words of a text, read from the error of its type for another word; empty if any text is allowed.
    fn words(&self, path: &[String]) -> Vec<String> {
        let mut tree = self.all.clone();
        let place = path.iter().try_fold(&mut tree, |value, segment| match value {
            toml::Value::Table(table) => table.get_mut(segment),
            toml::Value::Array(list) => list.get_mut(segment.parse::<usize>().ok()?),
            _ => None,
        });
        let Some(place) = place else { return Vec::new() };
        *place = toml::Value::String("?".to_owned());
        let Err(error) = Settings::deserialize(tree) else { return Vec::new() };
        let said = error.message().to_owned();
        let Some((_, expected)) = said.split_once("unknown variant `?`, expected") else {
            return Vec::new();
        };
        expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    }

    /// The comment after a key in the defaults.
    fn comment(&self, entry: &Entry) -> Option<String> {
        let Origin::Default(line) = entry.place else { return None };
        let (_, comment) = self.lines.get(line.checked_sub(1)? as usize)?.rsplit_once(" # ")?;
        Some(comment.trim().to_owned())
    }
}

fn with_range(kind: &str, path: &[String]) -> Value {
    // The coordinates of a list may have different ranges; the schema contains their union.
    let places: Vec<Vec<String>> = match path.split_last() {
        Some((last, stem)) if last == "0" => {
            (0..COORDINATE_NAMES.len()).map(|index| [stem, &[index.to_string()]].concat()).collect()
        }
        _ => vec![path.to_vec()],
    };
    let bounds: Vec<quantity::Bounds> =
        places.iter().filter_map(|place| quantity::at(place)).collect();
    let min = bounds.iter().map(|bounds| bounds.quantity.min).reduce(f64::min);
    let max = bounds.iter().map(|bounds| bounds.quantity.max).reduce(f64::max);
    match (min, max) {
        (Some(min), Some(max)) if bounds.iter().any(|bounds| bounds.or_none) => {
            let range = json!({ "minimum": min, "maximum": max });
            json!({ "type": kind, "anyOf": [{ "const": 0 }, range] })
        }
        (Some(min), Some(max)) => json!({ "type": kind, "minimum": min, "maximum": max }),
        _ => json!({ "type": kind }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_knows_words_ranges_comments_and_free_names() {
        let schema: Value = serde_json::from_str(&json_schema()).unwrap();
        let at = |pointer: &str| schema.pointer(pointer).cloned().unwrap_or_default();
        assert_eq!(
            at("/properties/task/properties/kind/enum"),
            json!(["pick_place", "hover", "path", "excitation"])
        );
        let mass = at("/properties/payload/properties/mass_kg/anyOf");
        assert_eq!(mass, json!([{ "const": 0 }, { "minimum": 0.001, "maximum": 2.0 }]));
        assert_eq!(
            at("/properties/payload/properties/mass_kg/description"),
            json!("0: no payload")
        );
        let faults = "/properties/faults/items/properties";
        assert_eq!(at(&format!("{faults}/kind/enum")).as_array().unwrap().len(), 9);
        assert_eq!(at(&format!("{faults}/when/properties/phase/type")), json!("string"));
        assert_eq!(at("/properties/bounds/additionalProperties/type"), json!("object"));
        assert_eq!(at("/additionalProperties"), json!(false));
    }

    /// Dotted keys of all numbers below `schema` (index 0 for every list), each with its part of the schema.
    fn numbers(schema: &Value, path: &[String], found: &mut Vec<(Vec<String>, Value)>) {
        let kind = schema["type"].as_str().unwrap_or_default();
        if ["number", "integer"].contains(&kind) {
            found.push((path.to_vec(), schema.clone()));
        }
        let inner = |key: &str| [path, &[key.to_owned()]].concat();
        for (key, schema) in schema["properties"].as_object().into_iter().flatten() {
            numbers(schema, &inner(key), found);
        }
        for (part, key) in [("items", "0"), ("additionalProperties", "any")] {
            if schema[part].is_object() {
                numbers(&schema[part], &inner(key), found);
            }
        }
    }

    /// Keys whose numbers have no range: limits of any metric or signal, and values of any key that a sweep varies.
    const FREE: [&str; 7] = [
        "bounds.any.max",
        "bounds.any.min",
        "checks.0.max",
        "checks.0.min",
        "sweep.ranges.0.from",
        "sweep.ranges.0.to",
        "sweep.ranges.0.values.0",
    ];

    #[test]
    fn every_number_of_the_schema_has_the_range_of_its_quantity() {
        let schema: Value = serde_json::from_str(&json_schema()).unwrap();
        let mut found = Vec::new();
        numbers(&schema, &[], &mut found);
        assert!(found.len() > 100, "{}", found.len());
        for (path, schema) in found {
            let key = path.join(".");
            let Some(bounds) = quantity::at(&path) else {
                assert!(FREE.contains(&key.as_str()), "{key} has no range");
                continue;
            };
            // A list of coordinates has one schema for all of them, so its range must contain the range of each.
            let each = (0..COORDINATE_NAMES.len()).filter_map(|index| {
                let (last, stem) = path.split_last()?;
                (last == "0").then(|| quantity::at(&[stem, &[index.to_string()]].concat()))?
            });
            let quantities: Vec<_> = each.chain([bounds]).map(|bounds| bounds.quantity).collect();
            let min = quantities.iter().map(|quantity| quantity.min).reduce(f64::min);
            let max = quantities.iter().map(|quantity| quantity.max).reduce(f64::max);
            let range = if bounds.or_none { &schema["anyOf"][1] } else { &schema };
            assert_eq!([range["minimum"].as_f64(), range["maximum"].as_f64()], [min, max], "{key}");
        }
    }

    #[test]
    fn the_published_schema_is_the_one_of_this_program() {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/schema.json");
        if std::env::var_os("TWIN_UPDATE").is_some() {
            std::fs::write(&path, json_schema()).unwrap();
        }
        let published = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            published == json_schema(),
            "scenarios/schema.json is old: TWIN_UPDATE=1 cargo test --release --lib json_schema"
        );
    }
}
