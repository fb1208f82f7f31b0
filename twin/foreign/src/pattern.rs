//! Matching of topics with patterns, and of definitions with field names.

use twin_input::work;

/// Whether `definition` contains the word `field` outside of comments.
pub(super) fn names(definition: &[u8], field: &str) -> bool {
    let letter = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let mut code = definition
        .split(|byte| *byte == b'\n')
        .filter_map(|line| line.split(|byte| *byte == b'#').next());
    code.any(|line| line.split(|byte| !letter(byte)).any(|word| word == field.as_bytes()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_a_whole_word_and_a_comment_names_no_field() {
        let text = b"float32[3] position # defined by local_frame\nfloat32 rollspeed\n";
        assert!(names(text, "position") && names(text, "rollspeed"));
        assert!(!names(text, "local_frame") && !names(text, "roll"));
        assert!(names(b"odometry:uint64_t timestamp;float rollspeed;", "rollspeed"));
    }
}
