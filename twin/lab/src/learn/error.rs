//! What can be wrong with data, configuration and files of a training.

use std::path::{Path, PathBuf};

use twin_foreign::OpenError;
use twin_record::RecordingError;

/// Why a training cannot begin, go on or be written.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// A recording of this program that cannot be used.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A recording of another program that cannot be used.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Part of a recording is missing: training on it in silence would give other weights under the same name.
    #[error("{0}; record the flight again, or cut the file cleanly")]
    Truncated(String),
    /// There is no recording among the arguments.
    #[error(
        "no recording given; say which flights to train on, such as `twin train flights/*.mcap`"
    )]
    NoData,
    /// A number that is not finite.
    #[error("{path}: {channel} is {value} at tick {tick}; only finite numbers can be learned from", path = path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The channel or output.
        channel: String,
        /// What was found.
        value: f64,
        /// The tick.
        tick: usize,
    },
    /// `M_bar` is not in the recording's metadata.
    #[error("{path}: the metadata names no M_bar (gains.nominal_inertia), so nobody knows what its residuals mean; record the flight again", path = path.display())]
    NoInertia {
        /// The file.
        path: PathBuf,
    },
    /// Recordings that cannot be learned together.
    #[error("{path}: recorded with M_bar {found:?}, the flights before with {expected:?}; r depends on M_bar, so train on flights with one of them", path = path.display())]
    Inertia {
        /// The file.
        path: PathBuf,
        /// Its `M_bar`.
        found: Vec<f64>,
        /// That of the first file.
        expected: Vec<f64>,
    },
    /// Too little to learn from.
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
        /// What a flight needs, s.
        needed_s: f64,
    },
    /// No row that every flight knows.
    #[error(
        "no residual row and input channel is known in every one of these flights; `twin info FILE` says what each holds"
    )]
    NothingKnown,
    /// A configuration that cannot be used.
    #[error("{source_name}: {why}")]
    Config {
        /// `small`, `paper` or the file.
        source_name: String,
        /// Key, what was found, what is allowed.
        why: String,
    },
    /// A file cannot be read or written.
    #[error("{path}: cannot {action}: {why}{hint}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// `read` or `write`.
        action: &'static str,
        /// What the system or the format said.
        why: String,
        /// What to do.
        hint: &'static str,
    },
    /// A checkpoint of another training.
    #[error("{path}: this checkpoint is of another training: {what} was {found}, now it is {expected}; train without --resume, or with the same data and settings", path = path.display())]
    OtherTraining {
        /// The checkpoint.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// In the checkpoint.
        found: String,
        /// Now.
        expected: String,
    },
    /// The loss is no number any more.
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
    /// The device that `--device` asks for.
    #[error("--device: {0}")]
    Device(String),
    /// The picture of the learning curve.
    #[error("the learning curve cannot be drawn: {0}")]
    Picture(String),
}

impl LearnError {
    /// A file that cannot be written: what was there before is untouched.
    pub(super) fn write(path: &Path, why: impl std::fmt::Display) -> Self {
        let hint = "; free some space or choose another place with --out. What was written before is intact";
        Self::File { path: path.to_owned(), action: "write", why: why.to_string(), hint }
    }

    /// A file that cannot be read.
    pub(super) fn read(path: &Path, why: impl std::fmt::Display) -> Self {
        Self::File { path: path.to_owned(), action: "read", why: why.to_string(), hint: "" }
    }
}
