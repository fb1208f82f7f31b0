//! Stdout, and the text that a command prints as its result.

use std::io::{BufWriter, ErrorKind, Stdout, Write};
use std::path::Path;

use super::OutputError;

/// Results of a command as text or JSON. They go to stdout, or to stderr if an output of the command has taken stdout with `-`.
///
/// A reader that closes stdout early, as `| head` does, is no failure: the rest is dropped. Any other error names stdout.
#[derive(Debug)]
pub struct Results(Stream);

#[derive(Debug)]
enum Stream {
    Open(BufWriter<Stdout>),
    Closed,
    Stderr,
}

impl Results {
    /// Results on stdout.
    pub fn stdout() -> Self {
        Self(Stream::Open(BufWriter::new(std::io::stdout())))
    }

    /// Results on stderr.
    pub(super) fn stderr() -> Self {
        Self(Stream::Stderr)
    }

    fn settle<T>(&mut self, done: std::io::Result<T>, otherwise: T) -> std::io::Result<T> {
        match done {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => {
                self.0 = Stream::Closed;
                Ok(otherwise)
            }
            Err(error) => Err(OutputError::write(Path::new("stdout"), error).into()),
            Ok(done) => Ok(done),
        }
    }
}

impl Write for Results {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let done = match &mut self.0 {
            Stream::Open(stdout) => stdout.write(bytes),
            Stream::Closed => Ok(bytes.len()),
            // Nobody is left to tell that stderr is closed or full.
            Stream::Stderr => Ok(std::io::stderr().write(bytes).unwrap_or(bytes.len())),
        };
        self.settle(done, bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        let done = match &mut self.0 {
            Stream::Open(stdout) => stdout.flush(),
            Stream::Closed | Stream::Stderr => Ok(()),
        };
        self.settle(done, ())
    }
}

/// Prints a line on stderr for the user. If stderr is closed or full, the line is lost and the command goes on.
pub fn note(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
