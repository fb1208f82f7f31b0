//! A WebSocket client for tests that sends any bytes and answers nothing: handshake and frames are written and read by hand.

use std::fmt::Write as _;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};

use crate::patience::{PATIENCE, Patience};
use twin_console::server::Running;

/// Opcode of a close frame, RFC 6455 section 5.2.
const CLOSE: u8 = 0x8;

/// A WebSocket whose frames the test writes itself.
pub(super) struct Raw {
    stream: TcpStream,
    read: Vec<u8>,
}

/// One frame of the server.
pub(super) struct RawFrame {
    pub opcode: u8,
    pub payload: Vec<u8>,
}

/// Key and accepted key of the example in RFC 6455, section 1.3.
const KEY: &str = "dGhlIHNhbXBsZSBub25jZQ==";
const ACCEPTED: &str = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

/// Opens a WebSocket at `path`, with further headers. If the server refuses, the error is the HTTP status.
pub(super) fn upgrade(
    address: SocketAddr,
    path: &str,
    headers: &[(&str, &str)],
) -> Result<TcpStream, u16> {
    let mut stream = TcpStream::connect(address).expect("the server listens");
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    let mut request = format!(
        "GET {path} HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
        Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {KEY}\r\n"
    );
    if !headers.iter().any(|(name, _)| *name == "Host") {
        write!(request, "Host: {address}\r\n").unwrap();
    }
    for (name, value) in headers {
        write!(request, "{name}: {value}\r\n").unwrap();
    }
    stream.write_all(format!("{request}\r\n").as_bytes()).expect("the server reads");
    // A byte at a time, because the first frames may follow the head at once.
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).expect("an answer");
        head.push(byte[0]);
    }
    let head = String::from_utf8(head).expect("text");
    match head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status") {
        101 => {
            assert!(head.contains(ACCEPTED), "{head}");
            Ok(stream)
        }
        status => Err(status),
    }
}

/// The paths of every kind of client on the console's port, with the sub-protocol that it asks for.
pub(super) const KINDS: [(&str, &[(&str, &str)]); 3] =
    [("/ws", &[]), ("/", &[]), ("/viser", &[("Sec-WebSocket-Protocol", "viser-v1.1.1")])];

/// The sub-protocol of a Foxglove client.
pub(super) const FOXGLOVE: &[(&str, &str)] = &[("Sec-WebSocket-Protocol", "foxglove.sdk.v1")];

/// A place where a WebSocket may be opened.
pub(super) struct Door {
    pub address: SocketAddr,
    pub path: &'static str,
    pub headers: &'static [(&'static str, &'static str)],
}

/// Every kind of client of a server, Foxglove's too if its port is open.
pub(super) fn doors(running: &Running) -> Vec<Door> {
    let address = running.address();
    let mut doors: Vec<Door> = KINDS.map(|(path, headers)| Door { address, path, headers }).into();
    let foxglove = running.foxglove_address();
    doors.extend(foxglove.map(|address| Door { address, path: "/", headers: FOXGLOVE }));
    doors
}

impl Raw {
    pub(super) fn enter(door: &Door) -> Self {
        Self::connect(door.address, door.path, door.headers)
    }

    pub(super) fn connect(address: SocketAddr, path: &str, headers: &[(&str, &str)]) -> Self {
        Self { stream: upgrade(address, path, headers).expect(path), read: Vec::new() }
    }

    /// Writes these bytes as they are.
    pub(super) fn write(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).expect("the server reads");
    }

    fn need(&mut self, bytes: usize) -> bool {
        let mut buffer = [0; 8192];
        while self.read.len() < bytes {
            match self.stream.read(&mut buffer) {
                Ok(0) => return false,
                Ok(read) => self.read.extend(&buffer[..read]),
                Err(error) if error.kind() == ErrorKind::ConnectionReset => return false,
                Err(error) => panic!("nothing arrived for {PATIENCE:?}: {error}"),
            }
        }
        true
    }

    /// The next frame of the server, which masks nothing; `None` at the end of the stream.
    pub(super) fn frame(&mut self) -> Option<RawFrame> {
        self.need(2).then_some(())?;
        let opcode = self.read[0] & 0x0F;
        let (head, length) = match self.read[1] {
            126 => {
                self.need(4).then_some(())?;
                (4, usize::from(u16::from_be_bytes([self.read[2], self.read[3]])))
            }
            127 => {
                self.need(10).then_some(())?;
                let length = u64::from_be_bytes(self.read[2..10].try_into().unwrap());
                (10, usize::try_from(length).unwrap())
            }
            short => (2, usize::from(short)),
        };
        self.need(head + length).then_some(())?;
        let frame = self.read.drain(..head + length).skip(head).collect();
        Some(RawFrame { opcode, payload: frame })
    }

    /// Reads until the server closes; returns the close code, or `None` if the connection ended without a close frame.
    pub(super) fn close_code(&mut self) -> Option<u16> {
        let patience = Patience::new();
        while patience.lasts() {
            let frame = self.frame()?;
            if frame.opcode == CLOSE {
                return Some(u16::from_be_bytes([frame.payload[0], frame.payload[1]]));
            }
        }
        panic!("not closed within {PATIENCE:?}");
    }
}

/// A masked frame with the mask 0, which leaves the payload as it is.
pub(super) fn masked(first: u8, payload: &[u8]) -> Vec<u8> {
    assert!(payload.len() < 126);
    [&[first, 0x80 | payload.len() as u8, 0, 0, 0, 0], payload].concat()
}

/// The value of a line of `/metrics`, such as `twin_refused_total{reason="origin"}`.
pub(super) fn metric(address: SocketAddr, name: &str) -> f64 {
    let (status, answer) = super::console::http(address, "GET /metrics", "", "");
    assert_eq!(status, 200, "{answer}");
    let line = answer.lines().find_map(|line| line.strip_prefix(&format!("{name} ")));
    line.unwrap_or_else(|| panic!("{name} is not in {answer}")).parse().expect("a number")
}

/// The number of refusals for a reason.
pub(super) fn refused(address: SocketAddr, reason: &str) -> f64 {
    metric(address, &format!("twin_refused_total{{reason=\"{reason}\"}}"))
}
