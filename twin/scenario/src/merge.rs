//! The schema of a scenario, the merge of a file over the defaults, and the check of the values.

use std::collections::BTreeMap;

use super::document::{Entry, Node, Origin, dotted};
use twin_core::quantity;

/// An error at one key.
#[derive(Debug)]
pub(super) struct Finding {
    pub(super) place: Origin,
    pub(super) key: String,
    pub(super) found: String,
    pub(super) allowed: String,
    /// Starts with `; ` unless empty.
    pub(super) hint: String,
}

impl Entry {
    /// Merges `over` over these values.
    pub(super) fn merge(&mut self, over: Entry, schema: &Schema) -> Result<(), Finding> {
        merge(self, over, Some(&schema.root), schema, &mut Vec::new())
    }

    /// Fails at the first number that is not finite or out of range.
    pub(super) fn check_values(&self) -> Result<(), Finding> {
        check_values(self, &mut Vec::new())
    }
}

/// Every key of a scenario with a value of its type.
pub(super) struct Schema {
    root: Entry,
    /// Dotted paths of all leaves, for suggestions.
    leaves: Vec<String>,
}

impl Schema {
    /// The schema of `defaults`; removes the table `example` from them.
    pub(super) fn new(defaults: &mut Entry) -> Self {
        let example = match &mut defaults.node {
            Node::Table(table) => table.remove("example"),
            _ => None,
        };
        let mut root = defaults.clone();
        if let Some(example) = example {
            root.complete(example);
        }
        let mut leaves = Vec::new();
        root.collect_leaves(&mut Vec::new(), &mut leaves);
        Schema { root, leaves }
    }

    /// Every key with a value of its type.
    pub(super) fn into_root(self) -> Entry {
        self.root
    }

    fn nearest(&self, path: &[String]) -> String {
        let wanted = dotted(path);
        let name = path.last().map_or("", String::as_str);
        let likeness = |leaf: &str| {
            let last = leaf.rsplit('.').next().unwrap_or(leaf);
            strsim::jaro_winkler(leaf, &wanted).max(strsim::jaro_winkler(last, name))
        };
        let scored = self.leaves.iter().map(|leaf| (likeness(leaf), leaf));
        let best = scored.max_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(score, _)| *score >= LIKE)
            .map_or_else(String::new, |(_, leaf)| format!("; did you mean {leaf}?"))
    }
}

/// Jaro-Winkler similarity from which a key is suggested: `mass_kg` with one letter missing has 0.97.
const LIKE: f64 = 0.8;

impl Entry {
    /// Adds the keys of `example` that are missing here.
    fn complete(&mut self, example: Entry) {
        match (&mut self.node, example.node) {
            (Node::Table(table), Node::Table(more)) => {
                for (key, entry) in more {
                    match table.get_mut(&key) {
                        Some(known) => known.complete(entry),
                        None => drop(table.insert(key, entry)),
                    }
                }
            }
            (Node::List(list), Node::List(more)) if list.is_empty() => *list = more,
            _ => {}
        }
    }

    fn collect_leaves(&self, path: &mut Vec<String>, leaves: &mut Vec<String>) {
        match &self.node {
            Node::Table(table) => {
                for (key, entry) in table {
                    path.push(key.clone());
                    entry.collect_leaves(path, leaves);
                    path.pop();
                }
            }
            _ => leaves.push(dotted(path)),
        }
    }
}

fn merge(
    under: &mut Entry,
    over: Entry,
    pattern: Option<&Entry>,
    schema: &Schema,
    path: &mut Vec<String>,
) -> Result<(), Finding> {
    let place = over.place;
    match (&mut under.node, over.node) {
        (Node::Table(known), Node::Table(given)) => {
            for (key, entry) in given {
                path.push(key.clone());
                let inner = pattern.and_then(|pattern| pattern.pattern(&key));
                if let (Some(pattern), None) = (pattern, inner) {
                    return Err(unknown(path, pattern, entry.place, schema));
                }
                let fresh = fresh(&entry, inner);
                merge(known.entry(key).or_insert(fresh), entry, inner, schema, path)?;
                path.pop();
            }
        }
        (Node::List(known), Node::Table(given)) if matches!(place, Origin::Override(_)) => {
            merge_indexed(known, given, pattern, schema, path)?;
        }
        (Node::List(_), Node::List(given)) => {
            let example = pattern.and_then(|pattern| pattern.pattern(""));
            let mut list = Vec::with_capacity(given.len());
            for (index, entry) in given.into_iter().enumerate() {
                path.push(index.to_string());
                let mut element = fresh(&entry, example);
                merge(&mut element, entry, example, schema, path)?;
                list.push(element);
                path.pop();
            }
            under.node = Node::List(list);
        }
        (known @ Node::Number(_), Node::Whole(value)) => *known = Node::Number(value as f64),
        (known, given) if std::mem::discriminant(known) == std::mem::discriminant(&given) => {
            *known = given;
        }
        (known, given) => {
            return Err(Finding {
                place,
                key: dotted(path),
                found: given.words(),
                allowed: known.kind().into(),
                hint: String::new(),
            });
        }
    }
    under.place = place;
    Ok(())
}

/// An empty entry of the pattern's type, into which a new entry is merged.
fn fresh(entry: &Entry, pattern: Option<&Entry>) -> Entry {
    let mut node = pattern.unwrap_or(entry).node.clone();
    match &mut node {
        Node::Table(table) => table.clear(),
        Node::List(list) => list.clear(),
        _ => {}
    }
    Entry { place: entry.place, node }
}

/// Merges an override such as `list.2.key=value`.
fn merge_indexed(
    known: &mut [Entry],
    given: BTreeMap<String, Entry>,
    pattern: Option<&Entry>,
    schema: &Schema,
    path: &mut Vec<String>,
) -> Result<(), Finding> {
    let example = pattern.and_then(|pattern| pattern.pattern(""));
    for (key, entry) in given {
        let count = known.len();
        let Ok(index) = key.parse::<usize>() else {
            let (key, found) = (dotted(path), format!("the key {key:?}"));
            let allowed = "a list, or an index into it".into();
            return Err(Finding { place: entry.place, key, found, allowed, hint: String::new() });
        };
        path.push(index.to_string());
        let Some(element) = known.get_mut(index) else {
            let allowed = match count {
                0 => "a whole list, because it is empty".into(),
                _ => format!("0..={}", count - 1),
            };
            let (key, found) = (dotted(path), format!("index {index}"));
            return Err(Finding { place: entry.place, key, found, allowed, hint: String::new() });
        };
        merge(element, entry, example, schema, path)?;
        path.pop();
    }
    Ok(())
}

fn unknown(path: &[String], pattern: &Entry, place: Origin, schema: &Schema) -> Finding {
    let siblings: Vec<&str> = match &pattern.node {
        Node::Table(table) => table.keys().map(String::as_str).collect(),
        _ => Vec::new(),
    };
    Finding {
        place,
        key: dotted(path),
        found: "an unknown key".into(),
        allowed: format!("one of {}", siblings.join(", ")),
        hint: schema.nearest(path),
    }
}

fn check_values(entry: &Entry, path: &mut Vec<String>) -> Result<(), Finding> {
    let value = match &entry.node {
        Node::Table(table) => {
            for (key, inner) in table {
                path.push(key.clone());
                check_values(inner, path)?;
                path.pop();
            }
            return Ok(());
        }
        Node::List(list) => {
            for (index, inner) in list.iter().enumerate() {
                path.push(index.to_string());
                check_values(inner, path)?;
                path.pop();
            }
            return Ok(());
        }
        Node::Whole(value) => quantity::whole(i128::from(*value)),
        Node::Number(value) => *value,
        Node::Switch(_) | Node::Text(_) | Node::Date(_) => return Ok(()),
    };
    let bounds = quantity::at(path);
    let (allowed, hint) = match bounds {
        _ if !value.is_finite() => ("a finite number".to_owned(), String::new()),
        Some(bounds) if !bounds.allow(value) => {
            let slip = bounds.quantity.slip(value);
            (bounds.words(), slip.map_or_else(String::new, |slip| format!("; {slip}")))
        }
        _ => return Ok(()),
    };
    Err(Finding { place: entry.place, key: dotted(path), found: value.to_string(), allowed, hint })
}
