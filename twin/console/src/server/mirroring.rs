//! Serves a recording: from the options to the flight that plays it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use crate::server::flight_recorder::FlightRecorder;
use crate::server::listen::{Beside, ListenOptions};
use crate::server::mirrored::Mirrored;
use crate::server::pilot::{FirstFlight, PilotOptions};
use crate::server::running::{Running, Served, watch};
use crate::server::{AppOrigin, Limits, ServerError, launch};
use twin_foreign::{Forecaster, Live, OpenedFlight};
use twin_record::Outputs;

/// Options for serving a recording.
pub struct MirrorOptions {
    /// The recording.
    pub opened: OpenedFlight,
    /// What predicts beside it.
    pub forecaster: Forecaster,
    /// The live stream, if the flight still goes on.
    pub live: Option<Live>,
    /// Loopback name or address to listen on.
    pub host: String,
    /// Port to listen on; 0 takes any free one.
    pub port: u16,
    /// Seconds of the recording per second; `None` plays as fast as the machine can.
    pub speed: Option<f64>,
    /// Start time in the recording, s.
    pub start_s: f64,
    /// Pause before the first tick until an operator resumes.
    pub start_paused: bool,
    /// Folder with the stock viewers, as `twin viewers fetch` leaves it; `None` if there is none.
    pub viewer_dir: Option<PathBuf>,
    /// Port for Foxglove, 0 for any free one; `None` for no such server.
    pub foxglove_port: Option<u16>,
    /// Pages that may use the port for Foxglove, besides the known applications and the pages of this machine.
    pub foxglove_origins: Vec<AppOrigin>,
    /// Limits of connections, times and commands.
    pub limits: Limits,
}

/// Serves a recording until a signal asks the program to end.
///
/// # Errors
/// [`ServerError`] if the server cannot start.
pub fn serve_mirror(options: MirrorOptions) -> Result<Served, ServerError> {
    Ok(watch(spawn_mirror(options)?))
}

/// Serves a recording in the background.
///
/// # Errors
/// [`ServerError`] if the server cannot start.
pub fn spawn_mirror(options: MirrorOptions) -> Result<Running, ServerError> {
    let mirrored =
        Arc::new(Mirrored::new(&options.opened, options.live.map(Arc::new), &options.forecaster));
    let tuning = *mirrored.shadow.tuning();
    let orders = PilotOptions {
        mission: FirstFlight::Mirror { mirrored, start_s: options.start_s },
        catalogue: Vec::new(),
        speed: options.speed,
        start_paused: options.start_paused,
        flight_recorder: FlightRecorder::new(None, Outputs::default()),
        restart_gap: options.limits.restart_gap,
    };
    // A recording contains no model files of its vehicle, only the angles of its joints.
    let foxglove = options.foxglove_port.map(|port| Beside {
        port,
        origins: options.foxglove_origins,
        vehicles: BTreeMap::new(),
        recorded_joints: options.opened.recorded.joint_names.clone(),
    });
    let MirrorOptions { host, port, viewer_dir, limits, .. } = options;
    launch(orders, &tuning, true, ListenOptions { host, port, viewer_dir, limits, foxglove })
}
