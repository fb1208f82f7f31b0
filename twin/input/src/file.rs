//! Opens regular files only, and reads them up to a limit.
//!
//! A named pipe would block, a device would never end, and a directory has no bytes. The kind is asked before the file is opened,
//! because the open of a pipe waits for its writer and the open of a device may act on it. It is asked again on the open file, because
//! the path may lead elsewhere by then.

use std::fs::{File, FileType};
use std::io::Read;
use std::path::Path;

use crate::{Excess, Limit, stop};

/// Why a file is not read. The text does not name the file; the caller's error does.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The system refuses to open or to read the file.
    #[error("{0}")]
    System(std::io::Error),
    /// The path does not name a regular file.
    #[error("found {found}, only regular files are read; {remedy}")]
    NotRegular {
        /// The kind of file, with its article.
        found: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// The file is longer than the budget allows.
    #[error(transparent)]
    TooMuch(#[from] Excess),
    /// The file is not text.
    #[error("byte {at} is not UTF-8; save the file as UTF-8 text")]
    NotText {
        /// Offset of the first such byte.
        at: usize,
    },
    /// A request to stop ended the read.
    #[error(transparent)]
    Stopped(#[from] stop::Stopped),
}

impl From<std::io::Error> for InputError {
    fn from(error: std::io::Error) -> Self {
        if stop::is_stop(&error) { Self::Stopped(stop::Stopped) } else { Self::System(error) }
    }
}

impl InputError {
    /// Whether there is no file at the path.
    pub fn is_absent(&self) -> bool {
        matches!(self, Self::System(error) if error.kind() == std::io::ErrorKind::NotFound)
    }
}

/// Opens the regular file `path` for reading.
///
/// # Errors
/// [`InputError`] if the system refuses, or the path names anything but a regular file.
pub fn open(path: &Path) -> Result<File, InputError> {
    regular(std::fs::metadata(path)?.file_type())?;
    let file = File::open(path)?;
    regular(file.metadata()?.file_type())?;
    Ok(file)
}

/// Refuses a `path` that names anything but a regular file; a missing file is allowed, because it may appear later.
///
/// # Errors
/// [`InputError::NotRegular`].
pub fn check_kind(path: &Path) -> Result<(), InputError> {
    std::fs::metadata(path).map_or(Ok(()), |found| regular(found.file_type()))
}

/// The bytes of the regular file `path`, at most as many as `most` allows.
///
/// # Errors
/// [`InputError`] if the file cannot be opened or read, or is longer.
pub fn read(path: &Path, most: Limit) -> Result<Vec<u8>, InputError> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    most.check(length)?;
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // The file may grow while it is read, and files of the system claim to be empty.
    file.take(most.most.saturating_add(1)).read_to_end(&mut bytes)?;
    most.check_count(bytes.len())?;
    Ok(bytes)
}

/// The text of the regular file `path`, at most as many bytes as `most` allows.
///
/// # Errors
/// [`InputError`] if the file cannot be opened or read, is longer, or is not UTF-8.
pub fn read_text(path: &Path, most: Limit) -> Result<String, InputError> {
    String::from_utf8(read(path, most)?)
        .map_err(|error| InputError::NotText { at: error.utf8_error().valid_up_to() })
}

fn regular(kind: FileType) -> Result<(), InputError> {
    if kind.is_file() {
        return Ok(());
    }
    let (found, remedy) = described(kind);
    Err(InputError::NotRegular { found, remedy })
}

/// The kind of a file that is not regular, and what to do.
fn described(kind: FileType) -> (&'static str, &'static str) {
    let into_a_file = "write its bytes into a file and name that file";
    if kind.is_dir() {
        return ("a directory", "name a file in it");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return ("a named pipe", into_a_file);
        }
        if kind.is_socket() {
            return ("a socket", into_a_file);
        }
        if kind.is_char_device() || kind.is_block_device() {
            return ("a device", into_a_file);
        }
    }
    ("a special file", into_a_file)
}

#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
