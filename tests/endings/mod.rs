//! How the real program ends: by a signal, by a full disk, by `kill -9`, and what is in its files then.

mod disk;
mod killed;
mod recovered;
mod signals;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use super::folder::Folder;
use super::patience::until;

/// A hover that lasts longer than any test.
const LONG_HOVER: [&str; 5] =
    ["scenarios/hover.toml", "--set", "task.duration_s=3500", "--set", "time_limit_s=3600"];

/// The words that serve the long hover on any free port, recorded at `path`.
fn served_hover(path: &str) -> Vec<&str> {
    [&["fly"], &LONG_HOVER[..], &["--port", "0", "--speed", "max", "--record", path]].concat()
}

/// The program, and the words that a shell would take. `env` of coreutils gives the signals back their default action, because a caller
/// of the tests may ignore some: `nohup` does, and so does a shell for what it runs in the background.
fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP,INT,TERM", env!("CARGO_BIN_EXE_twin")]);
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR"));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn start(arguments: &[&str]) -> Child {
    command(arguments).spawn().expect("the program starts")
}

/// Sends a signal by its name. The shell has `kill`, whatever is installed.
fn signal(child: &Child, name: &str) {
    let kill = format!("kill -s {name} {}", child.id());
    let sent = Command::new("sh").args(["-c", &kill]).status().expect("a shell");
    assert!(sent.success(), "{kill}");
}

/// Waits until the program catches SIGTERM.
fn until_it_catches(child: &Child) {
    let status = format!("/proc/{}/status", child.id());
    until("the handlers of the signals", || {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let mask = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
            .is_some_and(|mask| mask >> 14 & 1 == 1)
    });
}

/// Waits until `path` has more than `bytes` bytes, so that the flight is in its middle.
fn until_it_has(path: &Path, bytes: u64) {
    until(&format!("{bytes} bytes in {}", path.display()), || {
        std::fs::metadata(path).is_ok_and(|meta| meta.len() > bytes)
    });
}

/// The end of the program: its exit code, its only JSON object, its messages.
fn ended(child: Child) -> (Option<i32>, serde_json::Value, String) {
    let Output { status, stdout, stderr } = child.wait_with_output().expect("it ends");
    let json = serde_json::from_slice(&stdout).unwrap_or_default();
    (status.code(), json, String::from_utf8_lossy(&stderr).into_owned())
}

/// Requires that a recording is finished: it has a summary that counts its messages, and every tick can be read. Returns its metadata.
fn finished(path: &Path) -> std::collections::BTreeMap<String, String> {
    let bytes = std::fs::read(path).expect("a recording");
    let summary = mcap::Summary::read(&bytes).expect("a summary").expect("it is there");
    assert!(summary.stats.is_some_and(|stats| stats.message_count > 0), "{}", path.display());
    let read = twin_record::read_recording(path).expect("it can be read");
    assert_eq!(read.warning, None);
    assert_eq!(read.metadata["ticks"], read.ticks.len().to_string());
    read.metadata
}
