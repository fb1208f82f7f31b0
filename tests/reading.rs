//! Reads Rust source as text, for the tests of its structure.

use std::collections::BTreeSet;

/// One name that a `use` line brings.
pub(super) struct Import {
    /// The path as it is written in the `use` line.
    pub path: Vec<String>,
    /// The name in this file.
    pub name: String,
    /// True for a re-export: `pub use` with any visibility.
    pub public: bool,
}

/// The text with comments and the contents of strings and characters left out.
pub(super) fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if c == '"' {
            string(rest)
        } else if rest.starts_with("r\"") || rest.starts_with("r#\"") {
            let close = format!("\"{}", &rest[1..rest.find('"').expect("just seen")]);
            let open = close.len() + 1;
            rest[open..].find(&close).map_or(rest.len(), |end| open + end + close.len())
        } else if c == '\'' {
            character(rest)
        } else {
            0
        };
        if skipped == 0 {
            out.push(c);
            rest = &rest[c.len_utf8()..];
        } else {
            out.push(' ');
            rest = &rest[skipped..];
        }
    }
    out
}

/// Length of the string at the start of a text.
fn string(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// Length of the character literal at the start of a text; 0 for a lifetime.
fn character(text: &str) -> usize {
    let inside = &text[1..];
    match inside.strip_prefix('\\') {
        Some(escaped) => escaped[1..].find('\'').map_or(0, |end| end + 4),
        None => match inside.chars().next() {
            Some(c) if inside[c.len_utf8()..].starts_with('\'') => c.len_utf8() + 2,
            _ => 0,
        },
    }
}

/// [`plain`] code without the items under `#[cfg(test)]`.
pub(super) fn without_tests(code: &str) -> String {
    let mut parts = code.split("#[cfg(test)]");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        kept.push_str(&part[item(part)..]);
    }
    kept
}

/// Length of the item at the start of some code: up to its semicolon or closing brace.
fn item(code: &str) -> usize {
    let mut depth = 0_usize;
    for (at, c) in code.char_indices() {
        match c {
            ';' if depth == 0 => return at + 1,
            '{' | '(' | '[' => depth += 1,
            '}' | ')' | ']' => {
                depth = depth.saturating_sub(1);
                if c == '}' && depth == 0 && !code[at + 1..].starts_with(';') {
                    return at + 1;
                }
            }
            _ => {}
        }
    }
    code.len()
}

/// The names that the `use` lines of [`plain`] code import, and the code without these lines.
pub(super) fn imports(code: &str) -> (Vec<Import>, String) {
    let (mut found, mut body) = (Vec::new(), String::new());
    let mut rest = code;
    while let Some(at) = word(rest, "use") {
        let (before, line) = rest.split_at(at);
        body.push_str(before);
        let end = line.find(';').unwrap_or(line.len());
        let last = before.trim_end().rsplit(['\n', ';', '}']).next().unwrap_or("").trim_start();
        let tree: String = line["use".len()..end].split_whitespace().collect::<Vec<_>>().join(" ");
        branch(&tree, &[], last.starts_with("pub"), &mut found);
        rest = &line[end..];
    }
    body.push_str(rest);
    (found, body)
}

/// Position of a word that is not part of a longer one.
fn word(code: &str, wanted: &str) -> Option<usize> {
    let inside = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(wanted)
        .map(|(at, _)| at)
        .find(|&at| !code[..at].ends_with(inside) && !code[at + wanted.len()..].starts_with(inside))
}

/// The names of one branch of a `use` tree, such as `a::{self, b as c}`.
fn branch(tree: &str, stem: &[String], public: bool, found: &mut Vec<Import>) {
    let tree = tree.trim().trim_start_matches("::");
    if let Some(group) = tree.strip_prefix('{') {
        for part in parts(group.trim_end().trim_end_matches('}')) {
            branch(part, stem, public, found);
        }
    } else if let Some((first, rest)) =
        tree.split_once("::").filter(|(first, _)| !first.contains('{'))
    {
        branch(rest, &[stem, &[first.trim().to_owned()]].concat(), public, found);
    } else if !tree.is_empty() && tree != "*" {
        let (there, here) = tree.split_once(" as ").unwrap_or((tree, tree));
        let mut path = stem.to_vec();
        if there.trim() != "self" {
            path.push(there.trim().to_owned());
        }
        let name =
            if here.trim() == "self" { path[path.len() - 1].clone() } else { here.to_owned() };
        found.push(Import { path, name: name.trim().to_owned(), public });
    }
}

/// The comma-separated parts of a group; nested groups stay whole.
fn parts(group: &str) -> Vec<&str> {
    let mut depth = 0_usize;
    group
        .split(|c| {
            match c {
                '{' => depth += 1,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            c == ',' && depth == 0
        })
        .collect()
}

/// Modules that some code declares in files of their own.
pub(super) fn submodules(body: &str) -> BTreeSet<String> {
    let words: Vec<&str> = body.split_whitespace().collect();
    let declared = words.windows(2).filter(|pair| pair[0] == "mod");
    declared.filter_map(|pair| pair[1].strip_suffix(';')).map(str::to_owned).collect()
}

/// Every path of two words or more in some code, such as `super::playback::PartReader`.
pub(super) fn paths(body: &str) -> BTreeSet<Vec<String>> {
    let text: String = body.split_whitespace().collect::<Vec<_>>().join(" ");
    text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'))
        .filter(|path| path.contains("::"))
        .map(|path| path.split("::").map(|part| part.trim_matches(':').to_owned()))
        .map(|parts| parts.filter(|part| !part.is_empty()).collect())
        .filter(|path: &Vec<String>| path.len() > 1)
        .collect()
}

/// The words of some code, except the names of the modules that it declares.
pub(super) fn words(body: &str) -> BTreeSet<String> {
    let mut before = "";
    let mut found = BTreeSet::new();
    for word in body.split(|c: char| !(c.is_alphanumeric() || c == '_')) {
        if before != "mod" {
            found.insert(word.to_owned());
        }
        before = word;
    }
    found
}
