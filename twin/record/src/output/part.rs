//! A file that gets its name only when it is whole: a temporary file in the folder of its target.

use std::fs::File;
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::folder;

/// Numbers the temporary files of this process.
static NEXT: AtomicU64 = AtomicU64::new(1);

/// The beginning of a file. Dropped before [`Part::rename`], it is removed.
#[derive(Debug)]
pub(super) struct Part {
    path: PathBuf,
    /// `None` once it is closed.
    file: Option<BufWriter<File>>,
    named: bool,
}

impl Part {
    /// Creates a temporary file beside `target`.
    pub(super) fn beside(target: &Path) -> std::io::Result<Self> {
        loop {
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let name = format!(".twin-{}-{number}.part", std::process::id());
            let path = folder(target).join(name);
            match File::create_new(&path) {
                Ok(file) => {
                    return Ok(Self { path, file: Some(BufWriter::new(file)), named: false });
                }
                // Left by a process that had this number before and was killed.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Brings the content to the disk and names the file `target`. An existing file is replaced, and its permissions stay, if
    /// `replace` is true; otherwise its existence is an error.
    pub(super) fn rename(mut self, target: &Path, replace: bool) -> std::io::Result<()> {
        if let Some(mut file) = self.file.take() {
            file.flush()?;
            file.get_ref().sync_all()?;
        }
        if replace {
            if let Ok(before) = std::fs::metadata(target) {
                std::fs::set_permissions(&self.path, before.permissions())?;
            }
            std::fs::rename(&self.path, target)?;
            self.named = true;
            return Ok(());
        }
        // A link to an existing name is refused, whoever made that name since; a rename would replace it.
        match std::fs::hard_link(&self.path, target) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(error),
            // The drop removes the temporary name.
            Ok(()) => Ok(()),
            // A file system without hard links: whoever creates the name has it.
            Err(_) => {
                File::create_new(target)?;
                std::fs::rename(&self.path, target)?;
                self.named = true;
                Ok(())
            }
        }
    }

    fn writer(&mut self) -> std::io::Result<&mut BufWriter<File>> {
        self.file.as_mut().ok_or_else(|| std::io::Error::other("the file is closed"))
    }
}

impl Write for Part {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.writer()?.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer()?.flush()
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        if self.named {
            return;
        }
        // Without this, dropping the writer would write what it still holds.
        if let Some(file) = self.file.take() {
            let _ = file.into_parts();
        }
        if let Err(error) = std::fs::remove_file(&self.path) {
            tracing::warn!("{}: the temporary file stays behind: {error}", self.path.display());
        }
    }
}
