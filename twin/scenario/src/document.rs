//! A TOML tree that stores the place of each value.

use std::cell::Cell;
use std::collections::BTreeMap;

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Value};
use twin_input::budget::{LIST_ITEMS, TOML_VALUES};
use twin_input::{Excess, Lines};

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
    /// The tree of `text`. The error is the line and the message of the first syntax error, or of the first excess of the budget.
    pub(super) fn parse(text: &str, place: fn(u32) -> Origin) -> Result<Self, (u32, String)> {
        let lines = Lines::of(text);
        let wrong = |found: &str| {
            format!("not TOML: {found}; correct the syntax, https://toml.io shows it")
        };
        let table = DeTable::parse(text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            (lines.at(offset), wrong(&error.message().replace('\n', ", ")))
        })?;
        let tree = Tree { at: &|offset| place(lines.at(offset)), values: Cell::new(0) };
        let node = tree.table(table.get_ref());
        node.map(|node| Entry { place: place(1), node }).map_err(|unread| match unread {
            Unread::Value(offset, found) => (lines.at(offset), wrong(&found)),
            Unread::Excess(offset, excess) => (lines.at(offset), excess.to_string()),
        })
    }

    /// The value in `text`; text that is not TOML becomes a string.
    pub(super) fn parse_value(text: &str, place: Origin) -> Self {
        let parsed = DeValue::parse(text).ok();
        let tree = Tree { at: &|_| place, values: Cell::new(0) };
        let node = parsed.and_then(|value| tree.node(value.get_ref(), 0).ok());
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

/// Reads the tree of a document.
struct Tree<'a> {
    /// The place of an offset in the text.
    at: &'a dyn Fn(usize) -> Origin,
    /// Number of values so far.
    values: Cell<u64>,
}

/// Why a value is not read, with its offset in the text.
enum Unread {
    /// The value is not of its type.
    Value(usize, String),
    /// There are more values than the budget allows.
    Excess(usize, Excess),
}

impl Tree<'_> {
    fn table(&self, table: &DeTable<'_>) -> Result<Node, Unread> {
        let mut entries = BTreeMap::new();
        for (key, value) in table {
            let node = self.node(value.get_ref(), value.span().start)?;
            // The span of a table is its header; for an inline table the key gives the line.
            let entry = Entry { place: (self.at)(key.span().start), node };
            entries.insert(key.get_ref().clone().into_owned(), entry);
        }
        Ok(Node::Table(entries))
    }

    fn list(&self, items: &[Spanned<DeValue<'_>>], start: usize) -> Result<Node, Unread> {
        let last = items.get(LIST_ITEMS.count()).map_or(start, |item| item.span().start);
        LIST_ITEMS.check_count(items.len()).map_err(|excess| Unread::Excess(last, excess))?;
        let entry = |item: &Spanned<DeValue<'_>>| {
            let start = item.span().start;
            Ok(Entry { place: (self.at)(start), node: self.node(item.get_ref(), start)? })
        };
        items.iter().map(entry).collect::<Result<_, _>>().map(Node::List)
    }

    fn node(&self, value: &DeValue<'_>, start: usize) -> Result<Node, Unread> {
        self.values.set(self.values.get() + 1);
        TOML_VALUES.check(self.values.get()).map_err(|excess| Unread::Excess(start, excess))?;
        let refused =
            |found: &str, allowed: &str| Unread::Value(start, format!("{found} is not {allowed}"));
        match value {
            DeValue::Table(table) => self.table(table),
            DeValue::Array(items) => self.list(items, start),
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
}

impl Node {
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
