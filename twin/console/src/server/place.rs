//! Where to listen: an address of this machine's loopback, and nothing else.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use tokio::net::{TcpListener, TcpSocket};

use crate::server::ServerError;
use twin_scenario::VehicleFiles;

/// Little is buffered in the kernel, so that a slow client sees new rows instead of old ones, bytes.
const SEND_BUFFER: u32 = 64 * 1024;

/// Connections that may wait to be accepted.
const BACKLOG: u32 = 128;

/// Where and what to serve besides the flight.
pub(super) struct Place {
    /// A loopback name or address.
    pub host: String,
    /// Port of the console; 0 takes any free one.
    pub port: u16,
    /// Folder with the stock viewers.
    pub viewer_dir: Option<PathBuf>,
    /// The server for Foxglove.
    pub foxglove: Option<Beside>,
}

/// What the server for Foxglove is told.
pub(super) struct Beside {
    /// Its port; 0 takes any free one.
    pub port: u16,
    /// The vehicle of each scenario, by the scenario's name.
    pub vehicles: BTreeMap<String, VehicleFiles>,
    /// Names of the joints of a mirrored recording.
    pub recorded_joints: Vec<String>,
}

/// The address of a host.
///
/// # Errors
/// [`ServerError::BeyondLoopback`] for every other.
pub(super) fn loopback(host: &str) -> Result<IpAddr, ServerError> {
    if host.eq_ignore_ascii_case("localhost") {
        return Ok(IpAddr::V4(Ipv4Addr::LOCALHOST));
    }
    match host.trim_matches(['[', ']']).parse::<IpAddr>() {
        Ok(address) if address.is_loopback() => Ok(address),
        _ => Err(ServerError::BeyondLoopback { found: host.chars().take(100).collect() }),
    }
}

/// Listens there.
///
/// # Errors
/// [`ServerError::PortInUse`], or [`ServerError::Listen`] with what the system said.
pub(super) fn listen(address: SocketAddr) -> Result<TcpListener, ServerError> {
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
