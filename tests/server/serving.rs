//! The server itself: ports, pages, the HTTP interface.

use super::console::{Console, api, http, options, serve};
use twin_console::server::{ServerError, spawn};

#[test]
fn a_port_in_use_is_named_with_the_way_out() {
    let running = serve();
    let mut again = options();
    again.port = running.address().port();
    let error = spawn(again).map(|_| ()).expect_err("the port is taken");
    assert!(matches!(error, ServerError::PortInUse { .. }));
    let text = error.to_string();
    assert!(
        text.contains(&running.address().port().to_string()) && text.contains("--port"),
        "{text}"
    );
}

#[test]
fn listening_beyond_this_machine_is_refused_with_the_reason() {
    for host in ["0.0.0.0", "::", "192.0.2.1", "example.org"] {
        let mut open = options();
        open.host = host.to_owned();
        let text = spawn(open).map(|_| ()).expect_err(host).to_string();
        assert!(text.contains(host) && text.contains("can fly"), "{text}");
    }
}

#[test]
fn a_server_that_stops_says_so_and_frees_its_port_at_once() {
    let running = serve();
    let address = running.address();
    let mut console = Console::connect(address);
    console.message("hello");
    running.stop();
    let (_, why) = console.until_closed();
    assert!(why.is_none_or(|(code, _)| code == 1001));
    let mut again = options();
    again.port = address.port();
    let successor = spawn(again).expect("the port is free again");
    Console::connect(successor.address()).message("hello");
}

#[test]
fn every_answer_forbids_sniffing_and_foreign_content() {
    let running = serve();
    for path in ["/", "/api/state", "/api/health", "/no/such/page", "/../../etc/passwd"] {
        let (_, answer) = http(running.address(), &format!("GET {path}"), "", "");
        let head = answer.split("\r\n\r\n").next().unwrap().to_lowercase();
        assert!(head.contains("x-content-type-options: nosniff"), "{path}: {head}");
        assert!(head.contains("content-security-policy: default-src 'none'"), "{path}: {head}");
    }
    assert_eq!(http(running.address(), "GET /", "", "").0, 200);
    assert_eq!(http(running.address(), "GET /no/such/page", "", "").0, 404);
}

#[test]
fn the_http_interface_reads_and_sets_gains() {
    let running = serve();
    let address = running.address();
    let mut console = Console::connect(address);
    console.message("hello");
    let json = "Content-Type: application/json\r\n";
    let post = |body: &str| http(address, "POST /api/gains", json, body);
    let (status, answer) = post(r#"{"name":"leak","value":3.5}"#);
    assert_eq!(status, 202, "{answer}");
    assert_eq!(console.message("gain")["value"], 3.5);
    let unusable = [
        (r#"{"name":"leak","value":-3}"#, 422),
        (r#"{"name":"leak","value":1e300}"#, 422),
        (r#"{"name":"nose","value":1}"#, 422),
        (r#"{"name":"leak","value":NaN}"#, 400),
        (r#"{"name":"leak"}"#, 422),
        ("", 400),
    ];
    for (body, status) in unusable {
        let (found, answer) = post(body);
        assert_eq!(found, status, "{body}: {answer}");
        assert!(answer.contains("\"error\""), "{body}: {answer}");
    }
    assert_eq!(api(address, "/api/health")["status"], "ok");
    assert_eq!(api(address, "/api/state")["phase"], "flying");
}
