//! Chooses the address on which the server listens: loopback only.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use tokio::net::{TcpListener, TcpSocket};

use crate::server::{AppOrigin, Limits, ServerError};
use twin_scenario::VehicleFiles;

/// Size of the kernel's send buffer, bytes. It is small, so that a slow client gets new rows instead of old ones.
const SEND_BUFFER: u32 = 64 * 1024;

/// Most connections that wait until the server accepts them.
const BACKLOG: u32 = 128;

/// The addresses of the servers, and the files that they serve.
pub(super) struct ListenOptions {
    /// A loopback name or address for both servers.
    pub host: String,
    /// Port of the console; 0 takes any free one.
    pub port: u16,
    /// Folder with the stock viewers.
    pub viewer_dir: Option<PathBuf>,
    /// Limits of both servers together.
    pub limits: Limits,
    /// The server for Foxglove; `None` starts none.
    pub foxglove: Option<Beside>,
}

/// The settings of the server for Foxglove.
pub(super) struct Beside {
    /// Its port; 0 takes any free one.
    pub port: u16,
    /// Pages that may use it, besides the known ones.
    pub origins: Vec<AppOrigin>,
    /// The vehicle of each scenario, by the scenario's name.
    pub vehicles: BTreeMap<String, VehicleFiles>,
    /// Names of the joints of a mirrored recording.
    pub recorded_joints: Vec<String>,
}

/// The address of `host`, which must be on the loopback interface.
///
/// # Errors
/// [`ServerError::BeyondLoopback`] for every other host.
pub(super) fn loopback(host: &str) -> Result<IpAddr, ServerError> {
    if host.eq_ignore_ascii_case("localhost") {
        return Ok(IpAddr::V4(Ipv4Addr::LOCALHOST));
    }
    match host.trim_matches(['[', ']']).parse::<IpAddr>() {
        Ok(address) if address.is_loopback() => Ok(address),
        _ => Err(ServerError::BeyondLoopback { found: host.chars().take(100).collect() }),
    }
}

/// Listens on `address`.
///
/// # Errors
/// [`ServerError::PortInUse`], or [`ServerError::Listen`] with the system's error.
pub(super) fn listen(address: SocketAddr) -> Result<TcpListener, ServerError> {
    bind(address).map_err(|source| match source.kind() {
        std::io::ErrorKind::AddrInUse => {
            ServerError::PortInUse { address: address.ip(), port: address.port() }
        }
        _ => ServerError::Listen { address, source },
    })
}

/// Listens on `address`, with a small send buffer for each connection.
///
/// # Errors
/// The system's error.
pub(super) fn bind(address: SocketAddr) -> std::io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // A killed server leaves connections in the state TIME_WAIT; with this option the next server gets the port at once.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(SEND_BUFFER)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
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
