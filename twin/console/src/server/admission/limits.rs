//! The limits of a server, as one record, so that a test can shorten them.

use std::time::Duration;

/// Limits of a server. [`Limits::STANDARD`] holds the values that a served flight uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// A connection that has not sent the whole head of its next request within this time is closed.
    pub head: Duration,
    /// A request whose body has not arrived within this time is answered with 408.
    pub body: Duration,
    /// A connection that accepts no data for this long is closed.
    pub stalled: Duration,
    /// A WebSocket that sends nothing for half of this time is sent a ping; after the whole time without an answer it is closed.
    pub silent: Duration,
    /// Most TCP connections of a server.
    pub connections: usize,
    /// Most TCP connections from one address.
    pub connections_of_address: usize,
    /// Most clients: consoles, viewers and Foxglove together.
    pub clients: usize,
    /// Most clients from one address.
    pub clients_of_address: usize,
    /// The place of a page whose connection broke is kept for this long, so that the page can connect again.
    pub kept: Duration,
    /// The least time between two restarts.
    pub restart_gap: Duration,
}

impl Limits {
    /// The limits of a served flight.
    pub const STANDARD: Self = Self {
        // A browser sends the head of a request in one packet. The time also bounds how long a connection may idle between two requests.
        head: Duration::from_secs(10),
        // The longest body is one gain, less than 100 bytes.
        body: Duration::from_secs(10),
        stalled: Duration::from_secs(20),
        // Browsers answer pings without the page, also in a tab in the background.
        silent: Duration::from_secs(30),
        // 256 clients and 128 requests, and with the clients of Foxglove, which take three descriptors each, still fewer than the 1024
        // descriptors that most systems allow.
        connections: 384,
        connections_of_address: 352,
        clients: 256,
        clients_of_address: 240,
        // The console tries again after at most five seconds.
        kept: Duration::from_secs(10),
        // Nobody follows a flight that is shorter. A restart takes about 30 ms and begins a recording.
        restart_gap: Duration::from_secs(1),
    };
}
