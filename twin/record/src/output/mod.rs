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

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

pub use error::OutputError;
pub use recording_file::RecordingFile;
pub use stdout::{Results, note};

use part::Part;
use place::{FileId, Place, identity, is_stdout};

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
}

impl Outputs {
    /// The outputs of a run that replaces existing files only if `overwrite` is true.
    pub fn new(overwrite: bool) -> Self {
        Self { overwrite, run: Arc::default() }
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
            make_folder(place::folder(path), flag)?;
        }
        self.reserve(path, flag)
    }

    /// Reserves stdout for the results that `flag` asks for, such as one JSON object.
    ///
    /// # Errors
    /// [`OutputError::Twice`] if another output has stdout.
    pub fn reserve_stdout(&self, flag: &'static str) -> Result<(), OutputError> {
        self.take(Path::new("-"), &Place::Stdout, flag)
    }

    /// The stream for the text that people read: stdout, or stderr if an output goes to stdout.
    pub fn results(&self) -> Results {
        let taken =
            self.run().taken.iter().any(|(place, flag)| *place == Place::Stdout && *flag != JSON);
        if taken { Results::stderr() } else { Results::stdout() }
    }

    /// Creates the file of a recording at `path`. If it exists, the recording replaces it with `--overwrite`, and otherwise takes the
    /// next free number.
    ///
    /// # Errors
    /// [`OutputError`] if `path` is an input or stdout, if another process records to it, or if the folder takes no file.
    pub fn recording(&self, path: &Path) -> Result<RecordingFile, OutputError> {
        let flag = recording_file::FLAG;
        let place = Place::find(path, flag)?;
        self.check(path, &place, flag)?;
        let file = match &place {
            Place::Stdout => {
                return Err(OutputError::Unfit {
                    path: path.to_owned(),
                    flag,
                    found: "a recording has an index, which is written last".to_owned(),
                    remedy: "name a file",
                });
            }
            Place::Stream(path) => return RecordingFile::stream(path),
            Place::File { real, exists: true } if self.overwrite => {
                self.may_replace(path, real, flag)?;
                RecordingFile::instead_of(real, path)?
            }
            Place::File { .. } => RecordingFile::numbered(path)?,
        };
        self.take(path, &Place::find(file.path(), flag)?, flag)?;
        Ok(file)
    }

    /// Creates the file of a further recording of this run: at `path`, or at the next free number. It never replaces a file.
    ///
    /// # Errors
    /// [`OutputError`] if the folder takes no file.
    pub fn next_recording(&self, path: &Path) -> Result<RecordingFile, OutputError> {
        Self { overwrite: false, run: Arc::clone(&self.run) }.recording(path)
    }

    /// Refuses an output that is an input, and one whose file another output has taken.
    fn check(&self, path: &Path, place: &Place, flag: &'static str) -> Result<(), OutputError> {
        let Place::File { real, .. } = place else { return Ok(()) };
        let run = self.run();
        let input = identity(real).and_then(|file| run.inputs.get(&file).cloned());
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
        let same = |taken: &Place| match (taken, place) {
            (Place::Stdout, Place::Stdout) => true,
            (Place::File { real: a, .. }, Place::File { real: b, .. }) => a == b,
            _ => false,
        };
        let mut run = self.run();
        if let Some((_, first)) = run.taken.iter().find(|(taken, _)| same(taken)) {
            return Err(OutputError::Twice { path: path.to_owned(), first, second: flag });
        }
        run.taken.push((place.clone(), flag));
        Ok(())
    }

    fn run(&self) -> MutexGuard<'_, Run> {
        // Nothing can leave the lists half changed.
        self.run.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The flag that puts the results themselves on stdout.
const JSON: &str = "--json";

/// An output whose place is reserved and which is not written yet.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    flag: &'static str,
    place: Place,
    outputs: Outputs,
}

impl Output {
    /// The path as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the output goes to stdout.
    pub fn is_stdout(&self) -> bool {
        self.place == Place::Stdout
    }

    /// Opens the output.
    ///
    /// # Errors
    /// [`OutputError`] if the folder takes no file, or the pipe or device cannot be opened.
    pub fn open(self) -> Result<Sink, OutputError> {
        let stream = match &self.place {
            Place::Stdout => Stream::Stdout(Results::stdout()),
            Place::Stream(path) => {
                let file = OpenOptions::new().write(true).open(path);
                let file = file.map_err(|why| OutputError::write(&self.path, why))?;
                Stream::Device(BufWriter::new(file))
            }
            Place::File { real, .. } => {
                let part = Part::beside(real);
                Stream::Part(part.map_err(|why| OutputError::folder(&self.path, self.flag, &why))?)
            }
        };
        Ok(Sink { output: self, stream })
    }

    /// Writes `bytes` as the whole output.
    ///
    /// # Errors
    /// [`OutputError`] if the output cannot be written; the folder is then as it was.
    pub fn write(self, bytes: &[u8]) -> Result<(), OutputError> {
        let path = self.path.clone();
        let mut sink = self.open()?;
        sink.write_all(bytes).map_err(|why| OutputError::write(&path, why))?;
        sink.finish()
    }
}

/// An open output. [`Sink::finish`] gives a file its name; if it is dropped before, nothing stays behind.
#[derive(Debug)]
pub struct Sink {
    output: Output,
    stream: Stream,
}

#[derive(Debug)]
enum Stream {
    Part(Part),
    Device(BufWriter<File>),
    Stdout(Results),
}

impl Sink {
    /// Writes the rest and gives the file its name.
    ///
    /// # Errors
    /// [`OutputError`] if the rest cannot be written, or somebody made a file of this name since it was reserved.
    pub fn finish(self) -> Result<(), OutputError> {
        let Output { path, flag, place, outputs } = self.output;
        let failed = |why: std::io::Error| match why.kind() {
            ErrorKind::AlreadyExists => OutputError::Exists { path: path.clone(), flag },
            _ => OutputError::write(&path, why),
        };
        match (self.stream, &place) {
            (Stream::Part(part), Place::File { real, .. }) => {
                // The run may have come to read the file since.
                outputs.check(&path, &place, flag)?;
                part.rename(real, outputs.overwrite).map_err(failed)
            }
            (Stream::Part(_), _) => Ok(()),
            (Stream::Device(mut file), _) => file.flush().map_err(failed),
            (Stream::Stdout(mut stdout), _) => stdout.flush().map_err(failed),
        }
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let done = match &mut self.stream {
            Stream::Part(part) => part.write(bytes),
            Stream::Device(file) => file.write(bytes),
            Stream::Stdout(stdout) => stdout.write(bytes),
        };
        done.map_err(|why| OutputError::write(&self.output.path, why).into())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        let done = match &mut self.stream {
            Stream::Part(part) => part.flush(),
            Stream::Device(file) => file.flush(),
            Stream::Stdout(stdout) => stdout.flush(),
        };
        done.map_err(|why| OutputError::write(&self.output.path, why).into())
    }
}

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

/// Writes a file that belongs to the program, such as a checkpoint or a cached report: whole or not at all, over the one before. It
/// makes the folder.
///
/// # Errors
/// [`OutputError::Write`] if the write fails; the file before it is then intact.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let failed = |why| OutputError::write(path, why);
    std::fs::create_dir_all(place::folder(path)).map_err(failed)?;
    // A link stays a link: the file that it leads to is replaced.
    let real = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut part = Part::beside(&real).map_err(failed)?;
    part.write_all(bytes).map_err(failed)?;
    part.rename(&real, true).map_err(failed)
}

#[cfg(test)]
mod tests;
