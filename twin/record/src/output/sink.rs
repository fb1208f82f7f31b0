//! An output from its reservation to its name.

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::part::Part;
use super::place::Place;
use super::stdout::Results;
use super::{OutputError, Outputs};

/// An output whose place is reserved and which is not written yet.
#[derive(Debug)]
pub struct Output {
    pub(super) path: PathBuf,
    pub(super) flag: &'static str,
    pub(super) place: Place,
    pub(super) outputs: Outputs,
}

impl Output {
    /// The path as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The outputs of the run that it belongs to.
    pub fn outputs(&self) -> &Outputs {
        &self.outputs
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
