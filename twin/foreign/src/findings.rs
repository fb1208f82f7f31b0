//! What was met in a file of any kind: its form, its damage in words, and why it cannot be read at all.

use std::collections::BTreeSet;
use std::io::{ErrorKind, Read};

use serde::Serialize;

/// Most problems that are kept; the rest is counted.
const MOST_PROBLEMS: usize = 20;

/// What the file is like as a container.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Findings {
    /// Profile named in the header, such as `ros2`.
    pub profile: String,
    /// Program that wrote the file.
    pub library: String,
    /// Compressions met: `none`, `zstd`, `lz4` or an unknown word.
    pub compressions: BTreeSet<String>,
    /// Chunks read whole.
    pub chunks: u64,
    /// Chunks left out, because they are damaged or cannot be unpacked.
    pub chunks_lost: u64,
    /// The data section ends as it should and a footer follows.
    pub complete: bool,
    /// Times a flight controller could not keep up with logging.
    pub dropouts: u64,
    /// What is wrong, a sentence each.
    pub problems: Vec<String>,
    /// Problems beyond those listed.
    pub more_problems: u64,
}

impl Findings {
    /// Notes a problem; beyond a number they are only counted.
    pub fn problem(&mut self, text: String) {
        if self.problems.len() < MOST_PROBLEMS {
            self.problems.push(text);
        } else {
            self.more_problems += 1;
        }
    }
}

/// Why nothing can be read.
#[derive(Debug, thiserror::Error)]
pub enum ContainerError {
    /// The system refuses.
    #[error("cannot be read: {0}; check the path and the permissions")]
    Unreadable(#[from] std::io::Error),
    /// It is something else.
    #[error("not an MCAP file: it starts with {found:?}, expected {expected:?} (or a ULog, which starts with \"ULog\"); check the path, or convert it with the `mcap` tool", expected = mcap::MAGIC.escape_ascii().to_string())]
    NotMcap {
        /// Its first bytes.
        found: String,
    },
}

/// Appends `length` bytes if there are so many; false at the end of the file.
pub(super) fn fill(
    input: &mut impl Read,
    length: u64,
    record: &mut Vec<u8>,
) -> std::io::Result<bool> {
    match input.take(length).read_to_end(record) {
        Ok(read) => Ok(read as u64 == length),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}
