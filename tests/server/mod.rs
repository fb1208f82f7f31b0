//! A served flight with real connections: operators, slow clients and hostile pages.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking, as tests do")]

mod bursts;
mod closing;
pub(crate) mod console;
mod crowded;
mod descriptors;
mod flying;
mod forks;
#[cfg(feature = "foxglove-ws")]
mod foxglove;
#[cfg(feature = "foxglove-ws")]
mod foxglove_client;
#[cfg(feature = "foxglove-ws")]
mod foxglove_files;
#[cfg(feature = "foxglove-ws")]
mod foxglove_playback;
mod mirroring;
mod misuse;
mod operating;
mod raw;
mod serving;
mod slow;
#[cfg(feature = "foxglove-ws")]
mod streaming;
mod viewers;
mod watching;
