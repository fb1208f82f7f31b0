//! A TOML tree that stores the place of each value.

use std::collections::BTreeMap;

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Value};

/// The place where a value was written; lines count from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Origin {
    /// A line of the defaults.
    Default(u32),
    /// A line of the scenario.
    File(u32),
    /// The override with this index.
    Override(usize),
}

/// One value and its place.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) place: Origin,
    pub(super) node: Node,
}

/// A value, or a table or list of values.
#[derive(Clone, Debug)]
pub(super) enum Node {
    Table(BTreeMap<String, Entry>),
    List(Vec<Entry>),
    Whole(i64),
    Number(f64),
    Switch(bool),
    Text(String),
    Date(String),
}

impl Entry {
    /// The tree of `text`. The error is the line and the message of the first syntax error.
    pub(super) fn parse(text: &str, place: fn(u32) -> Origin) -> Result<Self, (u32, String)> {
        let at = |offset: usize| {
            let before = text.as_bytes().iter().take(offset);
            place(1 + before.filter(|byte| **byte == b'\n').count() as u32)
        };
        let line = |offset| match at(offset) {
            Origin::Default(line) | Origin::File(line) => line,
            Origin::Override(_) => 1,
        };
        let table = DeTable::parse(text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            (line(offset), error.message().replace('\n', ", "))
        })?;
        let node = Node::table(table.get_ref(), &at);
        node.map(|node| Entry { place: at(0), node })
            .map_err(|(offset, found)| (line(offset), found))
    }

    /// The value in `text`; text that is not TOML becomes a string.
    pub(super) fn parse_value(text: &str, place: Origin) -> Self {
        let parsed = DeValue::parse(text).ok();
        let node = parsed.and_then(|value| Node::from_toml(value.get_ref(), 0, &|_| place).ok());
        Entry { place, node: node.unwrap_or_else(|| Node::Text(text.to_owned())) }
    }

    /// A tree with `leaf` inside tables named `segments`.
    pub(super) fn nested(segments: &[&str], leaf: Entry, place: Origin) -> Self {
        segments.iter().rev().fold(leaf, |inner, segment| Entry {
            place,
            node: Node::Table(BTreeMap::from([((*segment).to_owned(), inner)])),
        })
    }

    /// Place of the deepest entry on the way to `path`.
    pub(super) fn place_of(&self, path: &[String]) -> Origin {
        let Some((first, rest)) = path.split_first() else { return self.place };
        self.child(first).map_or(self.place, |child| child.place_of(rest))
    }

    /// The tree without places.
    pub(super) fn to_toml(&self) -> Value {
        match &self.node {
            Node::Table(table) => Value::Table(
                table.iter().map(|(key, entry)| (key.clone(), entry.to_toml())).collect(),
            ),
            Node::List(list) => Value::Array(list.iter().map(Entry::to_toml).collect()),
            Node::Whole(value) => Value::Integer(*value),
            Node::Number(value) => Value::Float(*value),
            Node::Switch(value) => Value::Boolean(*value),
            Node::Text(value) | Node::Date(value) => Value::String(value.clone()),
        }
    }

    fn child(&self, segment: &str) -> Option<&Entry> {
        match &self.node {
            Node::Table(table) => table.get(segment),
            Node::List(list) => list.get(segment.parse::<usize>().ok()?),
            _ => None,
        }
    }

    /// The entry of a schema that describes `key`: its own entry, `"*"`, or the first element of a list.
    pub(super) fn pattern(&self, key: &str) -> Option<&Entry> {
        match &self.node {
            Node::Table(table) => table.get(key).or_else(|| table.get("*")),
            Node::List(list) => list.first(),
            _ => None,
        }
    }
}

impl Node {
    fn table(table: &DeTable<'_>, at: &impl Fn(usize) -> Origin) -> Result<Node, (usize, String)> {
        let mut entries = BTreeMap::new();
        for (key, value) in table {
            let node = Node::from_toml(value.get_ref(), value.span().start, at)?;
            // The span of a table is its header; for an inline table the key gives the line.
            let entry = Entry { place: at(key.span().start), node };
            entries.insert(key.get_ref().clone().into_owned(), entry);
        }
        Ok(Node::Table(entries))
    }

    fn list(
        items: &[Spanned<DeValue<'_>>],
        at: &impl Fn(usize) -> Origin,
    ) -> Result<Node, (usize, String)> {
        let entry = |item: &Spanned<DeValue<'_>>| {
            let start = item.span().start;
            Ok(Entry { place: at(start), node: Node::from_toml(item.get_ref(), start, at)? })
        };
        items.iter().map(entry).collect::<Result<_, _>>().map(Node::List)
    }

    fn from_toml(
        value: &DeValue<'_>,
        start: usize,
        at: &impl Fn(usize) -> Origin,
    ) -> Result<Node, (usize, String)> {
        let refused = |found: &str, allowed: &str| (start, format!("{found} is not {allowed}"));
        match value {
            DeValue::Table(table) => Node::table(table, at),
            DeValue::Array(items) => Node::list(items, at),
            DeValue::String(text) => Ok(Node::Text(text.clone().into_owned())),
            DeValue::Boolean(value) => Ok(Node::Switch(*value)),
            DeValue::Datetime(date) => Ok(Node::Date(date.to_string())),
            DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix())
                .map(Node::Whole)
                .map_err(|_| refused(digits.as_str(), "a whole number of 64 bits")),
            DeValue::Float(digits) => digits
                .as_str()
                .parse()
                .map(Node::Number)
                .map_err(|_| refused(digits.as_str(), "a number")),
        }
    }

    /// The found value, in words for a message.
    pub(super) fn words(&self) -> String {
        match self {
            Node::Table(_) => "a table".into(),
            Node::List(_) => "a list".into(),
            Node::Whole(value) => format!("the whole number {value}"),
            Node::Number(value) => format!("the number {value}"),
            Node::Switch(value) => format!("{value}"),
            Node::Text(text) => format!("the text {text:?}"),
            Node::Date(text) => format!("the date {text}"),
        }
    }

    /// The expected kind of value, in words for a message.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Node::Table(_) => "a table",
            Node::List(_) => "a list",
            Node::Whole(_) => "a whole number",
            Node::Number(_) => "a number",
            Node::Switch(_) => "true or false",
            Node::Text(_) => "text in quotes",
            Node::Date(_) => "a date",
        }
    }
}

/// The path as text: `a.b[0].c`.
pub(super) fn dotted(path: &[String]) -> String {
    let mut text = String::new();
    for segment in path {
        if segment.parse::<usize>().is_ok() {
            text.extend(["[", segment, "]"]);
        } else {
            if !text.is_empty() {
                text.push('.');
            }
            text.push_str(segment);
        }
    }
    text
}
