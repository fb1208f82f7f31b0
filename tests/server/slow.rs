//! Clients that are slow on purpose: a head byte by byte, a body that never comes, a reader that reads nothing, a socket that answers no
//! ping. Each loses its connection within the server's limits, which these tests shorten.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use super::console::{Console, http, options};
use super::raw::{Raw, doors, refused};
use crate::patience::{PATIENCE, until};
use twin_console::server::{Limits, Running, spawn};

/// A limit that passes soon on any machine.
const SOON: Duration = Duration::from_millis(300);

/// A limit that does not pass during a test.
const NEVER: Duration = Duration::from_hours(1);

/// Limits that never pass; a test shortens one of them.
const PATIENT: Limits =
    Limits { head: NEVER, body: NEVER, stalled: NEVER, silent: NEVER, ..Limits::STANDARD };

fn serve(limits: Limits) -> Running {
    let mut short = options();
    short.limits = limits;
    short.foxglove_port = cfg!(feature = "foxglove-ws").then_some(0);
    spawn(short).expect("free ports")
}

fn connect(running: &Running) -> TcpStream {
    let stream = TcpStream::connect(running.address()).expect("the server listens");
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    stream
}

/// Reads to the end; a reset counts as the end.
fn rest(stream: &mut TcpStream) -> String {
    let mut bytes = Vec::new();
    if let Err(error) = stream.read_to_end(&mut bytes) {
        assert_eq!(error.kind(), std::io::ErrorKind::ConnectionReset);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn a_head_that_comes_byte_by_byte_or_not_at_all_ends_the_connection() {
    let running = serve(Limits { head: SOON, ..PATIENT });
    let mut silent = connect(&running);
    let mut slow = connect(&running);
    let mut head = "GET / HTTP/1.1\r\nX-Long: ".bytes().chain(std::iter::repeat(b'x'));
    until("the slow head is given up", || {
        std::thread::sleep(SOON / 10);
        slow.write_all(&[head.next().expect("endless")]).is_err()
    });
    assert_eq!(rest(&mut silent), "");
    until("both are counted", || refused(running.address(), "head_timeout") >= 2.0);
}

#[test]
fn a_connection_that_idles_after_its_answer_ends() {
    let running = serve(Limits { head: SOON, ..PATIENT });
    let mut idle = connect(&running);
    write!(idle, "GET /api/health HTTP/1.1\r\nHost: {}\r\n\r\n", running.address()).unwrap();
    assert!(rest(&mut idle).starts_with("HTTP/1.1 200"));
}

#[test]
fn a_body_that_never_comes_is_answered_with_408() {
    let running = serve(Limits { body: SOON, ..PATIENT });
    let mut slow = connect(&running);
    let head = "Content-Type: application/json\r\nContent-Length: 40\r\n\r\n{\"name\":";
    write!(slow, "POST /api/gains HTTP/1.1\r\nHost: {}\r\n{head}", running.address()).unwrap();
    let answer = rest(&mut slow);
    assert!(answer.starts_with("HTTP/1.1 408"), "{answer}");
    assert!((refused(running.address(), "body_timeout") - 1.0).abs() < 0.5);
}

#[test]
fn a_reader_that_takes_no_answer_ends() {
    let running = serve(Limits { stalled: SOON, ..PATIENT });
    let mut greedy = connect(&running);
    let request = format!("GET /api/gains HTTP/1.1\r\nHost: {}\r\n\r\n", running.address());
    until("the server gives up", || greedy.write_all(request.as_bytes()).is_err());
    until("it is counted", || refused(running.address(), "stalled") >= 1.0);
}

#[test]
fn a_socket_that_answers_no_ping_is_closed_on_every_path() {
    let running = serve(Limits { silent: 2 * SOON, ..PATIENT });
    let doors = doors(&running);
    for door in &doors {
        // It reads everything, but it answers nothing.
        let mut mute = Raw::enter(door);
        assert_eq!(mute.close_code(), Some(1008), "{}{}", door.address, door.path);
    }
    assert!((refused(running.address(), "silent") - doors.len() as f64).abs() < 0.5);
}

#[test]
fn a_client_that_answers_pings_stays_although_it_says_nothing_else() {
    let running = serve(Limits { silent: SOON, ..PATIENT });
    // It reads, and tungstenite answers pings when it reads.
    let mut quiet = Console::connect(running.address());
    let start = quiet.frame().after();
    while quiet.frame().after() < start + 200 {}
    assert!(refused(running.address(), "silent") < 0.5);
    let (status, _) = http(running.address(), "GET /api/health", "", "");
    assert_eq!(status, 200);
}
