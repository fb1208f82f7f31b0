//! Matching of topics with patterns, and of definitions with field names.

use twin_input::work;

/// Whether `definition` contains the word `field`.
pub(super) fn names(definition: &[u8], field: &str) -> bool {
    let letter = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    definition.split(|byte| !letter(byte)).any(|word| word == field.as_bytes())
}

/// Whether `text` matches `pattern`, in which `*` stands for any part.
pub(super) fn glob(pattern: &str, text: &str) -> bool {
    work::steps(1);
    let mut parts = pattern.split('*');
    let Some(rest) = parts.next().and_then(|first| text.strip_prefix(first)) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return rest.is_empty() };
    let mut rest = rest;
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}
