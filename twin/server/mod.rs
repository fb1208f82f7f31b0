//! The browser's side: one thread flies in real time, everybody watches, operators turn gains.
//!
//! In: a [`Scenario`]. Out: `/` (console), `/ws` (see [`protocol`] and [`telemetry`]), `/api/health`, `/api/state`,
//! `/api/gains`. The flight thread ([`pilot`]) never waits for a socket; each client has its own bounded [`outbox`].

mod assets;
pub mod channels;
mod client;
mod command;
mod gains;
mod http;
mod hub;
mod logbook;
mod origin;
mod outbox;
mod pace;
mod pilot;
pub mod protocol;
mod rate;
mod sortie;
pub mod telemetry;
#[cfg(test)]
mod typescript;

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tokio::net::{TcpListener, TcpSocket};
use tokio::runtime::Runtime;
use tokio::sync::oneshot;

use crate::mirror::RecordingError;
use crate::scenario::{BuildError, Preset, Scenario};
use crate::server::command::Request;
use crate::server::hub::Hub;
use crate::server::logbook::Logbook;
use crate::server::pilot::{Orders, Pilot};
use crate::server::protocol::ScenarioInfo;
use crate::tuning::Tuning;

/// Requests that may wait for the flight.
const MOST_REQUESTS: usize = 1024;

/// Little is buffered in the kernel, so that a slow client sees new rows instead of old ones, bytes.
const SEND_BUFFER: u32 = 64 * 1024;

/// Connections get this long to close.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(1);

/// Connections that may wait to be accepted.
const BACKLOG: u32 = 128;

/// What to serve.
pub struct ServeOptions {
    /// First flight.
    pub scenario: Scenario,
    /// Scenarios that a restart may name.
    pub catalogue: Vec<Scenario>,
    /// Where to listen: a loopback name or address.
    pub host: String,
    /// Where to listen; 0 takes any free port.
    pub port: u16,
    /// Simulated seconds per second; `None` is as fast as the machine can.
    pub speed: Option<f64>,
    /// Wait for an operator.
    pub start_paused: bool,
    /// MCAP file of the flight; those of restarts are numbered.
    pub record: Option<PathBuf>,
}

/// Why a flight cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The host is no name or address of this machine's loopback.
    #[error(
        "host {found:?} refused: anybody who reaches the port can fly; allowed: localhost, 127.0.0.1, ::1; use an ssh tunnel to watch from another machine"
    )]
    BeyondLoopback {
        /// What was asked for.
        found: String,
    },
    /// Somebody else listens there.
    #[error(
        "port {port} on {address} is in use, perhaps by another twin; choose another with --port, or 0 for any free one"
    )]
    PortInUse {
        /// The address.
        address: IpAddr,
        /// The port.
        port: u16,
    },
    /// The system does not let us listen.
    #[error("cannot listen on {address}: {source}; choose another port with --port")]
    Listen {
        /// Where.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
    /// The flight cannot be built.
    #[error(transparent)]
    Scenario(#[from] BuildError),
    /// The recording cannot be created.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The system gives us no thread or no signals.
    #[error("cannot start the server: {0}")]
    System(#[from] std::io::Error),
    /// The flight thread ended before it published anything.
    #[error("the flight ended before it began; run it with --headless to see why")]
    NoFlight,
}

/// What every connection shares.
struct App {
    hub: Arc<Hub>,
    scenarios: Arc<Vec<ScenarioInfo>>,
    /// Values that are in range, to try a change on.
    tuning: Tuning,
    requests: SyncSender<Request>,
    started: Instant,
}

impl App {
    /// Time since the server started, s.
    fn uptime_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

/// A server that runs.
pub struct Running {
    address: SocketAddr,
    hub: Arc<Hub>,
    landing: Arc<AtomicBool>,
    shutdown: Option<oneshot::Sender<()>>,
    flight: Option<JoinHandle<()>>,
    runtime: Option<Runtime>,
}

/// Serves a flight until Ctrl+C.
///
/// # Errors
/// [`ServerError`] if it cannot start.
pub fn serve(options: ServeOptions) -> Result<(), ServerError> {
    let running = spawn(options)?;
    tracing::info!("console on http://{}", running.address());
    running.wait()
}

/// Serves a flight in the background.
///
/// # Errors
/// [`ServerError`] if it cannot start.
pub fn spawn(options: ServeOptions) -> Result<Running, ServerError> {
    let address = SocketAddr::new(loopback(&options.host)?, options.port);
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    let listener = runtime.block_on(async { listen(address) })?;
    let address = listener.local_addr()?;

    let (requests, inbox) = sync_channel(MOST_REQUESTS);
    let landing = Arc::new(AtomicBool::new(false));
    let tuning = options.scenario.preset_tuning(Preset::Tuned);
    let (hub, flight) = take_off(options, inbox, Arc::clone(&landing))?;
    let scenarios = hub.published().scenarios;
    let app =
        Arc::new(App { hub: Arc::clone(&hub), scenarios, tuning, requests, started: pace::now() });
    let (shutdown, asked) = oneshot::channel::<()>();
    runtime.spawn(async move {
        let stopped = async {
            // A sender that is gone asks for the same as one that speaks.
            let _ = asked.await;
        };
        if let Err(error) =
            axum::serve(listener, http::router(app)).with_graceful_shutdown(stopped).await
        {
            tracing::error!("the server stopped: {error}");
        }
    });
    Ok(Running {
        address,
        hub,
        landing,
        shutdown: Some(shutdown),
        flight: Some(flight),
        runtime: Some(runtime),
    })
}

/// Starts the flight's thread. The flight is built there too, so nothing in it has to move between threads.
fn take_off(
    options: ServeOptions,
    inbox: Receiver<Request>,
    landing: Arc<AtomicBool>,
) -> Result<(Arc<Hub>, JoinHandle<()>), ServerError> {
    let orders = Orders {
        scenario: options.scenario,
        catalogue: options.catalogue,
        speed: options.speed,
        start_paused: options.start_paused,
        logbook: Logbook::new(options.record),
    };
    let (ready, published) = sync_channel(1);
    let flight = std::thread::Builder::new().name("flight".to_owned()).spawn(move || {
        let (pilot, told) = match Pilot::new(orders) {
            Ok(pilot) => {
                let hub = pilot.hub();
                (Some(pilot), ready.send(Ok(hub)))
            }
            Err(error) => (None, ready.send(Err(error))),
        };
        if let (Some(pilot), Ok(())) = (pilot, told) {
            pilot.fly(&inbox, &landing);
        }
    })?;
    let hub = published.recv().map_err(|_| ServerError::NoFlight)??;
    Ok((hub, flight))
}

fn loopback(host: &str) -> Result<IpAddr, ServerError> {
    if host.eq_ignore_ascii_case("localhost") {
        return Ok(IpAddr::V4(Ipv4Addr::LOCALHOST));
    }
    match host.trim_matches(['[', ']']).parse::<IpAddr>() {
        Ok(address) if address.is_loopback() => Ok(address),
        _ => Err(ServerError::BeyondLoopback { found: host.chars().take(100).collect() }),
    }
}

fn listen(address: SocketAddr) -> Result<TcpListener, ServerError> {
    let open = || {
        let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
        // A server that was killed leaves connections in TIME_WAIT; its successor may have the port at once.
        #[cfg(unix)]
        socket.set_reuseaddr(true)?;
        socket.set_send_buffer_size(SEND_BUFFER)?;
        socket.bind(address)?;
        socket.listen(BACKLOG)
    };
    open().map_err(|source: std::io::Error| match source.kind() {
        std::io::ErrorKind::AddrInUse => {
            ServerError::PortInUse { address: address.ip(), port: address.port() }
        }
        _ => ServerError::Listen { address, source },
    })
}

impl Running {
    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Waits for Ctrl+C (or a request to end by the system), then stops.
    ///
    /// # Errors
    /// [`ServerError::System`] if signals cannot be received.
    pub fn wait(self) -> Result<(), ServerError> {
        if let Some(runtime) = &self.runtime {
            runtime.block_on(signal())?;
        }
        self.stop();
        Ok(())
    }

    /// Lands, closes the recording and every connection.
    pub fn stop(mut self) {
        self.shut_down();
    }

    fn shut_down(&mut self) {
        self.landing.store(true, Ordering::Relaxed);
        self.hub.close_all("the server stops");
        if self.flight.take().is_some_and(|flight| flight.join().is_err()) {
            tracing::error!("the flight thread failed; its message is above");
        }
        if let Some(shutdown) = self.shutdown.take() {
            // Refused only if the server task has ended already.
            let _ = shutdown.send(());
        }
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_timeout(SHUTDOWN_TIMEOUT);
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.shut_down();
    }
}

#[cfg(unix)]
async fn signal() -> std::io::Result<()> {
    use tokio::signal::unix::{SignalKind, signal};
    let mut terminate = signal(SignalKind::terminate())?;
    tokio::select! {
        pressed = tokio::signal::ctrl_c() => pressed,
        _ = terminate.recv() => Ok(()),
    }
}

#[cfg(not(unix))]
async fn signal() -> std::io::Result<()> {
    tokio::signal::ctrl_c().await
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_loopback_is_served() {
        for host in ["localhost", "127.0.0.1", "::1", "[::1]", "127.1.2.3"] {
            assert!(loopback(host).is_ok(), "{host}");
        }
        for host in ["0.0.0.0", "::", "192.168.1.5", "example.org", ""] {
            let error = loopback(host).unwrap_err().to_string();
            assert!(error.contains("anybody who reaches the port can fly"), "{host}: {error}");
        }
    }
}
