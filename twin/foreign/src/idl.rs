//! Translates OMG IDL, as ROS 2 embeds it (`ros2idl`), into the `ros2msg` text of the same message; both have the same wire
//! format.
//!
//! The reader knows modules, structures, typedefs, sequences, arrays and bounded strings. It skips annotations and constants.

use std::collections::BTreeMap;

use twin_input::budget::TYPE_DEPTH;

/// Largest number of words in a definition.
const MOST_WORDS: usize = 1 << 16;

/// The `ros2msg` text of the message `name` (`package/msg/Type`) and all its types, from the IDL in `text`.
///
/// # Errors
/// A sentence that says what was not understood.
pub(super) fn as_ros2msg(name: &str, text: &str) -> Result<String, String> {
    let mut reader = Reader { words: words(text)?.into_iter().peekable(), ..Reader::default() };
    while reader.words.peek().is_some() {
        reader.definition()?;
    }
    let own = name.replace("/msg/", "/");
    let body =
        reader.bodies.remove(&own).ok_or_else(|| format!("no struct {own} in its schema"))?;
    let others = reader.bodies.iter().map(|(name, body)| format!("===\nMSG: {name}\n{body}"));
    Ok(body + &others.collect::<String>())
}

/// Splits `text` into names, numbers, quoted strings and single marks; `::` belongs to a name. Skips comments, annotations, `#`
/// lines and the lines that rosbag puts between the parts.
fn words(text: &str) -> Result<Vec<String>, String> {
    let kept: String = text
        .lines()
        .map(str::trim)
        .filter(|line| {
            !(line.starts_with('#') || line.starts_with("===") || line.starts_with("IDL:"))
        })
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n");
    let mut words = Vec::new();
    let mut rest = kept.as_str();
    while let Some(first) = rest.chars().next() {
        let word = |c: char| c.is_alphanumeric() || "_:.+-".contains(c);
        let length = if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if first == '@' {
            annotation(rest)
        } else if first == '"' {
            rest[1..].find('"').map_or(rest.len(), |end| end + 2)
        } else if word(first) {
            rest.find(|c| !word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        let (taken, after) = rest.split_at(length);
        if !(first.is_whitespace() || first == '@' || taken.starts_with("/*")) {
            words.push(taken.to_owned());
        }
        if words.len() > MOST_WORDS {
            return Err(format!("a definition of more than {MOST_WORDS} words"));
        }
        rest = after;
    }
    Ok(words)
}

/// Length of an annotation with its bracketed arguments, bytes; brackets inside quoted strings do not count.
fn annotation(text: &str) -> usize {
    let name = text[1..].find(|c: char| !(c.is_alphanumeric() || c == '_'));
    let end = name.map_or(text.len(), |end| end + 1);
    let after = text[end..].trim_start();
    if !after.starts_with('(') {
        return end;
    }
    let (mut depth, mut quoted) = (0_usize, false);
    for (at, c) in after.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return text.len() - after.len() + at + 1;
        }
    }
    text.len()
}

struct Reader {
    words: std::iter::Peekable<std::vec::IntoIter<String>>,
    modules: Vec<String>,
    /// Fields of every structure as `ros2msg` lines, by `package/Type`.
    bodies: BTreeMap<String, String>,
    /// Element and array part of every typedef, by its name.
    aliases: BTreeMap<String, (String, String)>,
}

impl Default for Reader {
    fn default() -> Self {
        Self {
            words: Vec::new().into_iter().peekable(),
            modules: Vec::new(),
            bodies: BTreeMap::new(),
            aliases: BTreeMap::new(),
        }
    }
}

impl Reader {
    fn next(&mut self) -> Result<String, String> {
        self.words.next().ok_or_else(|| "the definition ends too early".to_owned())
    }

    fn expect(&mut self, wanted: &str) -> Result<(), String> {
        let found = self.next()?;
        if found == wanted { Ok(()) } else { Err(format!("found {found:?}, expected {wanted:?}")) }
    }

    fn definition(&mut self) -> Result<(), String> {
        match self.next()?.as_str() {
            "module" => {
                let name = self.next()?;
                self.modules.push(name);
                self.expect("{")
            }
            "struct" => self.structure(),
            "typedef" => {
                let (element, array) = self.kind()?;
                let name = self.next()?;
                let size = self.size()?;
                self.expect(";")?;
                let array = if array.is_empty() { size } else { array };
                self.aliases.insert(name, (element, array));
                Ok(())
            }
            "const" => {
                while self.next()? != ";" {}
                Ok(())
            }
            "}" => {
                self.modules.pop();
                Ok(())
            }
            ";" => Ok(()),
            other => Err(format!("{other:?} is not read in a definition")),
        }
    }

    fn structure(&mut self) -> Result<(), String> {
        let name = self.next()?;
        self.expect("{")?;
        let mut body = String::new();
        while self.words.peek().is_some_and(|word| word != "}") {
            let (element, array) = self.kind()?;
            let field = self.next()?;
            let size = self.size()?;
            self.expect(";")?;
            if !(array.is_empty() || size.is_empty()) {
                return Err(format!("{field}: arrays of arrays are not read"));
            }
            body.extend([element.as_str(), &array, &size, " ", &field, "\n"]);
        }
        self.expect("}")?;
        let package = self.modules.first().map(String::as_str).unwrap_or_default();
        self.bodies.insert(format!("{package}/{name}"), body);
        Ok(())
    }

    /// Reads `[N]` after a name, if it is there.
    fn size(&mut self) -> Result<String, String> {
        if self.words.next_if(|word| word == "[").is_none() {
            return Ok(String::new());
        }
        let size = self.next()?;
        self.expect("]")?;
        Ok(format!("[{size}]"))
    }

    /// Reads a type; returns the `ros2msg` name of its element, and its array part.
    fn kind(&mut self) -> Result<(String, String), String> {
        self.kind_at(0)
    }

    fn kind_at(&mut self, depth: u64) -> Result<(String, String), String> {
        TYPE_DEPTH.check(depth).map_err(|excess| excess.to_string())?;
        let mut name = self.next()?;
        if name == "sequence" {
            self.expect("<")?;
            let (element, array) = self.kind_at(depth + 1)?;
            if self.words.next_if(|word| word == ",").is_some() {
                self.next()?;
            }
            self.expect(">")?;
            let flat = array.is_empty().then(|| (element, "[]".to_owned()));
            return flat.ok_or_else(|| "sequences of arrays are not read".to_owned());
        }
        if name == "unsigned" {
            name = format!("unsigned {}", self.next()?);
        }
        if name.ends_with("long") && self.words.next_if(|word| word == "long").is_some() {
            name += " long";
        }
        if name.ends_with("string") && self.words.next_if(|word| word == "<").is_some() {
            self.next()?;
            self.expect(">")?;
        }
        if let Some(alias) = self.aliases.get(name.rsplit("::").next().unwrap_or(&name)) {
            return Ok(alias.clone());
        }
        let own = match name.as_str() {
            "double" => "float64",
            "float" => "float32",
            "short" => "int16",
            "unsigned short" => "uint16",
            "long" => "int32",
            "unsigned long" => "uint32",
            "long long" => "int64",
            "unsigned long long" => "uint64",
            "octet" => "uint8",
            "boolean" => "bool",
            other => &other.replace("::msg::", "/").replace("::", "/"),
        };
        Ok((own.to_owned(), String::new()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::Layout;

    const IDL: &str = "================\nIDL: nav/msg/Pose\n// generated\n#include \"std/msg/Header.idl\"\nmodule nav {\n  module msg {\n    typedef double double__36[36];\n    module Pose_Constants { const unsigned long LEFT = 1; };\n    @verbatim (language=\"comment\", text=\"a (pose;\" \"b\")\n    struct Pose {\n      std::msg::Header header;\n      @unit (value=\"m\")\n      double x;\n      double__36 covariance;\n      sequence<float> many;\n      sequence<octet, 4> few;\n      string<8> name;\n      unsigned long long count;\n      boolean flag; /* a; b */\n      short pair[2];\n    };\n  };\n};\n================\nIDL: std/msg/Header\nmodule std { module msg { struct Header { long sec; unsigned long nanosec; string frame_id; }; }; };\n";

    const MSG: &str = "std/Header header\nfloat64 x\nfloat64[36] covariance\nfloat32[] many\nuint8[<=4] few\nstring name\nuint64 count\nbool flag\nint16[2] pair\n===\nMSG: std/Header\nint32 sec\nuint32 nanosec\nstring frame_id\n";

    #[test]
    fn a_message_in_idl_has_the_layout_of_the_same_message_in_msg() {
        let text = as_ros2msg("nav/msg/Pose", IDL).unwrap();
        let found = Layout::parse("nav/msg/Pose", &text).unwrap();
        assert_eq!(found, Layout::parse("nav/msg/Pose", MSG).unwrap());
    }

    #[test]
    fn sequences_nested_20000_deep_are_refused_on_a_small_stack() {
        let read = || {
            let (open, close) = ("sequence<".repeat(20_000), ">".repeat(20_000));
            let text = format!("module a {{ struct B {{ {open}double{close} x; }}; }};");
            as_ros2msg("a/msg/B", &text).unwrap_err()
        };
        let thread = std::thread::Builder::new().stack_size(256 << 10).spawn(read).unwrap();
        let said = thread.join().unwrap();
        assert!(said.contains("17 levels"), "{said}");
    }

    #[test]
    fn a_definition_cut_anywhere_is_an_error_or_ends() {
        for end in (0..IDL.len()).filter(|end| IDL.is_char_boundary(*end)) {
            let _ = as_ros2msg("nav/msg/Pose", &IDL[..end]);
        }
        assert!(as_ros2msg("nav/msg/Other", IDL).unwrap_err().contains("no struct nav/Other"));
        assert!(as_ros2msg("a/msg/B", "module a { union U {}; };").unwrap_err().contains("union"));
    }
}
