//! More clients than there are places.

use std::io::Read;
use std::net::TcpStream;
use std::time::Duration;

use super::console::{Console, http, options};
use super::raw::{FOXGLOVE, Raw, metric, refused, upgrade};
use crate::patience::{PATIENCE, until};
use twin_console::server::{Limits, Running, spawn};

fn serve(limits: Limits) -> Running {
    let mut crowded = options();
    crowded.limits = limits;
    crowded.foxglove_port = cfg!(feature = "foxglove-ws").then_some(0);
    spawn(crowded).expect("free ports")
}

#[test]
fn idle_connections_make_room_for_new_ones_and_open_sockets_do_not() {
    let limits = Limits { connections: 8, connections_of_address: 8, ..Limits::STANDARD };
    let running = serve(Limits { head: Duration::from_hours(1), ..limits });
    let address = running.address();
    let mut idle: Vec<TcpStream> =
        (0..8).map(|_| TcpStream::connect(address).expect("a place")).collect();
    until("all are open", || metric(address, "twin_connections") >= 8.0);
    // A page loads although all places are taken; the oldest idle connection ends.
    assert_eq!(http(address, "GET /api/health", "", "").0, 200);
    assert!(refused(address, "displaced") >= 1.0);
    idle[0].set_read_timeout(Some(PATIENCE)).unwrap();
    assert_eq!(idle[0].read(&mut [0]).expect("an end"), 0);
    drop(idle);

    let mut consoles: Vec<Console> = Vec::new();
    until("the idle ones are gone", || metric(address, "twin_connections") <= 1.0);
    consoles.extend((0..8).map(|_| Console::connect(address)));
    let mut refused_one = TcpStream::connect(address).expect("the kernel accepts");
    refused_one.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut answer = String::new();
    refused_one.read_to_string(&mut answer).expect("an answer");
    assert!(answer.starts_with("HTTP/1.1 503") && answer.contains("Retry-After"), "{answer}");
    consoles[0].frame();
    consoles.pop();
    until("a place is free again", || {
        TcpStream::connect(address).is_ok_and(|mut stream| {
            let asked = std::io::Write::write_all(
                &mut stream,
                format!("GET /metrics HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n")
                    .as_bytes(),
            );
            let mut answer = String::new();
            asked.is_ok()
                && stream.read_to_string(&mut answer).is_ok()
                && answer.contains("twin_refused_total{reason=\"address\"}")
        })
    });
}

#[test]
fn a_client_beyond_the_cap_is_told_to_try_later_and_a_page_gets_its_place_back() {
    let running = serve(Limits {
        clients: 4,
        clients_of_address: 4,
        kept: Duration::from_hours(1),
        ..Limits::STANDARD
    });
    let address = running.address();
    let page =
        |origin: &str| Console::connect_from(address, Some(origin), &address.to_string()).unwrap();
    let _stay = [1, 2, 3].map(|port| page(&format!("http://localhost:{port}")));
    let mut last = page("http://localhost:4");
    last.frame();
    for (to, headers) in [(Some(address), &[][..]), (running.foxglove_address(), FOXGLOVE)] {
        if let Some(to) = to {
            assert_eq!(Raw::connect(to, "/ws", headers).close_code(), Some(1013));
        }
    }
    // The connection of a page breaks. A stranger does not get its place, the page does.
    drop(last);
    until("the place is free", || metric(address, "twin_clients") <= 4.0);
    until("a stranger is refused and the page comes back", || {
        assert_eq!(Raw::connect(address, "/ws", &[]).close_code(), Some(1013));
        metric(address, "twin_connections") <= 4.0
    });
    page("http://localhost:4").frame();
    assert!(refused(address, "clients") >= 2.0);
}

#[cfg(feature = "foxglove-ws")]
#[test]
fn the_port_for_foxglove_takes_its_applications_and_pages_that_were_named() {
    let mut open = options();
    open.foxglove_port = Some(0);
    open.foxglove_origins = vec!["https://viewer.example".parse().expect("an origin")];
    let running = spawn(open).expect("free ports");
    let address = running.foxglove_address().expect("a port");
    let from = |origin: &str| upgrade(address, "/", &[FOXGLOVE[0], ("Origin", origin)]).map(|_| ());
    for known in [
        "https://app.foxglove.dev",
        "https://studio.foxglove.dev",
        "https://lichtblick-suite.github.io",
        "file://",
        "http://localhost:8080",
        "https://viewer.example",
    ] {
        assert_eq!(from(known), Ok(()), "{known}");
    }
    for foreign in ["https://evil.example", "null", "https://app.foxglove.dev.evil.example"] {
        assert_eq!(from(foreign), Err(403), "{foreign}");
    }
    assert!((refused(running.address(), "origin") - 3.0).abs() < 0.5);
    // A foreign name that points to this machine.
    assert_eq!(upgrade(address, "/", &[FOXGLOVE[0], ("Host", "evil.example")]).err(), Some(403));
    // A client of another protocol, and none at all.
    assert_eq!(upgrade(address, "/", &[("Sec-WebSocket-Protocol", "chat")]).err(), Some(400));
    assert_eq!(http(address, "GET /", "", "").0, 426);
}
