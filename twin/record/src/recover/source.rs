//! The damaged file as bytes at offsets. Memory holds one window of it.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Bytes of the window.
const WINDOW_BYTES: u64 = 1 << 18;

/// A file that is read at any offset.
pub(super) struct Source {
    file: File,
    length: u64,
    window: Vec<u8>,
    start: u64,
}

impl Source {
    /// Opens a regular file; anything else has no length and may never end.
    pub(super) fn open(path: &Path) -> std::io::Result<Self> {
        // The kind is asked for before the file is opened, because the opening of a pipe waits for its other end.
        if !std::fs::metadata(path)?.is_file() {
            return Err(std::io::Error::other("it is not a regular file"));
        }
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file, length, window: Vec::new(), start: 0 })
    }

    /// Bytes of the file.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Up to `count` bytes from `at` on; fewer at the end of the file.
    pub(super) fn bytes(&mut self, at: u64, count: u64) -> std::io::Result<&[u8]> {
        if at >= self.length {
            return Ok(&[]);
        }
        let end = at.saturating_add(count).min(self.length);
        if at < self.start || end > self.start + self.window.len() as u64 {
            self.window = self.read(at, count.max(WINDOW_BYTES))?;
            self.start = at;
        }
        let from = (at - self.start) as usize;
        let until = from + (end.saturating_sub(at) as usize).min(self.window.len() - from);
        Ok(&self.window[from..until])
    }

    /// Reads up to `count` bytes from `at` on, past the window.
    pub(super) fn read(&mut self, at: u64, count: u64) -> std::io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.file.seek(SeekFrom::Start(at))?;
        (&self.file).take(count.min(self.length.saturating_sub(at))).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}
