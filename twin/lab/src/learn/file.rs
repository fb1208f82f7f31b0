//! Writes a file whole or not at all: to a temporary file beside it, flushed to the disk, then renamed over the old file.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::LearnError;

/// Path of the temporary file that is then renamed to `path`.
pub fn beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().map_or_else(Default::default, std::ffi::OsStr::to_os_string);
    name.push(".part");
    path.with_file_name(name)
}

/// Writes `bytes` to `path`, and makes the folders above it.
///
/// # Errors
/// [`LearnError::File`] if the write fails, such as on a full disk; the old file is then intact.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), LearnError> {
    let part = beside(path);
    let written = (|| {
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)?;
        }
        let mut file = File::create(&part)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&part, path)
    })();
    written.map_err(|why| {
        // A partial file is useless. If its removal fails too, the error below is enough.
        let _ = std::fs::remove_file(&part);
        LearnError::write(path, why)
    })
}
