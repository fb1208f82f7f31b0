//! The file under the MCAP writer. It counts bytes and keeps the first error, because the writer reports a later one.

use std::fs::File;
use std::io::{Result, Seek, SeekFrom, Write};
use std::sync::Arc;

use crate::progress::Progress;

/// A file that tells how its writing goes.
#[derive(Debug)]
pub(super) struct WatchedFile {
    file: File,
    at: u64,
    progress: Arc<Progress>,
}

impl WatchedFile {
    /// Watches a file that is empty.
    pub(super) fn new(file: File, progress: Arc<Progress>) -> Self {
        Self { file, at: 0, progress }
    }

    fn watch<T>(&self, result: Result<T>) -> Result<T> {
        result.inspect_err(|error| {
            // An interrupted call is repeated by the caller.
            if error.kind() != std::io::ErrorKind::Interrupted {
                self.progress.blame(error);
            }
        })
    }
}

impl Write for WatchedFile {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let written = self.file.write(bytes);
        let written = self.watch(written)?;
        self.at += written as u64;
        self.progress.grow_to(self.at);
        Ok(written)
    }

    fn flush(&mut self) -> Result<()> {
        let flushed = self.file.flush();
        self.watch(flushed)
    }
}

impl Seek for WatchedFile {
    fn seek(&mut self, to: SeekFrom) -> Result<u64> {
        let at = self.file.seek(to);
        self.at = self.watch(at)?;
        Ok(self.at)
    }
}
