//! Salvages a recording that was cut off, that was never finished, or that is damaged in the middle.
//!
//! In: an MCAP file of any program. Out: a finished MCAP file with everything that can be read, and an account of what is lost. The
//! messages of a chunk are kept if its checksum holds; of the last, unfinished chunk every whole message is kept, as far as it
//! decompresses. Behind damage the reading goes on at the next record. Memory holds one chunk, of at most 256 MiB.

mod source;
mod head;
mod report;
mod chunk;
mod salvage;
mod walk;

use std::io::Write;
use std::path::Path;

use mcap::write::NoSeek;

pub use report::{Loss, RecoverError, Salvaged};
pub use salvage::METADATA_RECOVERED;

use report::Trouble;
use salvage::Salvage;
use source::Source;
use walk::{Walk, header};

/// Salvages `path` into `out`, which is empty. With `unverified` the messages of chunks whose checksum is wrong are kept, too: some of
/// them may have wrong values.
///
/// # Errors
/// [`RecoverError`] if the file cannot be read, if nothing in it can be salvaged, or if the new file cannot be written.
pub fn recover(path: &Path, out: impl Write, unverified: bool) -> Result<Salvaged, RecoverError> {
    let said = |trouble: Trouble| match trouble {
        Trouble::Read(why) => RecoverError::Read { path: path.to_owned(), why },
        Trouble::Write(why) => RecoverError::Write(why.to_string()),
        Trouble::Signal(signal) => RecoverError::Interrupted(signal),
    };
    let salvage = || -> Result<Salvaged, Trouble> {
        let mut source = Source::open(path)?;
        let (profile, library) = header(&mut source)?;
        let out = Salvage::new(NoSeek::new(out), &profile, &library)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Walk::new(source, out, unverified).run()?.finish(&name)?)
    };
    let salvaged = salvage().map_err(said)?;
    if salvaged.messages + salvaged.channels + salvaged.attachments + salvaged.metadata == 0 {
        return Err(RecoverError::Nothing { path: path.to_owned(), bytes: salvaged.bytes });
    }
    Ok(salvaged)
}

#[cfg(test)]
mod tests;
