//! A flight that is still going on: the messages of a stream or of a growing file stay in memory for some minutes and are read
//! like a long recording, a short time behind the newest message.
//!
//! In: records from a thread. Out: [`OpenedFlight`]s, a new one whenever more is known (the gain of the thrust, once the vehicle
//! flies) or a new flight begins in the stream. While no message arrives, time continues and every value is unknown.

mod pulse;
mod shared;
mod backoff;
mod socket;
mod tail;
mod parts;
#[cfg(test)]
mod many_tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use super::opened::{OpenError, OpenedFlight, choose_map};
use shared::{Shared, wall};
use twin_input::interruption;

/// Period at which waiting threads check again.
const LOOK: Duration = Duration::from_millis(20);

/// Source of a flight that is still going on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum From {
    /// A Foxglove WebSocket server, `ws://HOST:PORT`.
    Socket(String),
    /// An MCAP file that is still being written.
    File(PathBuf),
}

/// A flight that is still going on, and the thread that listens to it.
#[derive(Debug)]
pub struct Live {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    /// Starts to listen; `map` names a map as for a recording.
    ///
    /// # Errors
    /// [`OpenError`] if the map cannot be used.
    pub fn listen(from: &From, map: Option<&str>) -> Result<Self, OpenError> {
        // The map that is asked for is checked now, not when the first message arrives.
        choose_map(map, None)?;
        let name = match from {
            From::Socket(url) => url.clone(),
            From::File(path) => path.display().to_string(),
        };
        let shared = Arc::new(Shared::new(name, map));
        let (theirs, from) = (Arc::clone(&shared), from.clone());
        let thread =
            std::thread::Builder::new().name("live".to_owned()).spawn(move || match from {
                From::Socket(url) => socket::listen(&theirs, &url),
                From::File(path) => tail::follow(&theirs, &path),
            });
        let thread = thread
            .inspect_err(|error| {
                tracing::error!("cannot start the thread that listens to the stream: {error}");
            })
            .ok();
        Ok(Self { shared, thread })
    }

    /// The messages so far as a flight; `None` until they contain a pose.
    pub fn opened(&self) -> Option<OpenedFlight> {
        parts::opened(&self.shared)
    }

    /// Waits for a flight for at most `patience`, or until a signal asks the program to end.
    pub fn wait(&self, patience: Duration) -> Option<OpenedFlight> {
        let start = wall();
        while start.elapsed() < patience && interruption::requested().is_none() {
            if self.shared.is_ripe()
                && let Some(opened) = self.opened()
            {
                return Some(opened);
            }
            std::thread::sleep(LOOK);
        }
        None
    }

    /// A counter that grows when [`Self::opened`] would return more than before.
    pub fn generation(&self) -> u64 {
        self.shared.generation()
    }

    /// What happened to the stream since the last call, one sentence each.
    pub fn news(&self) -> Vec<String> {
        self.shared.news()
    }

    /// True while messages arrive.
    pub fn is_up(&self) -> bool {
        self.shared.is_up()
    }

    /// Address or path of the source.
    pub fn name(&self) -> &str {
        self.shared.name()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.shared.stop();
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the thread that listens failed; its message is above");
        }
    }
}

/// Whether `text` is the address of a stream.
pub fn is_address(text: &Path) -> bool {
    text.to_str().is_some_and(|text| text.starts_with("ws://") || text.starts_with("wss://"))
}
