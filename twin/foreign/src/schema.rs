//! Reads ROS 2 message definitions as recordings embed them (`ros2msg`: one text with all types that a message is made of).
//!
//! In: the text. Out: a [`Layout`], which guides the decoder. The published decoders reserve memory by lengths that a damaged
//! message claims, and follow types that contain themselves. This module replaces them for that reason.

use std::collections::BTreeMap;
use std::sync::Arc;

use twin_input::budget::{NAME_BYTES, TYPE_DEPTH};
use twin_input::work;

/// A type that contains no other type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Primitive {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    Text,
    WideText,
}

impl Primitive {
    /// Size of a value in bytes, which is also its alignment; for a text, the size of its length.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 | Self::Text | Self::WideText => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "bool" => Self::Bool,
            "int8" => Self::I8,
            "byte" | "char" | "uint8" => Self::U8,
            "int16" => Self::I16,
            "uint16" => Self::U16,
            "int32" => Self::I32,
            "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float32" => Self::F32,
            "float64" => Self::F64,
            "string" => Self::Text,
            "wstring" => Self::WideText,
            _ => return None,
        })
    }
}

/// The content of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Primitive(Primitive),
    /// Another type, by its index.
    Type(usize),
}

/// The number of elements of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    Sequence,
}

/// A field of a type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: Arc<str>,
    pub(super) kind: Kind,
    pub(super) count: Count,
}

/// The types of time of ROS 1, as definitions of ROS 2.
const ROS1_TIMES: &str =
    "MSG: ros1/time\nuint32 sec\nuint32 nsec\nMSG: ros1/duration\nint32 sec\nint32 nsec\n";

/// All types of a message; the message itself is first. No type contains itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    pub(super) types: Vec<Vec<Field>>,
}

impl Layout {
    /// Reads the definition `text` of the message `name` (`package/msg/Type`).
    ///
    /// # Errors
    /// A sentence that names the line or the type that was not understood.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let mut names = vec![short(name)];
        let mut bodies = vec![Vec::new()];
        for line in text.lines() {
            let line = strip_comment(line).trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                names.push(short(name.trim()));
                bodies.push(Vec::new());
            } else if !line.is_empty() && !line.starts_with("===") {
                bodies.last_mut().ok_or("no type")?.push(line);
            }
        }
        let numbers: BTreeMap<&str, usize> =
            names.iter().enumerate().rev().map(|(number, name)| (name.as_str(), number)).collect();
        let types = names
            .iter()
            .zip(&bodies)
            .map(|(name, lines)| {
                lines.iter().filter_map(|line| field(line, name, &numbers).transpose()).collect()
            })
            .collect::<Result<Vec<Vec<Field>>, String>>()?;
        let layout = Self { types };
        layout.check_depth()?;
        Ok(layout)
    }

    /// Reads a definition of ROS 1 (`ros1msg`) of the message `name`: it has two types of time that ROS 2 does not have.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_ros1(name: &str, text: &str) -> Result<Self, String> {
        let line = |line: &str| {
            let kind = line.split([' ', '[']).next().unwrap_or_default();
            match kind {
                "time" | "duration" => format!("ros1/{line}\n"),
                _ => format!("{line}\n"),
            }
        };
        let text: String = text.lines().map(|text| line(text.trim_start())).collect();
        Self::parse(name, &format!("{text}{ROS1_TIMES}"))
    }

    /// Reads a definition in IDL (`ros2idl`) of the message `name`.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_idl(name: &str, text: &str) -> Result<Self, String> {
        Self::parse(name, &super::idl::as_ros2msg(name, text)?)
    }

    /// Reads the definitions of a ULog file, one a line as `name:type field;type[3] field;…`; the message's own definition is
    /// first.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_ulog(text: &str) -> Result<Self, String> {
        let lines: Vec<(&str, &str)> =
            text.lines().filter_map(|line| line.split_once(':')).collect();
        let named = |name: &str| format!("ulog/{name}");
        let names: Vec<String> = lines.iter().map(|(name, _)| named(name)).collect();
        let numbers: BTreeMap<&str, usize> =
            names.iter().enumerate().rev().map(|(number, name)| (name.as_str(), number)).collect();
        let types = lines
            .iter()
            .map(|(owner, fields)| {
                let fields = fields.split(';').map(str::trim).filter(|field| !field.is_empty());
                fields
                    .filter_map(|text| {
                        let (kind, rest) = text.split_once(' ').unwrap_or((text, ""));
                        let line = format!("{} {rest}", ulog_kind(kind));
                        field(&line, &named(owner), &numbers).transpose()
                    })
                    .collect()
            })
            .collect::<Result<Vec<Vec<Field>>, String>>()?;
        let mut layout = Self { types };
        let own = layout.types.first_mut().ok_or("no definition")?;
        // The logger cuts off the padding at the end of a message.
        let logged = own.iter().rposition(|field| !field.name.starts_with("_padding"));
        own.truncate(logged.map_or(0, |last| last + 1));
        layout.check_depth()?;
        Ok(layout)
    }

    /// Refuses types that the message nests deeper than the budget allows. Each type is looked at once for each depth at most, because
    /// a type that was met at this depth or deeper holds nothing new.
    fn check_depth(&self) -> Result<(), String> {
        let mut deepest: Vec<Option<u64>> = vec![None; self.types.len()];
        let mut ahead = vec![(0, 0)];
        while let Some((number, depth)) = ahead.pop() {
            TYPE_DEPTH.check(depth).map_err(|excess| excess.to_string())?;
            if deepest[number].is_some_and(|known| known >= depth) {
                continue;
            }
            deepest[number] = Some(depth);
            for field in &self.types[number] {
                work::steps(1);
                if let Kind::Type(inner) = field.kind {
                    ahead.push((inner, depth + 1));
                }
            }
        }
        Ok(())
    }
}

/// The ROS 2 name of a ULog type.
fn ulog_kind(kind: &str) -> String {
    let (element, array) = kind.split_at(kind.find('[').unwrap_or(kind.len()));
    let element = match element {
        "float" => "float32",
        "double" => "float64",
        "char" => "uint8",
        other => other.strip_suffix("_t").unwrap_or(other),
    };
    format!("{element}{array}")
}

/// Shortens `package/msg/Type` to `package/Type`.
pub(super) fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// The line up to a `#` outside of quotes.
fn strip_comment(line: &str) -> &str {
    let mut quoted = false;
    for (at, c) in line.char_indices() {
        match c {
            '"' | '\'' => quoted = !quoted,
            '#' if !quoted => return &line[..at],
            _ => {}
        }
    }
    line
}

/// The field that a line defines; `None` if the line defines a constant.
fn field(
    line: &str,
    owner: &str,
    numbers: &BTreeMap<&str, usize>,
) -> Result<Option<Field>, String> {
    // The full name of every type is put together from the name of its owner, so a long name would be copied for each field.
    NAME_BYTES.check_count(owner.len()).map_err(|excess| excess.to_string())?;
    let (kind, rest) = line
        .split_once(char::is_whitespace)
        .ok_or_else(|| format!("line {line:?} of {owner} defines no field"))?;
    let rest = rest.trim_start();
    let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    let after = rest[name.len()..].trim_start();
    if after.starts_with('=') {
        return Ok(None);
    }
    if name.is_empty() {
        return Err(format!("line {line:?} of {owner} names no field"));
    }
    let (element, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((element, size)) => {
            let size = size.trim_end_matches(']');
            let count = if size.is_empty() || size.starts_with("<=") {
                Count::Sequence
            } else {
                Count::Fixed(size.parse().map_err(|_| format!("array size {size:?} in {owner}"))?)
            };
            (element, count)
        }
    };
    // The bound of a text does not change its wire format.
    let element = element.split("<=").next().unwrap_or(element);
    let kind = match Primitive::named(element) {
        Some(primitive) => Kind::Primitive(primitive),
        None => Kind::Type(resolve(element, owner, numbers)?),
    };
    Ok(Some(Field { name: name.into(), kind, count }))
}

/// Index of a type that `owner` names with its package, or without it for a type of its own package.
fn resolve(name: &str, owner: &str, numbers: &BTreeMap<&str, usize>) -> Result<usize, String> {
    let full = match name {
        "Header" => "std_msgs/Header".to_owned(),
        _ if name.contains('/') => short(name),
        _ => format!("{}/{name}", owner.split('/').next().unwrap_or_default()),
    };
    numbers
        .get(full.as_str())
        .copied()
        .ok_or_else(|| format!("type {full} of {owner} is not in the embedded definition"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_comments_defaults_bounds_and_nested_types_are_read() {
        let text = "uint8 A = 1 # constant\nint8 B=-2\n# nothing\nuint64 timestamp # us\nfloat32[4] q\nstring<=5[<=3] names\nInner[] inner\nfloat64 x 1.5\nstring s \"a # b\"\n================\nMSG: pkg/Inner\nuint8 a\n";
        let layout = Layout::parse("pkg/msg/Outer", text).unwrap();
        let fields: Vec<_> =
            layout.types[0].iter().map(|f| (f.name.to_string(), f.kind, f.count)).collect();
        let primitive = Kind::Primitive;
        assert_eq!(
            fields,
            [
                ("timestamp".to_owned(), primitive(Primitive::U64), Count::One),
                ("q".to_owned(), primitive(Primitive::F32), Count::Fixed(4)),
                ("names".to_owned(), primitive(Primitive::Text), Count::Sequence),
                ("inner".to_owned(), Kind::Type(1), Count::Sequence),
                ("x".to_owned(), primitive(Primitive::F64), Count::One),
                ("s".to_owned(), primitive(Primitive::Text), Count::One),
            ]
        );
    }

    /// A message in which each of `levels` types holds `fields` fields of the next type.
    fn nested(levels: usize, fields: usize) -> String {
        let body = |level: usize| {
            let fields = (0..fields).map(|n| format!("T{} f{n}\n", level + 1));
            format!("===\nMSG: p/T{level}\n{}", fields.collect::<String>())
        };
        let types: String = (0..levels).map(body).collect();
        format!("T0 first\n{types}===\nMSG: p/T{levels}\nfloat64 x\n")
    }

    #[test]
    fn types_nest_as_deep_as_the_budget_allows_and_not_one_level_deeper() {
        let deepest = TYPE_DEPTH.most as usize;
        assert!(Layout::parse("p/msg/A", &nested(deepest - 1, 1)).is_ok());
        let said = Layout::parse("p/msg/A", &nested(deepest, 1)).unwrap_err();
        assert!(said.contains("found 17 levels") && said.contains("at most 16"), "{said}");
    }

    #[test]
    fn the_work_of_nested_types_grows_with_their_fields_and_not_with_their_paths() {
        // With ten fields a level there are 10^15 paths.
        let growth = work::growth(10, &mut |fields| {
            assert!(Layout::parse("p/msg/A", &nested(15, fields)).is_ok());
        });
        assert!(growth < work::LINEAR, "four times the fields took {growth:.1} times the steps");
    }

    #[test]
    fn a_name_that_every_field_would_copy_is_limited() {
        let named = |length: usize| Layout::parse(&"n".repeat(length), "float64 x\n");
        assert!(named(NAME_BYTES.count()).is_ok());
        assert!(named(NAME_BYTES.count() + 1).unwrap_err().contains("1025 bytes in one name"));
    }

    #[test]
    fn unknown_types_and_types_that_contain_themselves_are_refused() {
        let absent = Layout::parse("p/msg/A", "Nowhere x\n").unwrap_err();
        assert!(absent.contains("p/Nowhere") && absent.contains("p/A"), "{absent}");
        let circle = Layout::parse("p/msg/A", "B b\n===\nMSG: p/B\nA a\n").unwrap_err();
        assert!(circle.contains("contains itself"), "{circle}");
    }
}
