//! A running server: its addresses, and how it stops.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::runtime::Runtime;
use tokio::sync::watch;

use crate::server::hub::Hub;
use crate::server::listen::Beside;
use crate::server::{App, ServerError, foxglove};
use twin_input::interruption::{self, Signal};

/// Period at which the program looks for a signal.
const LOOK: Duration = Duration::from_millis(20);

/// Connections get this long to close.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(1);

/// How a served flight ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Served {
    /// The signal that ended it.
    pub signal: Signal,
    /// False if a recording failed.
    pub recordings_whole: bool,
}

/// A running server. It stops when it is dropped.
pub struct Running {
    pub(super) address: SocketAddr,
    pub(super) foxglove: Option<(SocketAddr, tokio::task::JoinHandle<()>)>,
    pub(super) hub: Arc<Hub>,
    pub(super) landing: Arc<AtomicBool>,
    pub(super) shutdown: watch::Sender<bool>,
    pub(super) flight: Option<JoinHandle<bool>>,
    pub(super) runtime: Option<Runtime>,
}

/// Logs the addresses of the server and serves until a signal asks the program to end.
pub(super) fn watch(running: Running) -> Served {
    tracing::info!("console on http://{}", running.address());
    if let Some(address) = running.foxglove_address() {
        tracing::info!("Foxglove on ws://{address}");
    }
    running.wait()
}

impl Running {
    /// Address of the console.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Address of the server for Foxglove; `None` if it does not run.
    pub fn foxglove_address(&self) -> Option<SocketAddr> {
        self.foxglove.as_ref().map(|(address, _)| *address)
    }

    /// Starts the server for Foxglove.
    ///
    /// # Errors
    /// [`ServerError::Foxglove`] if it cannot start.
    pub(super) fn open_beside(&mut self, beside: Beside, app: Arc<App>) -> Result<(), ServerError> {
        if let Some(runtime) = &self.runtime {
            let (host, port) = (self.address.ip(), beside.port);
            let stopped = self.shutdown.subscribe();
            let started = runtime.block_on(foxglove::start(host, beside, app, stopped));
            self.foxglove = Some(started.map_err(|why| ServerError::Foxglove { port, why })?);
        }
        Ok(())
    }

    /// Waits for a signal that asks the program to end, then stops.
    pub fn wait(mut self) -> Served {
        let signal = loop {
            if let Some(signal) = interruption::requested() {
                break signal;
            }
            std::thread::sleep(LOOK);
        };
        let recordings_whole = self.shut_down();
        Served { signal, recordings_whole }
    }

    /// Ends the flight, its recording and every connection.
    pub fn stop(mut self) {
        self.shut_down();
    }

    /// Returns whether every recording is whole.
    fn shut_down(&mut self) -> bool {
        self.landing.store(true, Ordering::Relaxed);
        self.hub.close_all("the server stops");
        let recordings_whole = self.flight.take().is_none_or(|flight| {
            flight.join().unwrap_or_else(|_| {
                tracing::error!("the flight thread failed; its message is above");
                false
            })
        });
        if let (Some((_, farewell)), Some(runtime)) = (self.foxglove.take(), &self.runtime) {
            // After the time-out the runtime stops and drops messages that are not sent.
            let _ =
                runtime.block_on(async { tokio::time::timeout(SHUTDOWN_TIMEOUT, farewell).await });
        }
        self.shutdown.send_replace(true);
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_timeout(SHUTDOWN_TIMEOUT);
        }
        recordings_whole
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.shut_down();
    }
}
