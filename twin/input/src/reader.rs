//! Reads a long file piece by piece, and asks for a request to stop before each piece.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::stop::Stopped;
use crate::{InputError, Stop, file};

/// Bytes that are read at once.
const PIECE_BYTES: usize = 1 << 16;

/// A file, or another input, that is read piece by piece. A request to stop ends the next read with an error.
#[derive(Debug)]
pub struct Reader<R = File> {
    input: BufReader<Asking<R>>,
}

/// An input that asks for a request to stop before each read; the request ends the read with an error.
#[derive(Debug)]
pub struct Asking<R = File> {
    input: R,
    stop: Stop,
}

impl<R> Asking<R> {
    /// Reads `input` until the process is asked to stop.
    pub fn new(input: R) -> Self {
        Self { input, stop: Stop::of_process() }
    }
}

impl Reader {
    /// Opens the regular file `path`.
    ///
    /// # Errors
    /// [`InputError`] if the system refuses, or the path names anything but a regular file.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        Ok(Self::new(file::open(path)?))
    }

    /// Length of the file, bytes.
    ///
    /// # Errors
    /// [`InputError`] if the system refuses.
    pub fn length(&self) -> Result<u64, InputError> {
        Ok(self.input.get_ref().input.metadata()?.len())
    }
}

impl<R: Read> Reader<R> {
    /// Reads `input` until the process is asked to stop.
    pub fn new(input: R) -> Self {
        Self::until(input, Stop::of_process())
    }

    /// Reads `input` until `stop` is requested.
    pub fn until(input: R, stop: Stop) -> Self {
        Self { input: BufReader::with_capacity(PIECE_BYTES, Asking { input, stop }) }
    }
}

impl<R: Read> Read for Asking<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.stop.is_requested() {
            return Err(Stopped.into());
        }
        self.input.read(buffer)
    }
}

impl<R: Seek> Seek for Asking<R> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.input.seek(to)
    }
}

impl<R: Read> Read for Reader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        self.input.read(buffer)
    }
}

impl<R: Read> BufRead for Reader<R> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        self.input.fill_buf()
    }

    fn consume(&mut self, amount: usize) {
        self.input.consume(amount);
    }
}

impl<R: Read + Seek> Seek for Reader<R> {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.input.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stop::is_stop;

    /// An input without an end that asks to stop after some pieces.
    struct Endless {
        pieces: u64,
        stop: Stop,
    }

    impl Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            self.pieces -= 1;
            if self.pieces == 0 {
                self.stop.request();
            }
            buffer.fill(0);
            Ok(buffer.len())
        }
    }

    #[test]
    fn a_request_ends_the_next_read_of_an_input_that_never_ends() {
        let stop = Stop::default();
        let mut reader = Reader::until(Endless { pieces: 3, stop: stop.clone() }, stop);
        let mut bytes = Vec::new();
        let error = reader.read_to_end(&mut bytes).unwrap_err();
        assert!(is_stop(&error), "{error}");
        assert!(matches!(InputError::from(error), InputError::Stopped(_)));
    }

    #[test]
    fn a_reader_without_a_request_reads_and_seeks_as_its_input_does() {
        let mut reader = Reader::until(std::io::Cursor::new(b"abcdef".to_vec()), Stop::default());
        let mut text = String::new();
        reader.read_to_string(&mut text).unwrap();
        reader.seek(SeekFrom::Start(4)).unwrap();
        reader.read_to_string(&mut text).unwrap();
        assert_eq!(text, "abcdefef");
    }
}
