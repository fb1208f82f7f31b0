//! Our readers of message definitions, CDR and ULog against published readers, on made input and on real flights.
//!
//! The published readers are oracles for whole input only. On damaged input `px4-ulog` panics at times, and `re_ros_msg` reserves
//! memory by the lengths that a message claims.

mod ros;
mod ulog;

use std::collections::BTreeMap;

use twin_foreign::value::Value;

/// A number by its bits, so that NaN equals NaN; or a text; or the number of elements of an array.
#[derive(Debug, PartialEq)]
enum Leaf {
    Number(u64),
    Text(String),
    Count(usize),
}

/// Everything in a message, by its path.
type Leaves = BTreeMap<String, Leaf>;

fn number(value: impl Into<f64>) -> Leaf {
    Leaf::Number(value.into().to_bits())
}

fn leaves_of_ours(value: &Value, path: &str, out: &mut Leaves) {
    match value {
        Value::Number(value) => drop(out.insert(path.to_owned(), number(*value))),
        Value::Text(text) => drop(out.insert(path.to_owned(), Leaf::Text(text.clone()))),
        Value::Numbers(values) => {
            out.insert(format!("{path}[]"), Leaf::Count(values.len()));
            let all = values.iter().enumerate();
            out.extend(all.map(|(i, value)| (format!("{path}[{i}]"), number(*value))));
        }
        Value::List(values) => {
            out.insert(format!("{path}[]"), Leaf::Count(values.len()));
            for (i, value) in values.iter().enumerate() {
                leaves_of_ours(value, &format!("{path}[{i}]"), out);
            }
        }
        Value::Record(fields) => {
            for (name, value) in fields {
                leaves_of_ours(value, &format!("{path}.{name}"), out);
            }
        }
    }
}
