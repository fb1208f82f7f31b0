//! The web server: one thread flies in real time, every client watches, operators change gains.
//!
//! In: a [`Scenario`]. Out: `/` (console), `/ws` (see [`protocol`] and [`telemetry`]), `/meshcat/` and `/viser` (the stock
//! viewers, see [`viewers`]), `/api/health`, `/api/state`, `/api/gains`; on a port of its own a server for Foxglove. The flight thread
//! (`pilot`) never waits for a socket; each client has its own bounded `outbox`.

mod twin_info;
mod fork_info;
mod gain_info;
pub mod protocol;
mod quantity_info;
mod gain_events;
mod gains;
mod command;
mod admission;
mod agenda;
pub mod channels;
pub mod telemetry;
mod pace;
mod published;
mod outbox;
mod hub;
mod world;
mod flight_recorder;
mod stream;
mod accept;
mod listen;
mod socket;
mod mirrored;
mod served_flight;
mod forks;
mod pilot;
mod requests;
mod client;
pub mod viewers;
mod assets;
mod metrics;
mod origin;
mod override_file;
mod http;
#[cfg_attr(not(feature = "foxglove-ws"), path = "no_foxglove.rs")]
mod foxglove;
mod running;
mod mirroring;

#[cfg(test)]
mod typescript;

pub use admission::Limits;
pub use mirroring::{MirrorOptions, serve_mirror, spawn_mirror};
pub use origin::AppOrigin;
pub use running::{Running, Served};

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Instant;

use tokio::sync::watch;

use crate::server::admission::Admission;
use crate::server::command::Request;
use crate::server::flight_recorder::FlightRecorder;
use crate::server::hub::Hub;
use crate::server::listen::{Beside, ListenOptions};
use crate::server::pilot::{FirstFlight, Pilot, PilotOptions};
use crate::server::protocol::ScenarioInfo;
use twin_core::tuning::Tuning;
use twin_record::{Outputs, RecordingError};
use twin_scenario::{BuildError, Preset, Scenario};

/// Largest number of requests that may wait for the flight.
const MOST_REQUESTS: usize = 1024;

/// Options for serving a flight.
pub struct ServeOptions {
    /// Scenario of the first flight.
    pub scenario: Scenario,
    /// Scenarios that a restart may name.
    pub catalogue: Vec<Scenario>,
    /// Loopback name or address to listen on.
    pub host: String,
    /// Port to listen on; 0 takes any free one.
    pub port: u16,
    /// Simulated seconds per second; `None` flies as fast as the machine can.
    pub speed: Option<f64>,
    /// Pause before the first tick until an operator resumes.
    pub start_paused: bool,
    /// MCAP file of the flight. If it exists, and for each restart, the recording takes the next free number.
    pub record: Option<PathBuf>,
    /// The outputs of this run.
    pub outputs: Outputs,
    /// Folder with the stock viewers, as `twin viewers fetch` leaves it; `None` if there is none.
    pub viewer_dir: Option<PathBuf>,
    /// Port for Foxglove, 0 for any free one; `None` for no such server.
    pub foxglove_port: Option<u16>,
    /// Pages that may use the port for Foxglove, besides the known applications and the pages of this machine.
    pub foxglove_origins: Vec<AppOrigin>,
    /// Limits of connections, times and commands.
    pub limits: Limits,
}

/// Why a flight cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The host is neither a name nor an address of this machine's loopback.
    #[error(
        "host {found:?} refused: anybody who reaches the port can fly; allowed: localhost, 127.0.0.1, ::1; use an ssh tunnel to watch from another machine"
    )]
    BeyondLoopback {
        /// Host that was given.
        found: String,
    },
    /// Another program listens on the address.
    #[error(
        "port {port} on {address} is in use, perhaps by another twin; choose another with --port, or 0 for any free one"
    )]
    PortInUse {
        /// The address.
        address: IpAddr,
        /// The port.
        port: u16,
    },
    /// The operating system refuses to listen on the address.
    #[error("cannot listen on {address}: {source}; choose another port with --port")]
    Listen {
        /// Address that was refused.
        address: SocketAddr,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The server for Foxglove cannot start.
    #[error("no server for Foxglove on port {port}: {why}; choose another with --foxglove-port")]
    Foxglove {
        /// The port.
        port: u16,
        /// Reason.
        why: String,
    },
    /// The flight cannot be built.
    #[error(transparent)]
    Scenario(#[from] BuildError),
    /// The recording cannot be created.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The operating system refuses a thread or signals.
    #[error("cannot start the server: {0}")]
    System(#[from] std::io::Error),
    /// The flight thread ended before it published anything.
    #[error("the flight ended before it began; run it with --headless to see why")]
    NoFlight,
}

/// State that all connections share.
struct App {
    hub: Arc<Hub>,
    scenarios: Arc<Vec<ScenarioInfo>>,
    /// Values inside their ranges, on which a change is tried.
    tuning: Tuning,
    /// True if a recording is mirrored.
    mirrored: bool,
    requests: SyncSender<Request>,
    viewer_dir: Option<PathBuf>,
    started: Instant,
    admission: Arc<Admission>,
}

impl App {
    /// Time since the server started, s.
    fn uptime_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Counts for `/metrics` that the flight does not publish.
    fn counts(&self) -> metrics::Counts {
        let tally = &self.hub.tally;
        metrics::Counts {
            connections: self.admission.connections.count(),
            restarts: tally.restarts.load(Ordering::Relaxed),
            coalesced: tally.coalesced.load(Ordering::Relaxed),
            refused: self.admission.refusals.list().collect(),
        }
    }
}

/// Serves a flight until a signal asks the program to end.
///
/// # Errors
/// [`ServerError`] if the server cannot start.
pub fn serve(options: ServeOptions) -> Result<Served, ServerError> {
    Ok(running::watch(spawn(options)?))
}

/// Serves a flight in the background.
///
/// # Errors
/// [`ServerError`] if the server cannot start.
pub fn spawn(options: ServeOptions) -> Result<Running, ServerError> {
    let known = std::iter::once(&options.scenario).chain(&options.catalogue);
    let vehicles = known
        .map(|known| Ok((known.name.clone(), known.vehicle_files()?)))
        .collect::<Result<BTreeMap<_, _>, BuildError>>()?;
    let place = ListenOptions {
        host: options.host,
        port: options.port,
        viewer_dir: options.viewer_dir,
        limits: options.limits,
        foxglove: options.foxglove_port.map(|port| Beside {
            port,
            origins: options.foxglove_origins,
            vehicles,
            recorded_joints: Vec::new(),
        }),
    };
    let tuning = options.scenario.preset_tuning(Preset::Tuned);
    let orders = PilotOptions {
        mission: FirstFlight::Fly(Box::new(options.scenario)),
        catalogue: options.catalogue,
        speed: options.speed,
        start_paused: options.start_paused,
        flight_recorder: FlightRecorder::new(options.record, options.outputs),
        restart_gap: options.limits.restart_gap,
    };
    launch(orders, &tuning, false, place)
}

/// Listens, starts the flight and serves it. Changes of gains are tried on `tuning`, whose values are in range.
fn launch(
    orders: PilotOptions,
    tuning: &Tuning,
    mirrored: bool,
    options: ListenOptions,
) -> Result<Running, ServerError> {
    let address = SocketAddr::new(listen::loopback(&options.host)?, options.port);
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    let listener = runtime.block_on(async { listen::listen(address) })?;
    let address = listener.local_addr()?;

    let (requests, inbox) = sync_channel(MOST_REQUESTS);
    let landing = Arc::new(AtomicBool::new(false));
    let (hub, flight) = take_off(orders, inbox, Arc::clone(&landing))?;
    let scenarios = hub.published().scenarios;
    let app = Arc::new(App {
        hub: Arc::clone(&hub),
        scenarios,
        tuning: *tuning,
        mirrored,
        requests,
        viewer_dir: options.viewer_dir,
        started: pace::now(),
        admission: Arc::new(Admission::new(options.limits)),
    });
    let router = http::router(Arc::clone(&app));
    let (shutdown, stopped) = watch::channel(false);
    runtime.spawn(accept::serve(listener, router, Arc::clone(&app.admission), stopped));
    let mut running = Running {
        address,
        foxglove: None,
        hub,
        landing,
        shutdown,
        flight: Some(flight),
        runtime: Some(runtime),
    };
    if let Some(beside) = options.foxglove {
        running.open_beside(beside, app)?;
    }
    Ok(running)
}

/// Starts the flight's thread. The thread also builds the flight, so no part of the flight has to move between threads.
fn take_off(
    orders: PilotOptions,
    inbox: Receiver<Request>,
    landing: Arc<AtomicBool>,
) -> Result<(Arc<Hub>, JoinHandle<bool>), ServerError> {
    let (ready, published) = sync_channel(1);
    let flight = std::thread::Builder::new().name("flight".to_owned()).spawn(move || {
        let (pilot, told) = match Pilot::new(orders) {
            Ok(pilot) => {
                let hub = pilot.hub();
                (Some(pilot), ready.send(Ok(hub)))
            }
            Err(error) => (None, ready.send(Err(error))),
        };
        match (pilot, told) {
            (Some(pilot), Ok(())) => pilot.fly(&inbox, &landing),
            _ => true,
        }
    })?;
    let hub = published.recv().map_err(|_| ServerError::NoFlight)??;
    Ok((hub, flight))
}
