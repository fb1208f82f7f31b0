//! Opens every file that a command writes. No other module of the program creates, replaces or renames a file.
//!
//! In: the inputs of a run and the paths that its flags name. Out: an [`Output`] for each path, or an [`OutputError`] that names the
//! file, the cause and the remedy. State: which files the run reads, and which places its outputs have taken.
//!
//! 1. An output that is an input of the run is refused. Device and inode are compared, so links are no way around.
//! 2. A file that exists is refused, unless the user wants it replaced (`--overwrite`). A recording takes the next free number instead.
//! 3. Two outputs of one run cannot have one place.
//! 4. An output is written to a temporary file in its folder, which gets the final name when it is whole. A failure leaves the folder
//!    as it was. A recording is the exception: it grows under its own name, which is created exclusively and locked.
//! 5. `-` is stdout. A pipe or a character device such as `/dev/null` is written directly; a pipe waits for its reader.

mod error;
mod place;
mod part;
mod stdout;
mod recording_file;
mod sink;
mod owned;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

pub use error::OutputError;
pub use owned::{install, make_folder, replace};
pub use recording_file::RecordingFile;
pub use sink::{Output, Sink};
pub use stdout::{Results, note};

use part::Part;
use place::{FileId, Place, identity, is_pipe, is_stdout, stdout_identity};
use recording_file::{MOST_NUMBERS, with_number};

/// The outputs of one run of a command. Clones share their state, so threads can open outputs of the same run.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    overwrite: bool,
    run: Arc<Mutex<Run>>,
}

/// What the outputs of a run must not meet.
#[derive(Debug, Default)]
struct Run {
    inputs: BTreeMap<FileId, PathBuf>,
    taken: Vec<(Place, &'static str)>,
    /// Whether an output named `-` has stdout.
    piped: bool,
}

impl Outputs {
    /// The outputs of a run that replaces existing files only if `overwrite` is true.
    pub fn new(overwrite: bool) -> Self {
        Self { overwrite, run: Arc::default() }
    }

    /// The same outputs, of which one replaces an existing file because the user asked for that in another way.
    #[must_use]
    pub fn replacing(&self) -> Self {
        Self { overwrite: true, run: Arc::clone(&self.run) }
    }

    /// Protects the files that this run reads. Paths at which nothing is, and folders, are left out.
    pub fn protect<P: AsRef<Path>>(&self, inputs: impl IntoIterator<Item = P>) {
        let mut run = self.run();
        for input in inputs {
            let path = input.as_ref();
            if path.is_file()
                && let Some(file) = identity(path)
            {
                run.inputs.insert(file, path.to_owned());
            }
        }
    }

    /// Reserves `path` for the output that `flag` names, and tries whether its folder takes a file.
    ///
    /// # Errors
    /// [`OutputError`] if no output can go there; see the rules of this module.
    pub fn reserve(&self, path: &Path, flag: &'static str) -> Result<Output, OutputError> {
        let place = Place::find(path, flag)?;
        self.check(path, &place, flag)?;
        if let Place::File { real, exists } = &place {
            if *exists {
                self.may_replace(path, real, flag)?;
            }
            // Hours of work should not end at a folder without permission. The file is removed at once.
            drop(Part::beside(real).map_err(|why| OutputError::folder(path, flag, &why))?);
        }
        self.take(path, &place, flag)?;
        self.run().piped |= place == Place::Stdout;
        Ok(Output { path: path.to_owned(), flag, place, outputs: self.clone() })
    }

    /// Like [`Outputs::reserve`], and makes the folder of `path` if it is missing.
    ///
    /// # Errors
    /// [`OutputError`] if no output can go there.
    pub fn reserve_with_folder(
        &self,
        path: &Path,
        flag: &'static str,
    ) -> Result<Output, OutputError> {
        if !is_stdout(path) {
            make_folder(folder(path), flag)?;
        }
        self.reserve(path, flag)
    }

    /// Like [`Outputs::reserve`]; an existing file that may not be replaced gives way to the next free number.
    ///
    /// # Errors
    /// [`OutputError`] if no output can go there.
    pub fn reserve_numbered(&self, path: &Path, flag: &'static str) -> Result<Output, OutputError> {
        let mut taken = OutputError::Exists { path: path.to_owned(), flag };
        for number in 1..MOST_NUMBERS {
            match self.reserve(&with_number(path, number), flag) {
                Err(error @ OutputError::Exists { .. }) => taken = error,
                done => return done,
            }
        }
        Err(taken)
    }

    /// Reserves stdout for the results that `flag` asks for, such as one JSON object.
    ///
    /// # Errors
    /// [`OutputError::Twice`] if another output has stdout.
    pub fn reserve_stdout(&self, flag: &'static str) -> Result<(), OutputError> {
        self.check(Path::new("stdout"), &Place::Stdout, flag)?;
        self.take(Path::new("-"), &Place::Stdout, flag)
    }

    /// The stream for results: stdout, or stderr if a file was named `-` and goes to stdout.
    pub fn results(&self) -> Results {
        if self.run().piped { Results::stderr() } else { Results::stdout() }
    }

    /// Creates the file of a recording at `path`. If it exists, the recording replaces it with `--overwrite`, and otherwise takes the
    /// next free number. A recording of the same run is never replaced.
    ///
    /// # Errors
    /// [`OutputError`] if `path` is an input, stdout or a pipe, if another process records to it, or if the folder takes no file.
    pub fn recording(&self, path: &Path, flag: &'static str) -> Result<RecordingFile, OutputError> {
        let place = Place::find(path, flag)?;
        self.check(path, &place, flag)?;
        let file = match &place {
            Place::Stream(device) if !is_pipe(device) => return RecordingFile::stream(device),
            Place::Stdout | Place::Stream(_) => {
                return Err(OutputError::Unfit {
                    path: path.to_owned(),
                    flag,
                    found: "a recording has parts that are written last, at its start".to_owned(),
                    remedy: "name a file",
                });
            }
            Place::File { real, exists: true } if self.overwrite && !self.has_taken(&place) => {
                self.may_replace(path, real, flag)?;
                RecordingFile::instead_of(real, path, flag)?
            }
            Place::File { .. } => RecordingFile::numbered(path, flag)?,
        };
        self.take(path, &Place::find(file.path(), flag)?, flag)?;
        Ok(file)
    }

    /// Refuses a place where an output of this name could not go, without reserving it.
    ///
    /// # Errors
    /// [`OutputError`] if no output can go there.
    pub fn may_write(&self, path: &Path, flag: &'static str) -> Result<(), OutputError> {
        let place = Place::find(path, flag)?;
        self.check(path, &place, flag)?;
        match &place {
            Place::File { real, exists: true } => self.may_replace(path, real, flag),
            _ => Ok(()),
        }
    }

    /// Creates the file of a recording at `path` and nowhere else: an existing file is refused, or replaced with `--overwrite`.
    ///
    /// # Errors
    /// [`OutputError`] as of [`Outputs::recording`], and if the file exists.
    pub fn named_recording(
        &self,
        path: &Path,
        flag: &'static str,
    ) -> Result<RecordingFile, OutputError> {
        self.may_write(path, flag)?;
        let file = self.recording(path, flag)?;
        if file.renamed().is_none() {
            return Ok(file);
        }
        // Somebody made it since; the numbered file goes again.
        file.discard();
        Err(OutputError::Exists { path: path.to_owned(), flag })
    }

    /// Creates the file of a further recording of this run: at `path`, or at the next free number. It never replaces a file.
    ///
    /// # Errors
    /// [`OutputError`] if the folder takes no file.
    pub fn next_recording(
        &self,
        path: &Path,
        flag: &'static str,
    ) -> Result<RecordingFile, OutputError> {
        Self { overwrite: false, run: Arc::clone(&self.run) }.recording(path, flag)
    }

    /// Refuses an output that is an input, and one whose file another output has taken.
    fn check(&self, path: &Path, place: &Place, flag: &'static str) -> Result<(), OutputError> {
        let found = match place {
            Place::File { real, .. } => identity(real),
            Place::Stdout => stdout_identity(),
            Place::Stream(_) => None,
        };
        let run = self.run();
        let input = found.and_then(|file| run.inputs.get(&file).cloned());
        match input {
            Some(input) => Err(OutputError::Input { path: path.to_owned(), flag, input }),
            None => Ok(()),
        }
    }

    fn may_replace(&self, path: &Path, real: &Path, flag: &'static str) -> Result<(), OutputError> {
        if !self.overwrite {
            return Err(OutputError::Exists { path: path.to_owned(), flag });
        }
        let protected = std::fs::metadata(real).is_ok_and(|found| found.permissions().readonly());
        if protected {
            return Err(OutputError::Unfit {
                path: path.to_owned(),
                flag,
                found: "the file is write-protected".to_owned(),
                remedy: "remove its protection, or choose another file",
            });
        }
        Ok(())
    }

    /// Takes the place, or refuses it if another output has it. A device can have many outputs.
    fn take(&self, path: &Path, place: &Place, flag: &'static str) -> Result<(), OutputError> {
        let mut run = self.run();
        if let Some((_, first)) = run.taken.iter().find(|(taken, _)| taken.is_same(place)) {
            return Err(OutputError::Twice { path: path.to_owned(), first, second: flag });
        }
        run.taken.push((place.clone(), flag));
        Ok(())
    }

    fn has_taken(&self, place: &Place) -> bool {
        self.run().taken.iter().any(|(taken, _)| taken.is_same(place))
    }

    fn run(&self) -> MutexGuard<'_, Run> {
        // Nothing can leave the lists half changed.
        self.run.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The folder of `path`; that of a bare name is the working folder.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."))
}

#[cfg(test)]
mod tests;
