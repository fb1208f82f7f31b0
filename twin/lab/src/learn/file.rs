//! Files that are whole or not there: written beside their place, flushed to the disk, then renamed over what was there.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::LearnError;

/// Where `path` is written before it is renamed.
pub fn beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().map_or_else(Default::default, std::ffi::OsStr::to_os_string);
    name.push(".part");
    path.with_file_name(name)
}

/// Writes `bytes` to `path`; folders above it are made.
///
/// # Errors
/// [`LearnError::File`] if that fails, such as on a full disk; then `path` is what it was.
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
        // Half a file helps nobody; if even this fails, the error below says enough.
        let _ = std::fs::remove_file(&part);
        LearnError::write(path, why)
    })
}
