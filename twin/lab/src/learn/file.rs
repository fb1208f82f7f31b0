//! Writes the files of a training: each whole or not at all.

use std::path::Path;

use super::LearnError;
use twin_record::output::replace;

/// Writes `bytes` to `path`, a file of this training, over the one before, and makes the folders above it.
///
/// # Errors
/// [`LearnError::Output`] if the write fails, such as on a full disk; the old file is then intact.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), LearnError> {
    Ok(replace(path, bytes)?)
}
