//! What the reader of a recording found: the form of the container, its damage in words, and the errors that prevent reading.

use std::collections::BTreeSet;

use serde::Serialize;
use twin_input::InputError;

/// Largest number of problems that are stored as text; further problems are only counted.
const MOST_PROBLEMS: usize = 20;

/// Form of the container and its damage.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Findings {
    /// Profile named in the header, such as `ros2`.
    pub profile: String,
    /// Program that wrote the file.
    pub library: String,
    /// Compressions that occur: `none`, `zstd`, `lz4`, or the name of an unknown one.
    pub compressions: BTreeSet<String>,
    /// Number of chunks that were read whole.
    pub chunks: u64,
    /// Number of chunks that were skipped because they are damaged or cannot be unpacked.
    pub chunks_lost: u64,
    /// True if the data section has its end record and a footer follows.
    pub complete: bool,
    /// Number of dropouts: times at which the flight controller could not keep up with logging.
    pub dropouts: u64,
    /// Problems of the file, one sentence each.
    pub problems: Vec<String>,
    /// Number of further problems that are not listed.
    pub more_problems: u64,
}

impl Findings {
    /// Adds a problem; after `MOST_PROBLEMS` problems only the count grows.
    pub fn problem(&mut self, text: String) {
        if self.problems.len() < MOST_PROBLEMS {
            self.problems.push(text);
        } else {
            self.more_problems += 1;
        }
    }
}

/// First bytes of other formats, as they are escaped in an error, and what to do with such a file.
const OTHERS: [(&str, &str); 6] = [
    ("(\\xb5/\\xfd", "it is compressed with zstd as a whole: unpack it with `zstd -d`"),
    ("\\x1f\\x8b", "it is compressed with gzip: unpack it with `gunzip`"),
    ("SQLite", "it is a .db3 file of ROS 2: `ros2 bag convert` writes it as MCAP"),
    ("#ROSBAG", "it is a .bag file of ROS 1: `mcap convert` writes it as MCAP"),
    ("\\xa3\\x95", "it is a .BIN log of ArduPilot, which is not read"),
    ("version ", "it is a pointer of git-lfs, not the file: fetch the file with `git lfs pull`"),
];

/// What to do with a file that starts with `found`.
fn remedy(found: &str) -> &'static str {
    let known = OTHERS.iter().find(|(start, _)| found.starts_with(start));
    known.map_or("check the path", |(_, remedy)| remedy)
}

/// Why a file cannot be read at all.
#[derive(Debug, thiserror::Error)]
pub enum ContainerError {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}; check the path and the permissions")]
    Unreadable(#[from] InputError),
    /// The file is neither MCAP nor ULog.
    #[error("not an MCAP file: it starts with {found:?}, expected {expected:?} (or a ULog, which starts with \"ULog\"); {}", remedy(found), expected = mcap::MAGIC.escape_ascii().to_string())]
    NotMcap {
        /// The first bytes of the file.
        found: String,
    },
}

impl From<std::io::Error> for ContainerError {
    fn from(error: std::io::Error) -> Self {
        Self::Unreadable(error.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_another_format_is_named_with_what_to_do() {
        for (bytes, word) in [
            (&[0x28, 0xb5, 0x2f, 0xfd, 0, 0, 0, 0][..], "zstd -d"),
            (b"SQLite f", "ros2 bag convert"),
            (b"#ROSBAG ", "mcap convert"),
            (b"version ", "git lfs pull"),
            (&[0xa3, 0x95, 0x80, 0x80, 0, 0, 0, 0], "ArduPilot"),
            (b"anything", "check the path"),
        ] {
            let error = ContainerError::NotMcap { found: bytes.escape_ascii().to_string() };
            assert!(error.to_string().contains(word), "{error}");
        }
    }
}
