//! No circular use between files: if a file uses another, directly or through others, the other does not use it.
//!
//! The rule: a file *uses* the file that defines a name which it writes, in a `use` line or in a path in its code.
//! - Re-exports are followed: if the parent says `pub use place::Place`, then `use super::Place` uses `place.rs`, not the parent. A `pub
//!   use` alone is no use; writing that name anywhere else in the file is one.
//! - A module and its submodules belong together: the parent re-exports its submodules, and they use the parent's definitions. A use
//!   between a module and its submodule does not count; a use between two submodules does.
//! - Tests do not count: items under `#[cfg(test)]` are left out.
//!
//! The test reads names only: it does not see `self.step()` where another file contains that `impl`, nor a `use` of `*`.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

use super::reading::{Import, imports, paths, plain, submodules, without_tests, words};

/// Path of a module; the first element is the root file of its crate.
type Name = Vec<String>;

/// One file of source.
#[derive(Default)]
struct Module {
    imports: Vec<Import>,
    children: BTreeSet<String>,
    /// The code without its `use` lines.
    body: String,
}

/// The modules of every crate below a folder.
#[derive(Default)]
struct Modules(BTreeMap<Name, Module>);

/// For each file, the files that it uses and the paths by which it uses them.
type Uses = BTreeMap<Name, BTreeMap<Name, BTreeSet<String>>>;

impl Modules {
    /// Reads a crate from its root file on, following the `mod` lines.
    fn read(&mut self, root: &Path) {
        let root_name = vec![root.to_string_lossy().into_owned()];
        let folder = root.parent().expect("a file lies in a folder");
        let mut left = vec![(root_name, root.to_owned(), folder.to_owned())];
        while let Some((name, file, folder)) = left.pop() {
            let text = std::fs::read_to_string(&file).expect("source is text");
            let children = self.add(name.clone(), &text);
            for child in children {
                let of_folder = folder.join(&child);
                let (flat, inner) = (of_folder.with_extension("rs"), of_folder.join("mod.rs"));
                let file = if flat.is_file() { flat } else { inner };
                left.push(([name.clone(), vec![child]].concat(), file, of_folder));
            }
        }
    }

    fn add(&mut self, name: Name, text: &str) -> BTreeSet<String> {
        let code = without_tests(&plain(text));
        let (imports, body) = imports(&code);
        let children = submodules(&body);
        self.0.insert(name, Module { imports, children: children.clone(), body });
        children
    }

    /// The module whose file defines the name `path`, as written in `from`. `None` if `path` leads out of the crate or names a whole
    /// module.
    fn definer(&self, from: &Name, path: &[String], depth: usize) -> Option<Name> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.within(&from[..1].to_vec(), rest, depth),
            "self" => self.within(from, rest, depth),
            "super" => self.within(&from[..from.len() - 1].to_vec(), rest, depth),
            _ if self.0[from].children.contains(first) || self.import(from, first).is_some() => {
                self.within(from, path, depth)
            }
            _ => None,
        }
    }

    /// The same for a `path` that is relative to `module`.
    fn within(&self, module: &Name, path: &[String], depth: usize) -> Option<Name> {
        let found = self.0.get(module)?;
        let (first, rest) = path.split_first()?;
        if first == "super" {
            return self.within(&module[..module.len() - 1].to_vec(), rest, depth);
        }
        // If a function and a module have the same name, a longer path means the module.
        if found.children.contains(first) && !rest.is_empty() {
            return self.within(&[module.clone(), vec![first.clone()]].concat(), rest, depth);
        }
        match self.import(module, first) {
            // Two modules that re-export each other's names would recurse for ever.
            Some(import) if depth < 8 => {
                self.definer(module, &[&import.path, rest].concat(), depth + 1)
            }
            _ if found.children.contains(first) && !words(&found.body).contains(first) => None,
            _ => Some(module.clone()),
        }
    }

    fn import(&self, module: &Name, name: &str) -> Option<&Import> {
        self.0[module].imports.iter().find(|import| import.name == name)
    }

    /// The uses of all modules.
    fn uses(&self) -> Uses {
        let mut uses = Uses::new();
        for (name, module) in &self.0 {
            let words = words(&module.body);
            let by_import = module
                .imports
                .iter()
                .filter(|import| !import.public || words.contains(&import.name))
                .map(|import| import.path.clone());
            let used = uses.entry(name.clone()).or_default();
            for path in by_import.chain(paths(&module.body)) {
                if let Some(file) =
                    self.definer(name, &path, 0).filter(|file| !one_line(file, name))
                {
                    used.entry(file).or_default().insert(path.join("::"));
                }
            }
        }
        uses
    }
}

/// True if one of the two modules is the other or contains it.
fn one_line(one: &Name, other: &Name) -> bool {
    one.starts_with(other) || other.starts_with(one)
}

/// The shortest path along `uses` from a file back to itself.
fn circle_through(start: &Name, uses: &Uses) -> Option<Vec<Name>> {
    let mut came_from: BTreeMap<&Name, &Name> = BTreeMap::new();
    let mut next = VecDeque::from([start]);
    while let Some(at) = next.pop_front() {
        for used in uses[at].keys() {
            if used == start {
                let mut way = vec![at.clone()];
                while way[way.len() - 1] != *start {
                    way.push(came_from[&way[way.len() - 1]].clone());
                }
                way.reverse();
                return Some(way);
            }
            if !came_from.contains_key(used) {
                came_from.insert(used, at);
                next.push_back(used);
            }
        }
    }
    None
}

/// A shortest circle through each file that is part of one; each circle once, the smallest first.
fn circles(uses: &Uses) -> Vec<Vec<Name>> {
    let mut seen = BTreeSet::new();
    let mut found: Vec<Vec<Name>> = uses
        .keys()
        .filter_map(|start| circle_through(start, uses))
        .filter(|circle| seen.insert(circle.iter().cloned().collect::<BTreeSet<_>>()))
        .collect();
    found.sort_by_key(Vec::len);
    found
}

/// A circle in words: each file, the next file, and the names of it that are used.
fn told(circle: &[Name], uses: &Uses) -> String {
    let mut lines = vec![format!("a circle of {} files:", circle.len())];
    for (at, file) in circle.iter().enumerate() {
        let next = &circle[(at + 1) % circle.len()];
        let names: Vec<&str> = uses[file][next].iter().map(String::as_str).collect();
        lines.push(format!(
            "  {} uses {}: {}",
            file[1..].join("::"),
            next[1..].join("::"),
            names.join(", ")
        ));
    }
    lines.join("\n")
}

/// Root files of the crates below a folder.
fn roots(folder: PathBuf) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![folder]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder of the repository") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.ends_with("lib.rs") || path.ends_with("main.rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    let mut modules = Modules::default();
    for root in roots(Path::new(env!("CARGO_MANIFEST_DIR")).join("twin")) {
        modules.read(&root);
    }
    assert!(modules.0.len() > 100, "only {} files were found", modules.0.len());
    let uses = modules.uses();
    let found: Vec<String> = circles(&uses).iter().map(|circle| told(circle, &uses)).collect();
    assert!(
        found.is_empty(),
        "{}\n{} in all: move what two files share to a file that both use",
        found.join("\n"),
        found.len()
    );
}

/// Circles of a crate with these files, each as the names of its files.
fn circles_of(files: &[(&str, &str)]) -> Vec<String> {
    let mut modules = Modules::default();
    for (name, text) in files {
        let name = ["root"].into_iter().chain(name.split("::").filter(|part| !part.is_empty()));
        modules.add(name.map(str::to_owned).collect(), text);
    }
    let found = circles(&modules.uses());
    let names = |circle: &Vec<Name>| circle.iter().map(|name| name[1..].join("::")).collect();
    found
        .iter()
        .map(|circle| {
            let names: Vec<String> = names(circle);
            names.join(" ")
        })
        .collect()
}

#[test]
fn a_circle_is_found_through_use_lines_paths_and_re_exports() {
    let parent = ("", "pub mod a;\nmod b;\nmod c;\npub use b::Shared;");
    let a = ("a", "use super::Shared;\npub(crate) fn f(_: Shared) {}");
    let back = ("b", "pub struct Shared;\nfn g() { super::c::h(); }");
    let c = ("c", "use crate::{a::{self, f as other}};\npub fn h() { a::f(); other() }");
    assert_eq!(circles_of(&[parent, a, back, c]), ["a b c"]);
    // Without the use in the other direction there is no circle; comments, strings and tests do not make one.
    let quiet = (
        "b",
        "pub struct Shared; // super::c::h()\nconst T: &str = \"super::c::h()\";\n\
         #[cfg(test)]\nmod tests { use super::super::c::h; }",
    );
    assert!(circles_of(&[parent, a, quiet, c]).is_empty());
}

#[test]
fn a_use_between_a_parent_and_what_lies_below_it_does_not_count() {
    let parent = ("", "mod a;\nmod b;\nuse a::Part;\npub struct Shared;\nfn f(_: Part) {}");
    let a = ("a", "use super::Shared;\npub struct Part(Shared);");
    let b = ("b", "use super::a::Part;\npub struct Other(Part);");
    assert!(circles_of(&[parent, a, b]).is_empty());
    let back = ("a", "use super::b::Other;\npub struct Part(Box<Other>);");
    assert_eq!(circles_of(&[parent, back, b]), ["a b"]);
}

#[test]
fn a_name_that_is_only_handed_on_is_not_used() {
    let parent = ("", "mod a;\nmod b;");
    let b = ("b", "use super::a::Own;\npub struct Theirs(Own);");
    let hands_on = ("a", "pub use super::b::Theirs;\npub struct Own;");
    assert!(circles_of(&[parent, hands_on, b]).is_empty());
    let writes = ("a", "pub use super::b::Theirs;\npub struct Own;\nfn f(_: Theirs) {}");
    assert_eq!(circles_of(&[parent, writes, b]), ["a b"]);
}
