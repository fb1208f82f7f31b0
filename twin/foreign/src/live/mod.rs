//! A flight that still goes on: what a stream or a growing file says is kept for some minutes and read like a long recording,
//! a short time behind it.
//!
//! In: records from a thread. Out: [`OpenedFlight`]s, anew whenever more is known (the thrust's gain, once it flies) or the
//! stream begins anew. While nothing comes, time goes on and nothing is known.

mod pulse;
mod shared;
mod socket;
mod tail;
mod footage;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use super::opened::{OpenError, OpenedFlight, choose_map};
use shared::{Shared, wall};

/// How often those who wait look.
const LOOK: Duration = Duration::from_millis(20);

/// Where a flight comes from that still goes on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum From {
    /// A Foxglove WebSocket server, `ws://HOST:PORT`.
    Socket(String),
    /// An MCAP file that is still being written.
    File(PathBuf),
}

/// A flight that still goes on.
#[derive(Debug)]
pub struct Live {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    /// Begins to listen; `map` as for a recording.
    ///
    /// # Errors
    /// [`OpenError`] if the map is not usable.
    pub fn listen(from: &From, map: Option<&str>) -> Result<Self, OpenError> {
        // A map that is asked for is checked at once, not when the first message comes.
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
        let thread = thread.inspect_err(|error| tracing::error!("nobody listens: {error}")).ok();
        Ok(Self { shared, thread })
    }

    /// What is heard so far as a flight; `None` while there is no pose in it.
    pub fn opened(&self) -> Option<OpenedFlight> {
        footage::opened(&self.shared)
    }

    /// Waits for a flight for at most `patience`.
    pub fn wait(&self, patience: Duration) -> Option<OpenedFlight> {
        let start = wall();
        while start.elapsed() < patience {
            if self.shared.is_ripe()
                && let Some(opened) = self.opened()
            {
                return Some(opened);
            }
            std::thread::sleep(LOOK);
        }
        None
    }

    /// Counts up when there is more to know: then [`Self::opened`] says more.
    pub fn generation(&self) -> u64 {
        self.shared.generation()
    }

    /// What happened to the stream since the last call, a sentence each.
    pub fn news(&self) -> Vec<String> {
        self.shared.news()
    }

    /// Messages come.
    pub fn is_up(&self) -> bool {
        self.shared.is_up()
    }

    /// Where it comes from.
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
