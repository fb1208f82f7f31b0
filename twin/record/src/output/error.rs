//! Why an output cannot be opened or written.

use std::path::{Path, PathBuf};

/// Errors of opening and writing an output. Each names the file, the cause and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The command reads the file that it would write.
    #[error("{path}: {flag} would overwrite {input}, which this command reads; choose another file", path = .path.display(), input = .input.display())]
    Input {
        /// The output as it was named.
        path: PathBuf,
        /// The flag that names it.
        flag: &'static str,
        /// The input as it was named.
        input: PathBuf,
    },
    /// The file exists, and nobody asked to replace it.
    #[error("{path}: {flag} would overwrite this file; choose another name, or replace it with --overwrite", path = .path.display())]
    Exists {
        /// The file.
        path: PathBuf,
        /// The flag that names it.
        flag: &'static str,
    },
    /// Two outputs of one run have one place.
    #[error("{path}: both {first} and {second} would write it; choose two places", path = .path.display())]
    Twice {
        /// The file, or `-` for stdout.
        path: PathBuf,
        /// The flag that took it.
        first: &'static str,
        /// The flag that asked for it again.
        second: &'static str,
    },
    /// No output can go there.
    #[error("{path}: {flag} cannot be written here: {found}; {remedy}", path = .path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// The flag that names it.
        flag: &'static str,
        /// The reason.
        found: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The file cannot be written to its end.
    #[error("{path}: cannot be written: {why}; free some space or choose another place", path = .path.display())]
    Write {
        /// The file, or `stdout`.
        path: PathBuf,
        /// The message of the operating system.
        why: std::io::Error,
    },
}

impl OutputError {
    /// The error of a write that failed.
    pub(crate) fn write(path: &Path, why: std::io::Error) -> Self {
        match why.downcast::<Self>() {
            // A writer of this module has named the file already.
            Ok(named) => named,
            Err(why) => Self::Write { path: path.to_owned(), why },
        }
    }

    /// The error of a folder that takes no file.
    pub(super) fn folder(path: &Path, flag: &'static str, why: &std::io::Error) -> Self {
        let remedy = match why.kind() {
            std::io::ErrorKind::NotFound => "make the folder first, or choose another",
            _ => "choose a folder that takes new files",
        };
        let folder = super::folder(path);
        let found = format!("the folder {} takes no file: {why}", folder.display());
        Self::Unfit { path: path.to_owned(), flag, found, remedy }
    }

    /// Whether the output was opened and then failed, such as on a full disk; every other error refuses the request.
    pub fn is_failed_write(&self) -> bool {
        matches!(self, Self::Write { .. })
    }
}

impl From<OutputError> for std::io::Error {
    fn from(error: OutputError) -> Self {
        let kind = match &error {
            OutputError::Write { why, .. } => why.kind(),
            _ => std::io::ErrorKind::Other,
        };
        Self::new(kind, error)
    }
}
