//! Where an output goes, and what is there already.

use std::fs::Metadata;
use std::path::{Path, PathBuf};

use super::{OutputError, folder};

/// Names of stdout. The last three would otherwise lead through links to the file that stdout was redirected to.
const STDOUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// Identity of a file, which is the same through every link to it.
#[cfg(unix)]
pub(super) type FileId = (u64, u64);
#[cfg(not(unix))]
pub(super) type FileId = PathBuf;

/// The identity of the file at `path`, or `None` if none is there.
#[cfg(unix)]
pub(super) fn identity(path: &Path) -> Option<FileId> {
    std::fs::metadata(path).ok().map(|metadata| identity_of(&metadata))
}

/// Device and inode.
#[cfg(unix)]
pub(super) fn identity_of(metadata: &Metadata) -> FileId {
    use std::os::unix::fs::MetadataExt;
    (metadata.dev(), metadata.ino())
}

#[cfg(not(unix))]
pub(super) fn identity(path: &Path) -> Option<FileId> {
    std::fs::canonicalize(path).ok()
}

/// The identity of the file that stdout is redirected to, as in `>> flight.mcap`.
#[cfg(unix)]
pub(super) fn stdout_identity() -> Option<FileId> {
    use std::os::fd::AsFd;
    let stdout = std::io::stdout().as_fd().try_clone_to_owned().ok()?;
    std::fs::File::from(stdout).metadata().ok().map(|metadata| identity_of(&metadata))
}

#[cfg(not(unix))]
pub(super) fn stdout_identity() -> Option<FileId> {
    None
}

/// The place of an output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Stdout.
    Stdout,
    /// A pipe or a character device such as `/dev/null`: it is written directly, because it has no content to lose.
    Stream(PathBuf),
    /// A regular file, whose links are resolved, and whether it exists.
    File {
        /// Path without links.
        real: PathBuf,
        /// Whether the file exists.
        exists: bool,
    },
}

/// Whether `path` names stdout.
pub(super) fn is_stdout(path: &Path) -> bool {
    STDOUT.iter().any(|name| path == Path::new(name))
}

impl Place {
    /// Whether both are stdout or both are one file. A device can have many outputs.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Stdout, Self::Stdout) => true,
            (Self::File { real: a, .. }, Self::File { real: b, .. }) => a == b,
            _ => false,
        }
    }

    /// The place that `path` names.
    pub(super) fn find(path: &Path, flag: &'static str) -> Result<Self, OutputError> {
        if is_stdout(path) {
            return Ok(Self::Stdout);
        }
        let unfit = |found: &str, remedy| OutputError::Unfit {
            path: path.to_owned(),
            flag,
            found: found.to_owned(),
            remedy,
        };
        let Some(name) = path.file_name() else {
            return Err(unfit("it is a folder", "name a file in it"));
        };
        match std::fs::metadata(path) {
            Ok(found) if found.is_dir() => Err(unfit("it is a folder", "name a file in it")),
            Ok(found) if found.is_file() => {
                let real = std::fs::canonicalize(path)
                    .map_err(|why| OutputError::folder(path, flag, &why))?;
                Ok(Self::File { real, exists: true })
            }
            Ok(found) if is_stream(&found) => Ok(Self::Stream(path.to_owned())),
            Ok(_) => Err(unfit("it is neither a file nor a pipe", "name a file")),
            Err(_) => {
                let folder = std::fs::canonicalize(folder(path))
                    .map_err(|why| OutputError::folder(path, flag, &why))?;
                // A link that leads nowhere is somebody's, too.
                let exists = path.symlink_metadata().is_ok();
                Ok(Self::File { real: folder.join(name), exists })
            }
        }
    }
}

/// Whether a write goes to a reader or to nobody. A block device is a disk, and a socket cannot be opened.
#[cfg(unix)]
fn is_stream(metadata: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let kind = metadata.file_type();
    kind.is_fifo() || kind.is_char_device()
}

/// Whether `path` is a pipe, in which nothing can be written a second time.
#[cfg(unix)]
pub(super) fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    std::fs::metadata(path).is_ok_and(|found| found.file_type().is_fifo())
}

#[cfg(not(unix))]
pub(super) fn is_pipe(_: &Path) -> bool {
    false
}

#[cfg(not(unix))]
fn is_stream(_: &Metadata) -> bool {
    false
}
