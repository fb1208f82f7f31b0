//! A server without descriptors: it waits, it does not spin, and it goes on when there are some again.

#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};

use super::raw::{metric, refused};
use crate::patience::until;

/// Descriptors of the process, and connections that are more than that.
const DESCRIPTORS: usize = 48;
const CONNECTIONS: usize = 120;

/// Most errors that the server counts while it pauses between them: six until the pause is a second long, then one in a second.
fn most_errors(uptime_s: f64) -> f64 {
    6.0 + 1.0 + uptime_s
}

struct Server(Child);

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn without_descriptors_the_server_waits_and_afterwards_it_goes_on() {
    let twin = env!("CARGO_BIN_EXE_twin");
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/hover.toml");
    let mut child = Command::new("sh")
        .arg("-c")
        .arg(format!("ulimit -n {DESCRIPTORS} && exec \"$0\" fly \"$1\" --port 0"))
        .args([twin, scenario])
        .args(["--set", "task.duration_s=3600", "--set", "time_limit_s=3600"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    let log = BufReader::new(child.stderr.take().expect("a pipe"));
    let _server = Server(child);
    let mut lines = log.lines().map_while(Result::ok);
    let address: SocketAddr = lines
        .find_map(|line| Some(line.split_once("console on http://")?.1.trim().to_owned()))
        .expect("the address")
        .parse()
        .expect("an address");
    // The log is read, so that the server does not wait for it.
    std::thread::spawn(move || lines.for_each(drop));
    let crowd: Vec<TcpStream> = (0..CONNECTIONS)
        .map(|_| TcpStream::connect(address).expect("the kernel accepts"))
        .collect();
    // The last connections wait in the kernel's queue while the server has no descriptor for them.
    std::thread::sleep(std::time::Duration::from_secs(2));
    drop(crowd);
    until("it goes on", || {
        TcpStream::connect(address).is_ok() && refused(address, "system") >= 1.0
    });
    let (errors, uptime_s) = (refused(address, "system"), metric(address, "twin_uptime_seconds"));
    assert!(errors <= most_errors(uptime_s), "{errors} errors in {uptime_s} s");
}
