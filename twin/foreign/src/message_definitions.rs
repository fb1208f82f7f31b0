//! Message definitions by their number, within the budget for untrusted input.

use std::collections::BTreeMap;

use mcap::records::SchemaHeader;
use twin_input::Excess;
use twin_input::budget::{ALL_SCHEMA_BYTES, NAME_BYTES, SCHEMA_BYTES, SCHEMAS};

/// Message definitions by number; a later definition of a number replaces the earlier one.
#[derive(Debug, Default)]
pub(super) struct MessageDefinitions {
    by_number: BTreeMap<u16, MessageDefinition>,
    /// Number and bytes of all definitions so far, also of those that were replaced.
    count: u64,
    bytes: u64,
}

/// A message definition.
#[derive(Clone, Debug)]
pub(super) struct MessageDefinition {
    pub(super) header: SchemaHeader,
    /// The text, or why it is not kept.
    pub(super) text: Result<Vec<u8>, Excess>,
}

impl MessageDefinitions {
    /// Stores a definition; returns true unless the same definition was stored already, as chunks repeat them.
    pub(super) fn take(&mut self, mut header: SchemaHeader, text: &[u8]) -> bool {
        if let Some(known) = self.by_number.get(&header.id)
            && known.header == header
            && known.text.as_deref().is_ok_and(|known| known == text)
        {
            return false;
        }
        self.count += 1;
        self.bytes = self.bytes.saturating_add((header.name.len() + text.len()) as u64);
        let within = NAME_BYTES
            .check_count(header.name.len())
            .and_then(|()| SCHEMA_BYTES.check_count(text.len()))
            .and_then(|()| SCHEMAS.check(self.count))
            .and_then(|()| ALL_SCHEMA_BYTES.check(self.bytes));
        if NAME_BYTES.check_count(header.name.len()).is_err() {
            header.name = String::new();
        }
        let text = within.map(|()| text.to_vec());
        self.by_number.insert(header.id, MessageDefinition { header, text });
        true
    }

    /// The definition with this number.
    pub(super) fn get(&self, number: u16) -> Option<&MessageDefinition> {
        self.by_number.get(&number)
    }

    /// All definitions in order of their numbers.
    pub(super) fn all(&self) -> impl Iterator<Item = &MessageDefinition> {
        self.by_number.values()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(id: u16, name: &str) -> SchemaHeader {
        SchemaHeader { id, name: name.to_owned(), encoding: "ros2msg".to_owned() }
    }

    fn refusal(definitions: &MessageDefinitions, number: u16) -> Option<Excess> {
        definitions.get(number).and_then(|definition| definition.text.clone().err())
    }

    #[test]
    fn a_text_as_long_as_the_limit_is_kept_and_one_byte_more_is_not() {
        let mut definitions = MessageDefinitions::default();
        let longest = vec![b'a'; SCHEMA_BYTES.count()];
        definitions.take(header(1, "a"), &longest);
        assert_eq!(refusal(&definitions, 1), None);
        definitions.take(header(2, "a"), &[&longest[..], b"a"].concat());
        assert_eq!(refusal(&definitions, 2).map(|excess| excess.limit), Some(SCHEMA_BYTES));
        let name = "n".repeat(NAME_BYTES.count());
        definitions.take(header(3, &name), b"");
        assert_eq!(refusal(&definitions, 3), None);
        definitions.take(header(4, &format!("{name}n")), b"");
        assert_eq!(refusal(&definitions, 4).map(|excess| excess.limit), Some(NAME_BYTES));
    }

    #[test]
    fn a_definition_that_chunks_repeat_counts_once_and_one_that_changes_counts_again() {
        let mut definitions = MessageDefinitions::default();
        assert!(definitions.take(header(1, "a"), b"x"));
        for _ in 0..SCHEMAS.most {
            assert!(!definitions.take(header(1, "a"), b"x"));
        }
        for round in 1..SCHEMAS.most {
            assert!(definitions.take(header(1, "a"), &round.to_le_bytes()));
        }
        assert_eq!(refusal(&definitions, 1), None);
        definitions.take(header(1, "a"), b"y");
        assert_eq!(refusal(&definitions, 1).map(|excess| excess.limit), Some(SCHEMAS));
    }
}
