//! Folders and files that belong to the program: nobody names them as an output, and each new version replaces the one before.

use std::io::Write;
use std::path::Path;

use super::part::Part;
use super::{OutputError, folder};

/// Makes `folder` and those above it.
///
/// # Errors
/// [`OutputError::Unfit`] with the flag that names the folder.
pub fn make_folder(folder: &Path, flag: &'static str) -> Result<(), OutputError> {
    std::fs::create_dir_all(folder).map_err(|why| OutputError::Unfit {
        path: folder.to_owned(),
        flag,
        found: format!("the folder cannot be made: {why}"),
        remedy: "choose another folder",
    })
}

/// Moves a finished file of the program, such as a downloaded one, to its place in the same file system, over the one before.
///
/// # Errors
/// [`OutputError::Write`] if the file cannot be moved.
pub fn install(from: &Path, to: &Path) -> Result<(), OutputError> {
    std::fs::rename(from, to).map_err(|why| OutputError::write(to, why))
}

/// Writes a file that belongs to the program, such as a checkpoint or a cached report: whole or not at all, over the one before. It
/// makes the folder.
///
/// # Errors
/// [`OutputError::Write`] if the write fails; the file before it is then intact.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let failed = |why| OutputError::write(path, why);
    std::fs::create_dir_all(folder(path)).map_err(failed)?;
    // A link stays a link: the file that it leads to is replaced.
    let real = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut part = Part::beside(&real).map_err(failed)?;
    part.write_all(bytes).map_err(failed)?;
    part.rename(&real, true).map_err(failed)
}
