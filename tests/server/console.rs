//! A console for tests: a socket, the JSON messages and the telemetry frames, decoded by hand from the text of the protocol.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;

use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use crate::patience::{PATIENCE, Patience};
use twin_console::server::{Limits, Running, ServeOptions, spawn};
use twin_scenario::Scenario;

/// The scenario `name` with `overrides`.
pub(super) fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(format!("{name}.toml"));
    let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
    Scenario::load(&file, &overrides).expect(name)
}

/// A hover that lasts longer than any test.
pub(super) fn hover() -> Scenario {
    scenario("hover", &["time_limit_s=3600", "task.duration_s=3600"])
}

/// A flight of `hover` on a free port.
pub(super) fn options() -> ServeOptions {
    ServeOptions {
        scenario: hover(),
        catalogue: vec![hover(), scenario("a_300g_slow", &[])],
        host: "127.0.0.1".to_owned(),
        port: 0,
        speed: Some(1.0),
        start_paused: false,
        record: None,
        outputs: twin_record::Outputs::default(),
        viewer_dir: None,
        foxglove_port: None,
        foxglove_origins: Vec::new(),
        limits: Limits::STANDARD,
    }
}

pub(super) fn serve() -> Running {
    spawn(options()).expect("a free port")
}

/// One telemetry frame.
#[derive(Debug)]
pub(super) struct Frame {
    pub schema_id: u16,
    pub first_tick: u64,
    pub rows: Vec<Vec<f32>>,
    pub bodies: usize,
    pub gap: u64,
    pub reset: bool,
    pub t_s: f64,
}

impl Frame {
    pub(super) fn decode(bytes: &[u8]) -> Self {
        let u16_at = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(bytes[..2], [0xC1, 2], "magic and version");
        let (rows, channels) = (usize::from(u16_at(8)), usize::from(u16_at(10)));
        let (bodies, contacts) = (usize::from(u16_at(12)), usize::from(u16_at(14)));
        assert_eq!(
            bytes.len(),
            44 + 4 * (rows * channels + 7 * (bodies + 1) + 6 * contacts + usize::from(u16_at(40))),
            "length"
        );
        let float = |index: usize| f32::from_bits(u32_at(44 + 4 * index));
        Self {
            schema_id: u16_at(2),
            first_tick: u64::from(u32_at(4)),
            rows: (0..rows)
                .map(|r| (0..channels).map(|c| float(r * channels + c)).collect())
                .collect(),
            bodies,
            gap: u64::from(u32_at(16)),
            reset: u32_at(20) & 1 == 1,
            t_s: f64::from_le_bytes(bytes[24..32].try_into().unwrap()),
        }
    }

    pub(super) fn after(&self) -> u64 {
        self.first_tick + self.rows.len() as u64
    }
}

/// A message that arrived.
#[derive(Debug)]
pub(super) enum Arrival {
    Json(Value),
    Frame(Frame),
    Closed(Option<(u16, String)>),
}

pub(super) struct Console {
    socket: WebSocket<TcpStream>,
}

impl Console {
    pub(super) fn connect(address: SocketAddr) -> Self {
        Self::connect_from(address, None, &address.to_string()).expect("a connection")
    }

    /// Connects as a page of `origin` would; if the server refuses, the error is the HTTP status.
    pub(super) fn connect_from(
        address: SocketAddr,
        origin: Option<&str>,
        host: &str,
    ) -> Result<Self, u16> {
        let stream = TcpStream::connect(address).expect("the server listens");
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut request = format!("ws://{address}/ws").into_client_request().unwrap();
        request.headers_mut().insert("Host", host.parse().unwrap());
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Self { socket }),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
                Err(response.status().as_u16())
            }
            Err(other) => panic!("{other}"),
        }
    }

    pub(super) fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).expect("the server reads");
    }

    /// Sends a message, even if the server no longer reads; returns whether it was sent.
    pub(super) fn try_send(&mut self, message: Message) -> bool {
        self.socket.send(message).is_ok()
    }

    pub(super) fn next(&mut self) -> Arrival {
        match self.socket.read() {
            Ok(Message::Text(text)) => Arrival::Json(serde_json::from_str(&text).expect("JSON")),
            Ok(Message::Binary(bytes)) => Arrival::Frame(Frame::decode(&bytes)),
            Ok(Message::Close(frame)) => {
                Arrival::Closed(frame.map(|f| (u16::from(f.code), f.reason.to_string())))
            }
            Ok(_) => self.next(),
            // A read with a time-out ends with each signal of the process, even with one that restarts other calls.
            Err(tungstenite::Error::Io(error))
                if error.kind() == std::io::ErrorKind::Interrupted =>
            {
                self.next()
            }
            Err(tungstenite::Error::Io(error))
                if error.kind() == std::io::ErrorKind::WouldBlock =>
            {
                panic!("nothing arrived for {PATIENCE:?}")
            }
            Err(error) => {
                eprintln!("the connection broke: {error}");
                Arrival::Closed(None)
            }
        }
    }

    /// The next JSON message of the type `wanted`.
    pub(super) fn message(&mut self, wanted: &str) -> Value {
        self.message_that(wanted, |_| true)
    }

    /// The next JSON message of the type `wanted` for which `fits` is true.
    pub(super) fn message_that(&mut self, wanted: &str, fits: impl Fn(&Value) -> bool) -> Value {
        let patience = Patience::new();
        let mut last = Value::Null;
        while patience.lasts() {
            match self.next() {
                Arrival::Json(message) if message["type"] == wanted => {
                    if fits(&message) {
                        return message;
                    }
                    last = message;
                }
                Arrival::Closed(why) => panic!("closed while waiting for {wanted}: {why:?}"),
                _ => {}
            }
        }
        panic!("no {wanted} that fits within {PATIENCE:?}; the last was {last}");
    }

    /// The next telemetry frame.
    pub(super) fn frame(&mut self) -> Frame {
        let patience = Patience::new();
        while patience.lasts() {
            match self.next() {
                Arrival::Frame(frame) => return frame,
                Arrival::Closed(why) => panic!("closed while waiting for telemetry: {why:?}"),
                Arrival::Json(_) => {}
            }
        }
        panic!("no telemetry within {PATIENCE:?}");
    }

    /// Reads until the connection is closed; returns the notices before, and the code and reason of the close.
    pub(super) fn until_closed(&mut self) -> (Vec<String>, Option<(u16, String)>) {
        let mut notices = Vec::new();
        loop {
            match self.next() {
                Arrival::Json(message) if message["type"] == "notice" => {
                    notices.push(message["text"].to_string());
                }
                Arrival::Closed(why) => return (notices, why),
                _ => {}
            }
        }
    }
}

/// Sends one HTTP request on a connection of its own; returns the status and the whole answer.
pub(crate) fn http(address: SocketAddr, request: &str, headers: &str, body: &str) -> (u16, String) {
    let host =
        if headers.contains("Host:") { String::new() } else { format!("Host: {address}\r\n") };
    let length = body.len();
    let text = format!(
        "{request} HTTP/1.1\r\n{host}{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}"
    );
    let mut stream = TcpStream::connect(address).expect("the server listens");
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.write_all(text.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let answer = String::from_utf8_lossy(&answer).into_owned();
    (answer.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status"), answer)
}

/// The JSON body of a GET.
pub(crate) fn api(address: SocketAddr, path: &str) -> Value {
    let (status, answer) = http(address, &format!("GET {path}"), "", "");
    assert_eq!(status, 200, "{answer}");
    serde_json::from_str(answer.split_once("\r\n\r\n").expect("a body").1).expect("JSON")
}
