//! One draw: some keys of a scenario and their values. All of it follows from the number of the draw.

use std::sync::LazyLock;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use toml::{Table, Value};

use super::values;

/// Seconds that every draw flies at most.
pub(super) const FLIGHT_S: f64 = 2.0;

/// Lengths of lists of tables (rotors, faults, objects). Most vehicles have four rotors; fewer than three and more than eight are refused.
const LENGTHS: [usize; 12] = [4, 4, 4, 4, 1, 2, 3, 5, 6, 8, 0, 9];

/// Tables that judge or repeat a flight: they do not change it, and most drawn ones are refused.
const JUDGES: [&str; 5] = ["golden", "sweep", "checks", "expect", "bounds"];

/// Share of the draws in which one of these tables is drawn.
const JUDGED: f64 = 0.05;

/// Share of the tables in lists that lack keys; most of them are refused.
const WITH_HOLES: f64 = 0.05;

/// A scenario as the keys that differ from the defaults.
#[derive(Clone, Debug)]
pub(super) struct Draw {
    pub(super) number: u64,
    /// Dotted key and value.
    pub(super) keys: Vec<(String, Value)>,
}

/// Every key of the format with a value of its type: the defaults, completed by their table `example`.
static EVERY_KEY: LazyLock<Table> = LazyLock::new(|| {
    let mut all: Table = twin_scenario::DEFAULTS.parse().expect("the defaults are TOML");
    let example = all.remove("example").expect("the defaults have examples");
    let mut all = Value::Table(all);
    complete(&mut all, example);
    all.as_table().cloned().expect("a table")
});

/// The JSON Schema of the format, which lists the allowed words.
static SCHEMA: LazyLock<serde_json::Value> = LazyLock::new(|| {
    serde_json::from_str(&twin_scenario::json_schema()).expect("the schema is JSON")
});

fn complete(under: &mut Value, more: Value) {
    match (under, more) {
        (Value::Table(under), Value::Table(more)) => {
            for (key, value) in more {
                match under.get_mut(&key) {
                    Some(known) => complete(known, value),
                    None => drop(under.insert(key, value)),
                }
            }
        }
        (Value::Array(under), Value::Array(more)) if under.is_empty() => *under = more,
        _ => {}
    }
}

impl Draw {
    /// The draw of this number.
    pub(super) fn new(number: u64) -> Self {
        let mut rng = Pcg64::seed_from_u64(number);
        // From a few keys, whose effect is not hidden by others, to all.
        let share = [0.01, 0.03, 0.1, 0.4, 1.0][rng.random_range(0..5)];
        let mut keys = Vec::new();
        section(&mut rng, &EVERY_KEY, share, &mut Vec::new(), &mut keys);
        let vehicle = ["aerial_manipulator", "quadrotor"][usize::from(rng.random_bool(0.15))];
        let urdf = format!("{}/urdf/{vehicle}.urdf", env!("CARGO_MANIFEST_DIR"));
        for (key, value) in [
            ("vehicle.urdf", Value::String(urdf)),
            ("time_limit_s", Value::Float(FLIGHT_S)),
            ("title", Value::String(format!("draw {number}"))),
        ] {
            keys.retain(|(known, _)| known != key);
            keys.push((key.to_owned(), value));
        }
        if vehicle == "quadrotor" {
            keys.retain(|(key, _)| !BARE.iter().any(|(bare, _)| bare == key));
            keys.extend(BARE.iter().map(|(key, value)| {
                let value = if value.is_empty() {
                    Value::Array(Vec::new())
                } else {
                    Value::String(String::new())
                };
                ((*key).to_owned(), value)
            }));
        }
        Self { number, keys }
    }

    /// The scenario as TOML.
    pub(super) fn toml(&self) -> String {
        let mut root = Table::new();
        for (key, value) in &self.keys {
            let mut table = &mut root;
            let mut segments: Vec<&str> = key.split('.').collect();
            let last = segments.pop().expect("a key has a segment");
            for segment in segments {
                let inner = table.entry(segment).or_insert_with(|| Value::Table(Table::new()));
                table = inner.as_table_mut().expect("a table by its key");
            }
            table.insert(last.to_owned(), value.clone());
        }
        toml::to_string(&root).expect("a table is TOML")
    }
}

/// Keys that a vehicle without an arm needs: an empty list, or an empty text where a letter stands.
const BARE: [(&str, &str); 3] =
    [("vehicle.arm_joints", ""), ("vehicle.tool_link", "t"), ("vehicle.gripper.joint", "t")];

fn section(
    rng: &mut Pcg64,
    table: &Table,
    share: f64,
    path: &mut Vec<String>,
    keys: &mut Vec<(String, Value)>,
) {
    for (key, value) in table {
        let judges = path.is_empty() && JUDGES.contains(&key.as_str());
        if key == "*" || judges && !rng.random_bool(JUDGED) {
            continue;
        }
        path.push(key.clone());
        match value {
            Value::Table(inner) => section(rng, inner, share, path, keys),
            _ if rng.random_bool(share) => {
                let value = drawn(rng, value, path);
                keys.push((path.join("."), value));
            }
            _ => {}
        }
        path.pop();
    }
}

/// A value of the kind of `default` for the key at `path`.
fn drawn(rng: &mut Pcg64, default: &Value, path: &mut Vec<String>) -> Value {
    match default {
        Value::Float(default) => Value::Float(values::number(rng, path, *default)),
        Value::Integer(default) => {
            Value::Integer(values::number(rng, path, *default as f64).round() as i64)
        }
        Value::Boolean(_) => Value::Boolean(rng.random()),
        Value::String(_) => {
            let key = dotted(path);
            Value::String(values::text(rng, &key, &words(path)))
        }
        Value::Datetime(date) => Value::Datetime(*date),
        Value::Table(table) => {
            let mut drawn_table = Table::new();
            let kept = if rng.random_bool(WITH_HOLES) { 0.7 } else { 1.0 };
            for (key, value) in table {
                // A fault that waits for a condition rarely begins within the flight.
                let kept = if key == "when" { 0.2 } else { kept };
                if rng.random_bool(kept) {
                    path.push(key.clone());
                    drawn_table.insert(key.clone(), drawn(rng, value, path));
                    path.pop();
                }
            }
            Value::Table(drawn_table)
        }
        Value::Array(list) => array(rng, list, path),
    }
}

/// A list: as many numbers as in the default, or any number of tables.
fn array(rng: &mut Pcg64, list: &[Value], path: &mut Vec<String>) -> Value {
    let Some(first) = list.first().filter(|first| !first.is_str()) else {
        return values::names(rng, &dotted(path));
    };
    let count =
        if first.is_table() { LENGTHS[rng.random_range(0..LENGTHS.len())] } else { list.len() };
    let element = |index: usize| {
        path.push(index.to_string());
        let value = drawn(rng, list.get(index).unwrap_or(first), path);
        path.pop();
        value
    };
    Value::Array((0..count).map(element).collect())
}

/// The key without indices of lists.
fn dotted(path: &[String]) -> String {
    let names = path.iter().filter(|segment| segment.parse::<usize>().is_err());
    names.map(String::as_str).collect::<Vec<_>>().join(".")
}

/// The allowed words of the text at `path`; none if any text is allowed.
fn words(path: &[String]) -> Vec<String> {
    let mut schema = &*SCHEMA;
    for segment in path {
        let inner = if segment.parse::<usize>().is_ok() {
            &schema["items"]
        } else {
            &schema["properties"][segment.as_str()]
        };
        schema = inner;
    }
    let words = schema["enum"].as_array().into_iter().flatten();
    words.filter_map(|word| word.as_str().map(str::to_owned)).collect()
}
