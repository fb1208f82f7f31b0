//! The line of an offset in a text, found in the logarithm of its lines.

use crate::work;

/// Offsets at which the lines of a text begin.
#[derive(Clone, Debug)]
pub struct Lines {
    starts: Vec<usize>,
}

impl Lines {
    /// Reads `text` once.
    pub fn of(text: &str) -> Self {
        work::steps(text.len());
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self { starts: std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect() }
    }

    /// Line of the byte at `offset`, from 1.
    pub fn at(&self, offset: usize) -> u32 {
        work::steps(1);
        u32::try_from(self.starts.partition_point(|start| *start <= offset)).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_every_offset_is_one_more_than_the_breaks_before_it() {
        for text in ["", "\n", "a", "a\nbc\n\nd", "ä\r\nö"] {
            let lines = Lines::of(text);
            for offset in 0..=text.len() + 1 {
                let before = text.bytes().take(offset).filter(|byte| *byte == b'\n').count();
                assert_eq!(lines.at(offset) as usize, before + 1, "{text:?} {offset}");
            }
        }
    }
}
