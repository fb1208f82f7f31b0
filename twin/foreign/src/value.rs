//! A decoded message of any schema, and paths to the values in it.

use std::sync::Arc;

/// A decoded value. Every number is f64, so integers beyond 2^53 are rounded.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Number or boolean.
    Number(f64),
    /// Text.
    Text(String),
    /// Array of numbers.
    Numbers(Vec<f64>),
    /// Array of other values.
    List(Vec<Value>),
    /// Fields by name, in the order of the schema.
    Record(Vec<(Arc<str>, Value)>),
}

/// One step of a [`Path`].
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Field(String),
    Index(usize),
    /// The element of a list whose field equals a text.
    Where(String, String),
}

/// A path to a value in a message: `pose.position.x`, `control[3]`, `transforms[child_frame_id=base].transform`.
#[derive(Clone, Debug, PartialEq)]
pub struct Path(Vec<Step>);

impl Path {
    /// Parses the text form.
    ///
    /// # Errors
    /// A sentence that says what was found, if the text is no path.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("found {text:?}, expected a path such as pose.position.x or control[3]");
        let mut steps = Vec::new();
        for part in text.split('.') {
            let mut pieces = part.split('[');
            let name = pieces.next().unwrap_or_default();
            if !name.is_empty() {
                steps.push(Step::Field(name.to_owned()));
            }
            for piece in pieces {
                let inner = piece.strip_suffix(']').ok_or_else(wrong)?;
                steps.push(match inner.split_once('=') {
                    Some((key, wanted)) => Step::Where(key.to_owned(), wanted.to_owned()),
                    None => Step::Index(inner.parse().map_err(|_| wrong())?),
                });
            }
        }
        if steps.is_empty() { Err(wrong()) } else { Ok(Self(steps)) }
    }
}

impl Value {
    /// The number at `path`.
    pub fn number(&self, path: &Path) -> Option<f64> {
        match path.0.split_last() {
            Some((Step::Index(index), before)) => match self.walk(before)? {
                Self::Numbers(values) => values.get(*index).copied(),
                Self::List(values) => values.get(*index)?.as_number(),
                _ => None,
            },
            _ => self.walk(&path.0)?.as_number(),
        }
    }

    /// The value at `path`. Only [`Value::number`] reaches single numbers of an array of numbers.
    pub fn at(&self, path: &Path) -> Option<&Self> {
        self.walk(&path.0)
    }

    /// All texts of an array of texts, or a single text.
    pub fn texts(&self) -> Vec<&str> {
        match self {
            Self::Text(text) => vec![text.as_str()],
            Self::List(values) => values.iter().flat_map(Self::texts).collect(),
            _ => Vec::new(),
        }
    }

    /// All numbers of an array of numbers, or a single number.
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Number(value) => vec![*value],
            Self::Numbers(values) => values.clone(),
            Self::List(values) => values.iter().filter_map(Self::as_number).collect(),
            _ => Vec::new(),
        }
    }

    fn as_number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            _ => None,
        }
    }

    fn walk(&self, steps: &[Step]) -> Option<&Self> {
        let mut here = self;
        for step in steps {
            here = match (step, here) {
                (Step::Field(name), Self::Record(fields)) => {
                    fields.iter().find(|(known, _)| **known == **name).map(|(_, value)| value)?
                }
                (Step::Index(index), Self::List(values)) => values.get(*index)?,
                (Step::Where(key, wanted), Self::List(values)) => {
                    let key = [Step::Field(key.clone())];
                    values.iter().find(|value| {
                        matches!(value.walk(&key), Some(Self::Text(text)) if text == wanted)
                    })?
                }
                _ => return None,
            };
        }
        Some(here)
    }
}

impl From<serde_json::Value> for Value {
    /// Converts a JSON message; null is not a number.
    fn from(value: serde_json::Value) -> Self {
        match value {
            serde_json::Value::Null => Self::Number(f64::NAN),
            serde_json::Value::Bool(flag) => Self::Number(f64::from(u8::from(flag))),
            serde_json::Value::Number(number) => Self::Number(number.as_f64().unwrap_or(f64::NAN)),
            serde_json::Value::String(text) => Self::Text(text),
            serde_json::Value::Array(values) => {
                Self::List(values.into_iter().map(Self::from).collect())
            }
            serde_json::Value::Object(fields) => Self::Record(
                fields.into_iter().map(|(name, value)| (name.into(), value.into())).collect(),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_reach_fields_elements_and_named_elements() {
        let json = serde_json::json!({
            "pose": { "x": 1.5 }, "control": [1.0, 2.0],
            "transforms": [{ "child": "a", "z": 3.0 }, { "child": "b", "z": 4.0 }]
        });
        let value = Value::from(json);
        let number = |path: &str| value.number(&Path::parse(path).unwrap());
        assert_eq!(number("pose.x"), Some(1.5));
        assert_eq!(number("control[1]"), Some(2.0));
        assert_eq!(number("transforms[child=b].z"), Some(4.0));
        for absent in ["pose.y", "control[2]", "transforms[child=c].z", "pose", "pose.x.y"] {
            assert_eq!(number(absent), None, "{absent}");
        }
    }

    #[test]
    fn what_is_no_path_is_refused_with_an_example() {
        for text in ["", "a[", "a[x]", "a[1", "."] {
            assert!(Path::parse(text).unwrap_err().contains("control[3]"), "{text:?}");
        }
    }
}
