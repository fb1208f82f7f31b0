//! Errors in the data, the configuration and the files of a training.

use std::path::{Path, PathBuf};

use twin_foreign::OpenError;
use twin_record::{OutputError, RecordingError};

/// The reasons why a training cannot begin, resume or be written.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// A recording of this program cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording of another program cannot be used.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// A file of the training cannot be written.
    #[error("{0}. What was written before is intact")]
    Output(#[from] OutputError),
    /// A part of a recording is missing. Without an error, the training would give other weights under the same name.
    #[error("{0}; record the flight again, or cut the file cleanly")]
    Truncated(String),
    /// No argument is a recording.
    #[error(
        "no recording given; say which flights to train on, such as `twin train flights/*.mcap`"
    )]
    NoData,
    /// A number is not finite.
    #[error("{path}: {channel} is {value} at tick {tick}; only finite numbers can be learned from", path = path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The channel or output.
        channel: String,
        /// The value.
        value: f64,
        /// The tick.
        tick: usize,
    },
    /// The metadata of the recording does not hold `M_bar`.
    #[error("{path}: the metadata does not hold M_bar (gains.nominal_inertia), which its residuals depend on; record the flight again", path = path.display())]
    NoInertia {
        /// The file.
        path: PathBuf,
    },
    /// Recordings with different `M_bar` cannot be learned together.
    #[error("{path}: recorded with M_bar {found:?}, the flights before with {expected:?}; r depends on M_bar, so train on flights with one of them", path = path.display())]
    Inertia {
        /// The file.
        path: PathBuf,
        /// `M_bar` of this file.
        found: Vec<f64>,
        /// `M_bar` of the first file.
        expected: Vec<f64>,
    },
    /// The flights are too short.
    #[error(
        "{windows} windows for training and {validation} for validation in {ticks} usable ticks; at least one each is needed: a flight must last longer than {needed_s:.1} s in the air and out of contact"
    )]
    TooShort {
        /// Windows for training.
        windows: usize,
        /// Windows for validation.
        validation: usize,
        /// Usable ticks.
        ticks: usize,
        /// Time that a flight needs at least, s.
        needed_s: f64,
    },
    /// No coordinate of the residual, or no input channel, is known in every flight.
    #[error(
        "no coordinate of the residual, or no input channel, is known in all of these flights; `twin info FILE` lists what a flight holds"
    )]
    NothingKnown,
    /// The normal equations of the ridge regression have no solution.
    #[error(
        "the ridge regression on these flights has no solution: their numbers are too large to be squared; check the units of the recordings"
    )]
    Unsolvable,
    /// A configuration cannot be used.
    #[error("{source_name}: {why}")]
    Config {
        /// `small`, `paper` or the file.
        source_name: String,
        /// Key, value that was found, values that are allowed.
        why: String,
    },
    /// A file cannot be read or written.
    #[error("{path}: cannot {action}: {why}{hint}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// `read` or `write`.
        action: &'static str,
        /// The message of the operating system or of the format's reader.
        why: String,
        /// Remedy.
        hint: &'static str,
    },
    /// A checkpoint belongs to another training.
    #[error("{path}: this checkpoint is of another training: {what} was {found}, now it is {expected}; train without --resume, or with the same data and settings", path = path.display())]
    OtherTraining {
        /// The checkpoint.
        path: PathBuf,
        /// Name of the setting that differs.
        what: &'static str,
        /// Value in the checkpoint.
        found: String,
        /// Value now.
        expected: String,
    },
    /// The loss is no longer a finite number.
    #[error(
        "the loss is {loss} in epoch {epoch}: the training has diverged; use a smaller learning_rate (now {learning_rate}). The checkpoint of the epoch before is intact"
    )]
    Diverged {
        /// The loss.
        loss: f64,
        /// The epoch, from 1.
        epoch: usize,
        /// The learning rate.
        learning_rate: f64,
    },
    /// The device that `--device` asks for cannot be used.
    #[error("--device: {0}")]
    Device(String),
    /// The picture of the learning curve cannot be drawn.
    #[error("the learning curve cannot be drawn: {0}")]
    Picture(String),
}

impl LearnError {
    /// The error of a failed write. The file that was there before is intact.
    pub(super) fn write(path: &Path, why: impl std::fmt::Display) -> Self {
        let hint = "; free some space or choose another place with --out. What was written before is intact";
        Self::File { path: path.to_owned(), action: "write", why: why.to_string(), hint }
    }

    /// The error of a failed read.
    pub(super) fn read(path: &Path, why: impl std::fmt::Display) -> Self {
        Self::File { path: path.to_owned(), action: "read", why: why.to_string(), hint: "" }
    }
}
