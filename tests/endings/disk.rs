//! A disk that is full: the flight goes on, and everybody is told.

use std::net::SocketAddr;

use super::*;
use crate::patience::Patience;

/// Blocks of 512 bytes that a file may have: less than the recording of a hover.
const BLOCKS: u32 = 1000;

/// The program under a limit of the size of its files, which needs no rights, unlike a small disk.
fn limited(arguments: &[&str]) -> Command {
    let mut command = Command::new("sh");
    let limit = format!("ulimit -f {BLOCKS}; exec \"$0\" \"$@\"");
    command.args(["-c", &limit, env!("CARGO_BIN_EXE_twin")]).args(arguments);
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[test]
fn a_headless_flight_goes_on_and_fails_at_its_end() {
    let folder = Folder::new("full");
    let (path, whole) = (folder.text("f.mcap"), folder.text("whole.mcap"));
    let words = ["fly", "scenarios/hover.toml", "--headless", "--json", "--record", &path];
    let (code, json, said) = ended(limited(&words).spawn().expect("a shell"));
    assert_eq!(code, Some(1), "{said}");
    assert_eq!((&json["verdict"], &json["passed"]), (&"completed".into(), &true.into()), "{json}");
    let recording = &json["recording"];
    assert_eq!(recording["state"], "failed", "{json}");
    let error = recording["error"].as_str().expect("an error");
    assert!(error.contains("f.mcap") && error.contains("File too large"), "{error}");
    assert!(!error.contains("compression") && said.contains(error), "{said}");
    let [safe, dropped] = ["ticks", "dropped_ticks"].map(|key| recording[key].as_u64().expect(key));
    let flown = (json["flight_s"].as_f64().expect("s") / 0.01).round() as u64;
    assert!(safe > 0 && dropped > 0 && (safe + dropped).abs_diff(flown) <= 1, "{json}");
    // What was written can be mended, with every tick that the program called safe.
    let mended = command(&["recover", &path, "-o", &whole, "--json"]).output().expect("it ends");
    assert_eq!(mended.status.code(), Some(0), "{mended:?}");
    let read = twin_record::read_recording(Path::new(&whole)).expect("a recording");
    assert!(read.ticks.len() as u64 >= safe && read.warning.is_none());
}

#[test]
fn a_small_disk_is_named_with_its_cause_and_foreseen() {
    let folder = Folder::new("small");
    let disk = folder.path("disk");
    std::fs::create_dir_all(&disk).expect("a folder");
    let mount = format!("mount -t tmpfs -o size=1m tmpfs {}", disk.display());
    let mounted =
        Command::new("sh").args(["-c", &mount]).output().is_ok_and(|out| out.status.success());
    if !mounted {
        eprintln!(
            "no rights to mount a small disk; the limit of a file's size above stands for it"
        );
        return;
    }
    let path = disk.join("f.mcap").display().to_string();
    let child = start(&["fly", "scenarios/hover.toml", "--headless", "--json", "--record", &path]);
    let (code, json, said) = ended(child);
    let unmount = format!("umount {}", disk.display());
    assert!(
        Command::new("sh").args(["-c", &unmount]).status().is_ok_and(|status| status.success())
    );
    assert_eq!(code, Some(1), "{said}");
    let error = json["recording"]["error"].as_str().expect("an error");
    assert!(error.contains("No space left on device") && error.contains("f.mcap"), "{error}");
    assert!(said.contains("MB free"), "{said}");
}

#[test]
fn a_device_that_is_full_from_the_start_is_refused_before_the_flight() {
    let child = start(&["fly", "scenarios/hover.toml", "--headless", "--record", "/dev/full"]);
    let (code, _, said) = ended(child);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("/dev/full") && said.contains("No space left on device"), "{said}");
}

/// The text of `path` on the server.
fn get(address: SocketAddr, path: &str) -> String {
    crate::server::console::http(address, &format!("GET {path}"), "", "").1
}

#[test]
fn a_served_flight_goes_on_and_everybody_is_told() {
    let folder = Folder::new("served-full");
    let path = folder.text("f.mcap");
    let mut child = limited(&served_hover(&path)).spawn().expect("a shell");
    let mut said = std::io::BufReader::new(child.stderr.take().expect("its messages"));
    let address = address(&mut said);
    // Reads on, so that the program can always write.
    let said = std::thread::spawn(move || std::io::read_to_string(said).unwrap_or_default());
    until("the failure in the state", || {
        get(address, "/api/health").contains("\"state\":\"failed\"")
    });
    let health = get(address, "/api/health");
    assert!(health.contains("File too large") && health.contains("f.mcap"), "{health}");
    let metrics = get(address, "/metrics");
    assert!(metrics.contains("twin_recording_state{state=\"failed\"} 1"), "{metrics}");
    assert!(
        metrics.contains("twin_recording_bytes ")
            && metrics.contains("twin_recording_dropped_ticks ")
    );
    let tick = || {
        let body = get(address, "/api/state");
        let state = body.split("\r\n\r\n").nth(1).unwrap_or_default().to_owned();
        serde_json::from_str::<serde_json::Value>(&state)
            .ok()
            .and_then(|state| state["tick"].as_u64())
    };
    let (before, patience) = (tick().expect("a tick"), Patience::new());
    while tick().is_none_or(|now| now <= before + 50) {
        assert!(patience.lasts(), "the flight stopped with its recording");
    }
    signal(&child, "TERM");
    assert_eq!(child.wait().expect("it ends").code(), Some(1));
    let said = said.join().expect("text");
    assert!(said.contains("File too large") && said.contains("the flight goes on"), "{said}");
}

/// The address in the messages of a server.
pub(super) fn address(said: &mut impl std::io::BufRead) -> SocketAddr {
    let mut line = String::new();
    loop {
        line.clear();
        assert!(said.read_line(&mut line).is_ok_and(|bytes| bytes > 0), "no address was said");
        if let Some((_, rest)) = line.split_once("console on http://") {
            let plain: String =
                rest.chars().take_while(|c| c.is_ascii_digit() || ".:".contains(*c)).collect();
            return plain.parse().expect("an address");
        }
    }
}
