//! Misuse that must not harm the flight or other clients.

use tungstenite::Message;

use super::console::{Console, http, serve};
use super::raw::refused;
use crate::patience::{PATIENCE, Patience};

/// Asserts that the flight continues and that this console still receives it.
fn still_flies(console: &mut Console) {
    let start = console.frame().after();
    while console.frame().after() < start + 20 {}
}

#[test]
fn messages_that_mean_nothing_are_answered_to_their_sender_alone() {
    let running = serve();
    let (mut sender, mut other) =
        (Console::connect(running.address()), Console::connect(running.address()));
    let messages = [
        "",
        "{",
        "null",
        "[]",
        "42",
        r#"{"type":"fly_away"}"#,
        r#"{"type":"set_gain"}"#,
        r#"{"type":"set_gain","name":"slope.x","value":NaN}"#,
        r#"{"type":"set_gain","name":"slope.x","value":null}"#,
        r#"{"type":"set_gain","name":"slope.x","value":"2"}"#,
        r#"{"type":"set_gain","name":"slope.x","value":-1}"#,
        r#"{"type":"set_gain","name":"slope.x","value":1e308}"#,
        r#"{"type":"set_gain","name":"slope.x","value":1e999}"#,
        r#"{"type":"set_gain","name":"slope.nose","value":1}"#,
        r#"{"type":"pause","paused":true,"extra":1}"#,
        r#"{"type":"preset","name":"custom"}"#,
        r#"{"type":"step","ticks":-1}"#,
        r#"{"type":"restart","scenario":"../../../etc/passwd"}"#,
        r#"{"type":"disturb","disturbance":{"kind":"wind","velocity_m_s":[1e9,0,0]}}"#,
        "\u{0}\u{feff}\u{1F680}",
        &"[".repeat(10_000),
    ];
    for text in messages {
        sender.send(text);
        let notice = sender.message("notice");
        assert_eq!(notice["level"], "warning", "{text}");
        assert!(!notice["text"].as_str().unwrap().is_empty());
    }
    other.send(r#"{"type":"ping","t":5}"#);
    let patience = Patience::new();
    loop {
        assert!(patience.lasts(), "no pong within {PATIENCE:?}");
        if let super::console::Arrival::Json(message) = other.next() {
            assert_ne!(message["type"], "notice", "a notice reached another client");
            assert_ne!(message["type"], "gain", "a refused gain took effect");
            if message["type"] == "pong" {
                break;
            }
        }
    }
    still_flies(&mut other);
    still_flies(&mut sender);
}

#[test]
fn a_message_that_is_too_long_ends_its_own_connection_only() {
    let running = serve();
    let (mut sender, mut other) =
        (Console::connect(running.address()), Console::connect(running.address()));
    sender.try_send(Message::text("x".repeat(65 * 1024)));
    let (code, reason) = sender.until_closed().1.expect("a reason");
    assert_eq!(code, 1009, "{reason}");
    assert!(reason.contains("64 KiB"), "{reason}");
    still_flies(&mut other);
}

#[test]
fn a_flood_is_warned_then_closed_and_others_do_not_notice() {
    let running = serve();
    let (mut flooder, mut other) =
        (Console::connect(running.address()), Console::connect(running.address()));
    for n in 0..5000 {
        if !flooder.try_send(Message::text(format!(r#"{{"type":"ping","t":{n}}}"#))) {
            break;
        }
    }
    let (notices, why) = flooder.until_closed();
    assert!(notices.iter().any(|text| text.contains("slow down")), "{notices:?}");
    assert_eq!(why.expect("a reason").0, 1008);
    assert!(refused(running.address(), "rate") >= 2.0);
    still_flies(&mut other);
}

#[test]
fn pages_from_elsewhere_are_refused() {
    let running = serve();
    let address = running.address();
    let host = address.to_string();
    for origin in ["http://evil.example", "null", "https://localhost.evil.example"] {
        assert_eq!(
            Console::connect_from(address, Some(origin), &host).err(),
            Some(403),
            "{origin}"
        );
    }
    // DNS rebinding: the name of a foreign page resolves to this server, so Origin and Host agree.
    assert_eq!(
        Console::connect_from(address, Some("http://evil.example"), "evil.example").err(),
        Some(403)
    );
    for origin in [None, Some("http://localhost:1234"), Some("http://127.0.0.1:8080")] {
        assert!(Console::connect_from(address, origin, &host).is_ok(), "{origin:?}");
    }
    let json = "Content-Type: application/json\r\n";
    let gain = r#"{"name":"slope.x","value":1.5}"#;
    let (status, _) =
        http(address, "POST /api/gains", &format!("{json}Origin: http://evil.example\r\n"), gain);
    assert_eq!(status, 403);
    // A form on a foreign page can send text without a preflight request.
    let (status, _) = http(address, "POST /api/gains", "Content-Type: text/plain\r\n", gain);
    assert_eq!(status, 415);
    assert_eq!(http(address, "GET /api/state", "Host: evil.example\r\n", "").0, 403);
}
