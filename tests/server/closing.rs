//! Each breach of the protocol is answered with the close code that RFC 6455 gives it, on every path and on the port for Foxglove.

use super::console::{Console, options, serve};
use super::raw::{Door, KINDS, Raw, doors, masked, refused};
use twin_console::server::spawn;

/// Breaches with their close code and the reason in `/metrics`.
fn breaches() -> Vec<(&'static str, Vec<u8>, u16, &'static str)> {
    let too_long = [&[0x82, 0xFF][..], &(1_u64 << 20).to_be_bytes(), &[0; 4]].concat();
    vec![
        ("an unmasked frame", vec![0x81, 2, b'h', b'i'], 1002, "protocol"),
        ("a reserved bit", masked(0xC1, b""), 1002, "protocol"),
        ("an unknown data frame", masked(0x83, b""), 1002, "protocol"),
        ("an unknown control frame", masked(0x8B, b""), 1002, "protocol"),
        ("a ping in parts", masked(0x09, b""), 1002, "protocol"),
        ("a continuation of nothing", masked(0x80, b"x"), 1002, "protocol"),
        ("a close frame of one byte", masked(0x88, b"x"), 1002, "protocol"),
        ("text that is no UTF-8", masked(0x81, &[0xC3, 0x28]), 1007, "data"),
        ("a message that is too long", too_long, 1009, "length"),
    ]
}

#[test]
fn every_breach_is_answered_with_its_code_and_counted() {
    let mut with_foxglove = options();
    with_foxglove.foxglove_port = cfg!(feature = "foxglove-ws").then_some(0);
    let running = spawn(with_foxglove).expect("free ports");
    let mut counted = std::collections::BTreeMap::new();
    for door in doors(&running) {
        for (what, bytes, code, reason) in breaches() {
            let mut client = Raw::enter(&door);
            client.write(&bytes);
            let Door { address, path, .. } = door;
            assert_eq!(client.close_code(), Some(code), "{what} at {address}{path}");
            *counted.entry(reason).or_insert(0.0) += 1.0;
        }
    }
    for (reason, count) in counted {
        let found = refused(running.address(), reason);
        assert!((found - count).abs() < 0.5, "{reason}: {found}, expected {count}");
    }
    // The flight goes on, and so does an honest client.
    Console::connect(running.address()).frame();
}

#[test]
fn a_message_of_the_wrong_type_is_unsupported_and_one_of_the_wrong_content_is_invalid() {
    let running = serve();
    let address = running.address();
    let [console, meshcat, viser] = KINDS;
    for ((path, headers), bytes, code) in [
        // The console speaks text, viser speaks MessagePack. A lone 0xC1 is no MessagePack.
        (console, masked(0x82, b"\x01\x02"), 1003),
        (viser, masked(0x81, b"hello"), 1003),
        (viser, masked(0x82, b"\xC1"), 1007),
        (meshcat, masked(0x82, b"\xC1"), 1007),
    ] {
        let mut client = Raw::connect(address, path, headers);
        client.write(&bytes);
        assert_eq!(client.close_code(), Some(code), "{bytes:?} at {path}");
    }
    assert!((refused(address, "data") - 4.0).abs() < 0.5);
}

#[test]
fn a_client_that_goes_on_sending_a_long_message_still_learns_why_it_is_closed() {
    let running = serve();
    let mut client = Raw::connect(running.address(), "/ws", &[]);
    client.write(&[&[0x82, 0xFF][..], &(4_u64 << 20).to_be_bytes(), &[0; 4]].concat());
    // Without a reader at the other end this much would reset the connection and destroy the reason.
    client.write(&vec![7; 4 << 20]);
    assert_eq!(client.close_code(), Some(1009));
}
