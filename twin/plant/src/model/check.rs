//! Checks on the raw XML, before the loader takes any value from it. Every finding names its line.
//!
//! XML that passes has one `<robot>`, links and joints with unique names, finite numbers of the right count and sign, and known
//! joint kinds, axes and limits. The loader checks the tree and the inertias on the loaded values.

use std::collections::HashMap;
use std::path::Path;

use roxmltree::{Document, Node};

use super::ModelError;
use super::numbers::{NUMBERS, Number};
use twin_input::budget::{ATTRIBUTES, JOINTS, LINKS};
use twin_input::{Excess, Limit, Lines};

/// Deepest nesting of elements. URDF needs six, and the recursive readers of XML can take far more.
const MAX_DEPTH: usize = 32;

/// Joint kinds that the twin simulates.
const KINDS: [&str; 4] = ["fixed", "revolute", "continuous", "prismatic"];

/// A URDF as XML; it finds the line of an element for an error.
pub(super) struct Source<'a> {
    file: &'a Path,
    document: Document<'a>,
    lines: Lines,
}

impl<'a> Source<'a> {
    /// The XML of `text`, checked.
    pub(super) fn parse(text: &'a str, file: &'a Path) -> Result<Self, ModelError> {
        let lines = Lines::of(text);
        check_attributes(text).map_err(|(at, excess)| ModelError::Refused {
            file: file.to_path_buf(),
            line: lines.at(at),
            found: format!("{} {}", excess.found, excess.limit.of),
            allowed: format!("at most {}", excess.limit.most),
            remedy: excess.limit.remedy.into(),
        })?;
        let document = Document::parse(text).map_err(|error| ModelError::Refused {
            file: file.to_path_buf(),
            line: error.pos().row,
            found: format!("not well-formed XML: {error}"),
            allowed: "one complete <robot> element".into(),
            remedy: "close every element and quote every attribute".into(),
        })?;
        let source = Source { file, document, lines };
        source.check_root()?;
        source.check_count(&LINKS, &source.links())?;
        source.check_count(&JOINTS, &source.joints())?;
        source.check_names("link", &source.links())?;
        source.check_names("joint", &source.joints())?;
        source.links().into_iter().try_for_each(|link| source.check_link(link))?;
        source.joints().into_iter().try_for_each(|joint| source.check_joint(joint))?;
        for node in source.document.root_element().descendants() {
            source.check_numbers(node)?;
        }
        Ok(source)
    }

    /// The file's `<link>` elements, in order.
    pub(super) fn links(&self) -> Vec<Node<'_, 'a>> {
        children(self.document.root_element(), "link").collect()
    }

    /// The file's `<joint>` elements, in order.
    pub(super) fn joints(&self) -> Vec<Node<'_, 'a>> {
        children(self.document.root_element(), "joint").collect()
    }

    /// The `<robot>` element.
    pub(super) fn root(&self) -> Node<'_, 'a> {
        self.document.root_element()
    }

    /// Line of an element, from 1.
    pub(super) fn line(&self, node: Node<'_, '_>) -> u32 {
        self.lines.at(node.range().start)
    }

    /// The error that refuses `node`; `found`, `allowed` and `remedy` are parts of its message.
    pub(super) fn refuse(
        &self,
        node: Node<'_, '_>,
        found: impl Into<String>,
        allowed: impl Into<String>,
        remedy: impl Into<String>,
    ) -> ModelError {
        ModelError::Refused {
            file: self.file.to_path_buf(),
            line: self.line(node),
            found: found.into(),
            allowed: allowed.into(),
            remedy: remedy.into(),
        }
    }

    fn check_root(&self) -> Result<(), ModelError> {
        let root = self.root();
        if name_of(root) != "robot" {
            let found = format!("the document element is <{}>", name_of(root));
            return Err(self.refuse(root, found, "<robot>", "name a URDF file, not SDF or MJCF"));
        }
        for node in root.descendants().filter(Node::is_element) {
            if node.tag_name().namespace().is_some_and(|namespace| namespace.contains("xacro")) {
                let found = format!("xacro macro <{}>", name_of(node));
                return Err(self.refuse(
                    node,
                    found,
                    "plain URDF",
                    "expand it first: xacro in > out",
                ));
            }
            if node.ancestors().take(MAX_DEPTH + 2).count() > MAX_DEPTH + 1 {
                let allowed = format!("at most {MAX_DEPTH} levels");
                return Err(self.refuse(
                    node,
                    "elements nested too deeply",
                    allowed,
                    "flatten the file",
                ));
            }
        }
        if self.links().is_empty() {
            let remedy = "describe at least one rigid body";
            return Err(self.refuse(root, "a robot without links", "one or more <link>", remedy));
        }
        Ok(())
    }

    fn check_count(&self, limit: &Limit, nodes: &[Node<'_, '_>]) -> Result<(), ModelError> {
        limit.check_count(nodes.len()).map_err(|excess| {
            let (found, allowed) = (excess.found, excess.limit.most);
            let first = nodes.get(limit.count()).copied().unwrap_or(self.root());
            let found = format!("{found} {}", limit.of);
            self.refuse(first, found, format!("at most {allowed}"), limit.remedy)
        })
    }

    fn check_names(&self, what: &str, nodes: &[Node<'_, '_>]) -> Result<(), ModelError> {
        let mut seen = HashMap::new();
        for &node in nodes {
            let name = self.attribute(node, "name")?;
            if let Some(first) = seen.insert(name, self.line(node)) {
                let found = format!("{what} {name:?} is already defined on line {first}");
                return Err(self.refuse(node, found, "one of each name", "rename one of them"));
            }
        }
        Ok(())
    }

    fn check_link(&self, link: Node<'_, '_>) -> Result<(), ModelError> {
        for inertial in children(link, "inertial") {
            self.child(inertial, "mass")?;
            self.child(inertial, "inertia")?;
        }
        for what in ["visual", "collision"] {
            for node in children(link, what) {
                self.check_geometry(self.child(node, "geometry")?)?;
            }
        }
        Ok(())
    }

    fn check_geometry(&self, geometry: Node<'_, '_>) -> Result<(), ModelError> {
        let mut shapes = geometry.children().filter(Node::is_element);
        let allowed = "exactly one of <box>, <cylinder>, <sphere>, <capsule>, <mesh>";
        let remedy = "use one <visual> or <collision> for each shape";
        match (shapes.next(), shapes.next()) {
            (Some(shape), None) => match name_of(shape) {
                "box" | "cylinder" | "sphere" | "capsule" => Ok(()),
                "mesh" => self.attribute(shape, "filename").map(|_| ()),
                other => {
                    let found = format!("unknown shape <{other}>");
                    Err(self.refuse(shape, found, allowed, "approximate it with these"))
                }
            },
            (None, _) => Err(self.refuse(geometry, "a <geometry> without shape", allowed, remedy)),
            (Some(_), Some(second)) => {
                Err(self.refuse(second, "a second shape in one <geometry>", allowed, remedy))
            }
        }
    }

    fn check_joint(&self, joint: Node<'_, '_>) -> Result<(), ModelError> {
        let (name, kind) = (self.attribute(joint, "name")?, self.attribute(joint, "type")?);
        self.attribute(self.child(joint, "parent")?, "link")?;
        self.attribute(self.child(joint, "child")?, "link")?;
        for mimic in children(joint, "mimic") {
            self.attribute(mimic, "joint")?;
        }
        if !KINDS.contains(&kind) {
            let found = format!("joint {name:?} is of type {kind:?}");
            let remedy = "a free base needs no joint: make its link the root";
            return Err(self.refuse(joint, found, KINDS.join(", "), remedy));
        }
        let limit = children(joint, "limit").next();
        if limit.is_none() && matches!(kind, "revolute" | "prismatic") {
            let found = format!("{kind} joint {name:?} has no <limit>");
            let allowed = "<limit lower upper effort velocity>";
            let remedy = "add the limits, or make an endless revolute joint continuous";
            return Err(self.refuse(joint, found, allowed, remedy));
        }
        Ok(())
    }

    fn check_numbers(&self, node: Node<'_, '_>) -> Result<(), ModelError> {
        let inside =
            node.ancestors().any(|above| matches!(name_of(above), "link" | "joint" | "material"));
        if !inside {
            return Ok(());
        }
        for rule in NUMBERS.iter().filter(|rule| rule.element == name_of(node)) {
            match node.attribute(rule.attribute) {
                Some(text) => self.check_number(node, rule, text)?,
                None if rule.required => {
                    self.attribute(node, rule.attribute)?;
                }
                None => {}
            }
        }
        Ok(())
    }

    fn check_number(
        &self,
        node: Node<'_, '_>,
        rule: &Number,
        text: &str,
    ) -> Result<(), ModelError> {
        if rule.accepts(text) {
            return Ok(());
        }
        let found = format!("<{} {}={text:?}>", rule.element, rule.attribute);
        let remedy = "URDF is in m, kg, rad, N; correct the value";
        Err(self.refuse(node, found, rule.allowed(), remedy))
    }

    /// The attribute, or the error that it is missing.
    fn attribute<'n>(&self, node: Node<'n, '_>, name: &str) -> Result<&'n str, ModelError> {
        node.attribute(name).filter(|value| !value.trim().is_empty()).ok_or_else(|| {
            let found = format!("<{}> without {name}", name_of(node));
            self.refuse(node, found, format!("a {name} that is not empty"), "add the attribute")
        })
    }

    /// The one child element called `name`, or the error that it is missing or repeated.
    fn child<'n, 'i>(&self, node: Node<'n, 'i>, name: &str) -> Result<Node<'n, 'i>, ModelError> {
        let mut found = children(node, name);
        match (found.next(), found.next()) {
            (Some(child), None) => Ok(child),
            (None, _) => {
                let found = format!("<{}> without <{name}>", name_of(node));
                Err(self.refuse(node, found, format!("one <{name}>"), "add the element"))
            }
            (Some(_), Some(second)) => {
                let found = format!("a second <{name}> in <{}>", name_of(node));
                Err(self.refuse(second, found, format!("one <{name}>"), "remove one of them"))
            }
        }
    }
}

/// Refuses an element with more attributes than the budget allows, by the number of its equals signs; returns its offset.
fn check_attributes(text: &str) -> Result<(), (usize, Excess)> {
    let (mut begin, mut count, mut quote) = (0, 0, None);
    for (at, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (Some(open), _) => quote = Some(open).filter(|open| *open != byte),
            (None, b'<' | b'>') => (begin, count) = (at, 0),
            // Outside of a tag a quote is a part of the text.
            (None, b'"' | b'\'') if count > 0 => quote = Some(byte),
            (None, b'=') => {
                count += 1;
                ATTRIBUTES.check(count).map_err(|excess| (begin, excess))?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// Child elements of `node` called `name`.
pub(super) fn children<'n, 'i>(
    node: Node<'n, 'i>,
    name: &str,
) -> impl Iterator<Item = Node<'n, 'i>> {
    node.children().filter(move |child| child.is_element() && name_of(*child) == name)
}

fn name_of<'n>(node: Node<'n, '_>) -> &'n str {
    node.tag_name().name()
}
