//! The file of a recording. It is written under its own name, so that it can be read while it grows.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::OutputError;
#[cfg(unix)]
use super::place::{identity, identity_of};

/// Most files of one name in one folder.
pub(super) const MOST_NUMBERS: u32 = 100_000;

/// The flag that names a recording, unless a command has another.
const FLAG: &str = "--record";

/// A new file for a recording. Nobody else writes it: its name did not exist before, and it is locked until it is closed.
#[derive(Debug)]
pub struct RecordingFile {
    path: PathBuf,
    wanted: PathBuf,
    file: File,
}

impl RecordingFile {
    /// Creates the file at `path`.
    ///
    /// # Errors
    /// [`OutputError`] if the file exists, or the folder takes no file.
    pub fn new(path: &Path) -> Result<Self, OutputError> {
        create(path).map_err(|why| match why.kind() {
            ErrorKind::AlreadyExists => OutputError::Exists { path: path.to_owned(), flag: FLAG },
            _ => OutputError::folder(path, FLAG, &why),
        })
    }

    /// Creates the file at `path`, or if it exists at the next free number: `flight.mcap`, `flight-2.mcap`, …
    ///
    /// # Errors
    /// [`OutputError`] if the folder takes no file.
    pub(super) fn numbered(path: &Path, flag: &'static str) -> Result<Self, OutputError> {
        for number in 1..MOST_NUMBERS {
            match create(&with_number(path, number)) {
                Ok(file) => return Ok(Self { wanted: path.to_owned(), ..file }),
                Err(why) if why.kind() == ErrorKind::AlreadyExists => {}
                Err(why) => return Err(OutputError::folder(path, flag, &why)),
            }
        }
        Err(OutputError::Exists { path: path.to_owned(), flag })
    }

    /// Removes the recording at `real` and creates a new one there; `path` is its name in errors.
    ///
    /// # Errors
    /// [`OutputError`] if another process still writes it, or the folder takes no file.
    pub(super) fn instead_of(
        real: &Path,
        path: &Path,
        flag: &'static str,
    ) -> Result<Self, OutputError> {
        let unfit = |found: String, remedy| OutputError::Unfit {
            path: path.to_owned(),
            flag,
            found,
            remedy,
        };
        let in_use = || {
            let found = "another process is recording to it".to_owned();
            unfit(found, "choose another file, or end that flight first")
        };
        let missing = |why: std::io::Error| unfit(why.to_string(), "choose another file");
        // The lock holds until the new file is there, so that of two processes only one replaces the old file.
        let before = File::open(real).map_err(missing)?;
        if matches!(before.try_lock(), Err(TryLockError::WouldBlock)) {
            return Err(in_use());
        }
        if !is_at(&before, real) {
            return Err(in_use());
        }
        std::fs::remove_file(real).map_err(missing)?;
        Ok(Self { path: path.to_owned(), wanted: path.to_owned(), ..Self::new(real)? })
    }

    /// Opens the device at `path`, such as `/dev/null`.
    pub(super) fn stream(path: &Path) -> Result<Self, OutputError> {
        let file = OpenOptions::new()
            .write(true)
            .open(path)
            .map_err(|why| OutputError::write(path, why))?;
        Ok(Self { path: path.to_owned(), wanted: path.to_owned(), file })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A sentence for the user if the file has another name than the user wanted.
    pub fn renamed(&self) -> Option<String> {
        (self.path != self.wanted).then(|| {
            format!(
                "{} exists, so the flight is recorded to {}; --overwrite replaces it",
                self.wanted.display(),
                self.path.display()
            )
        })
    }

    /// Removes the file, which nothing was written to.
    pub(super) fn discard(self) {
        if let Err(error) = std::fs::remove_file(&self.path) {
            tracing::warn!("{}: the empty file stays behind: {error}", self.path.display());
        }
    }

    /// The open file and its path.
    pub(crate) fn into_parts(self) -> (PathBuf, File) {
        (self.path, self.file)
    }
}

/// Whether `file` is still the file at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    file.metadata().is_ok_and(|found| Some(identity_of(&found)) == identity(path))
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

fn create(path: &Path) -> std::io::Result<RecordingFile> {
    let file = File::create_new(path)?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(ErrorKind::AlreadyExists.into()),
        // Some file systems have no locks; the exclusive creation holds without them.
        _ => Ok(RecordingFile { path: path.to_owned(), wanted: path.to_owned(), file }),
    }
}

/// `flight.mcap` for number 1, then `flight-2.mcap`, …
pub(super) fn with_number(path: &Path, number: u32) -> PathBuf {
    if number < 2 {
        return path.to_owned();
    }
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("-{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}
